//! `host-sim pick`.

mod bending;
mod gaps;
mod text;

use std::path::Path;

use serde::Serialize;
use serde_json::{Map, Value};
use shared::model::params::PRESETS;

use super::arguments::choice::Cart;
use super::arguments::output::{Format, OutputArgs, to_json};
use super::arguments::request::object;
use super::arguments::rig::{CartArg, RigArgs};
use crate::pictures::drawn;
use crate::pictures::pick::figure;
use crate::progress::Progress;
use crate::words::pick::Worded;
use files::UserError;
use files::table::to_csv;
use numerics::NamedRig;
use numerics::pick::uncertainty::Uncertainty;
use numerics::pick::{Answer, CartModel, Limits, Pick, pick_on, steps};
use numerics::row::regime_as_text;
use shared::model::regime::Regime;

#[derive(Debug, clap::Args)]
pub struct Args {
    /// All four rigs side by side
    #[arg(long, conflicts_with = "rig")]
    all: bool,

    /// Pick at each of these gaps (mm), and advise at which to run
    #[arg(long, value_name = "FROM:TO:STEP", allow_hyphen_values = true, conflicts_with_all = ["all", "gap"])]
    gaps: Option<String>,

    /// With --gaps: random initial conditions per gap, for the share that settles on the orbit picked
    #[arg(long, value_name = "N", default_value_t = 400, requires = "gaps")]
    starts: u32,

    /// Take the parameters as exact
    #[arg(long, conflicts_with_all = [
        "natural_frequency_percent", "amplitude_percent", "contact_stiffness_percent",
        "contact_damping_percent", "gap_tolerance_mm", "samples", "seed",
    ])]
    nominal: bool,

    /// Largest contact force allowed, N
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    max_force_n: Option<f64>,

    /// Largest drive frequency allowed, Hz
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    max_frequency_hz: Option<f64>,

    /// Largest force the shaker can give to move cart and hammer, N
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    max_drive_force_n: Option<f64>,

    /// Uncertainty of the natural frequency, % either way
    #[arg(
        long,
        value_name = "P",
        default_value_t = 2.0,
        allow_negative_numbers = true
    )]
    natural_frequency_percent: f64,

    /// Uncertainty of the cart amplitude, % either way
    #[arg(
        long,
        value_name = "P",
        default_value_t = 5.0,
        allow_negative_numbers = true
    )]
    amplitude_percent: f64,

    /// Uncertainty of the contact stiffness, % either way
    #[arg(
        long,
        value_name = "P",
        default_value_t = 20.0,
        allow_negative_numbers = true
    )]
    contact_stiffness_percent: f64,

    /// Uncertainty of the contact damping, % either way
    #[arg(
        long,
        value_name = "P",
        default_value_t = 20.0,
        allow_negative_numbers = true
    )]
    contact_damping_percent: f64,

    /// Uncertainty of the gap, mm either way
    #[arg(
        long,
        value_name = "MM",
        default_value_t = 0.05,
        allow_negative_numbers = true
    )]
    gap_tolerance_mm: f64,

    /// Random rigs within the uncertainty, in addition to its corners
    #[arg(long, value_name = "N", default_value_t = 256)]
    samples: u32,

    /// Seed of the random rigs
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    #[command(flatten)]
    rig: RigArgs,

    #[command(flatten)]
    cart: CartArg,

    #[command(flatten)]
    springs: bending::SpringsArgs,

    #[command(flatten)]
    pub output: OutputArgs,
}

pub fn run(args: &Args) -> Result<(), UserError> {
    let output = &args.output;
    output.check()?;
    let limits = limits(args)?;
    let springs = args.springs.springs()?;
    let uncertainty = uncertainty(args)?;
    if let Some(text) = &args.gaps {
        let gaps = gaps::Gaps {
            text,
            springs,
            starts: args.starts,
            seed: args.seed,
        };
        let rig = moved(args.cart, args.rig.load()?)?;
        let output = output.about([&rig])?;
        let output = output.with_uncertainty(uncertainty.map(stated));
        return gaps::run(&rig, &output, &gaps, uncertainty, limits);
    }
    let names: Vec<&str> = if args.all {
        PRESETS.iter().map(|(name, _)| *name).collect()
    } else {
        vec![args.rig.name.name()]
    };
    let rigs = names.iter().map(|name| load(args, output, name));
    let rigs: Vec<NamedRig> = rigs.collect::<Result<_, _>>()?;
    let output = &output
        .about(&rigs)?
        .with_uncertainty(uncertainty.map(stated));
    let progress = Progress::new(
        "rigs tried",
        steps(uncertainty) * rigs.len() as u64,
        output.quiet,
    );
    let picks = rigs
        .iter()
        .map(|rig| pick_on(rig, springs, uncertainty, limits, &progress));
    let picks: Vec<Pick> = picks.collect::<Result<_, _>>()?;
    progress.finish();
    if let Some(dir) = &output.out {
        write(output, dir, &picks)?;
    }
    let rows: Vec<_> = picks.iter().map(|p| Line::from(&p.answer)).collect();
    output.emit(&json(&picks)?, &rows, || text::text(&picks))
}

/// The uncertainty as an answer carries it.
fn stated(u: Uncertainty) -> Map<String, Value> {
    object([
        ("natural_frequency_percent", u.natural_frequency_percent),
        ("amplitude_percent", u.amplitude_percent),
        ("contact_stiffness_percent", u.contact_stiffness_percent),
        ("contact_damping_percent", u.contact_damping_percent),
        ("gap_tolerance_mm", u.gap_mm),
        ("samples", f64::from(u.samples)),
        ("seed", u.seed as f64),
    ])
}

/// The rig `name`, at a gap of 0 unless the command line sets one.
fn load(args: &Args, output: &OutputArgs, name: &str) -> Result<NamedRig, UserError> {
    let mut rig = moved(args.cart, args.rig.load_named(name)?)?;
    if !args.rig.sets_gap() {
        default_to_zero_gap(&mut rig, output);
    }
    Ok(rig)
}

/// `rig` with the cart asked for; without one, that of the machine: recoiling where its shaker is known.
fn moved(cart: CartArg, rig: NamedRig) -> Result<NamedRig, UserError> {
    match cart.chosen() {
        None => Ok(rig.recoiling().unwrap_or(rig)),
        Some(Cart::Prescribed | Cart::Recoil) => cart.apply(rig),
    }
}

/// Sets the gap to 0.0 mm, at which the hammer is used in the field, and says so if the rig had another one.
fn default_to_zero_gap(rig: &mut NamedRig, output: &OutputArgs) {
    if rig.params.gap_m == 0.0 {
        return;
    }
    output.note(&format!(
        "note: rig {} has a gap of {:?} mm; picking at 0.0 mm (set --gap to keep it)",
        rig.name,
        numerics::row::tidy(rig.params.gap_m * 1e3)
    ));
    rig.params.gap_m = 0.0;
}

fn limits(args: &Args) -> Result<Limits, UserError> {
    let check = |name: &str, value: Option<f64>| match value {
        Some(x) if !(x > 0.0 && x.is_finite()) => Err(UserError::new(format!(
            "{name} is {x}, must be a positive number"
        ))),
        _ => Ok(value),
    };
    Ok(Limits {
        max_force_n: check("--max-force-n", args.max_force_n)?,
        max_frequency_hz: check("--max-frequency-hz", args.max_frequency_hz)?,
        max_drive_force_n: check("--max-drive-force-n", args.max_drive_force_n)?,
        max_loop_force_n: None,
    })
}

fn uncertainty(args: &Args) -> Result<Option<Uncertainty>, UserError> {
    let half_width = |name: &str, value: f64, below: f64| {
        if (0.0..below).contains(&value) {
            return Ok(value);
        }
        Err(UserError::new(format!(
            "{name} is {value}, must be from 0 to below {below}"
        )))
    };
    let uncertainty = Uncertainty {
        natural_frequency_percent: half_width(
            "--natural-frequency-percent",
            args.natural_frequency_percent,
            50.0,
        )?,
        amplitude_percent: half_width("--amplitude-percent", args.amplitude_percent, 90.0)?,
        contact_stiffness_percent: half_width(
            "--contact-stiffness-percent",
            args.contact_stiffness_percent,
            90.0,
        )?,
        contact_damping_percent: half_width(
            "--contact-damping-percent",
            args.contact_damping_percent,
            100.0,
        )?,
        gap_mm: half_width("--gap-tolerance-mm", args.gap_tolerance_mm, 10.0)?,
        samples: args.samples,
        seed: args.seed,
    };
    if args.samples > 100_000 {
        return Err(UserError::new(format!(
            "--samples is {}, must be at most 100000",
            args.samples
        )));
    }
    Ok((!args.nominal).then_some(uncertainty))
}

fn write(output: &OutputArgs, dir: &Path, picks: &[Pick]) -> Result<(), UserError> {
    let name = output.name("");
    let mut contents = drawn(&name, &figure(picks))?;
    contents.push((format!("{name}.json"), to_json(&json(picks)?)?.into_bytes()));
    let rows: Vec<_> = picks.iter().flat_map(curve_rows).collect();
    contents.push((format!("{name}-curve.csv"), to_csv(&rows)));
    if output.format == Format::Parquet {
        let lines: Vec<_> = picks.iter().map(|p| Line::from(&p.answer)).collect();
        contents.push((format!("{name}.parquet"), output.parquet(&lines)?));
        contents.push((format!("{name}-curve.parquet"), output.parquet(&rows)?));
    }
    output.write(dir, contents)
}

/// One answer as an object, several as a list.
fn json(picks: &[Pick]) -> Result<serde_json::Value, UserError> {
    let value = match picks {
        [one] => serde_json::to_value(Worded::from(&one.answer)),
        _ => {
            let worded = picks.iter().map(|p| Worded::from(&p.answer));
            serde_json::to_value(worded.collect::<Vec<_>>())
        }
    };
    value.map_err(|e| UserError::new(format!("cannot write JSON: {e}")))
}

/// A point of the nominal stable 1/1.
#[derive(Serialize)]
struct CurveRow<'a> {
    rig: &'a str,
    gap_mm: f64,
    frequency_hz: f64,
    force_ratio: f64,
}

fn curve_rows(pick: &Pick) -> Vec<CurveRow<'_>> {
    let answer = &pick.answer;
    let rows = pick
        .curve
        .iter()
        .map(|(frequency_hz, force_ratio)| CurveRow {
            rig: &answer.rig,
            gap_mm: answer.gap_mm,
            frequency_hz: *frequency_hz,
            force_ratio: *force_ratio,
        });
    rows.collect()
}

/// The answer as one CSV line.
#[derive(Serialize)]
struct Line<'a> {
    rig: &'a str,
    gap_mm: f64,
    operating_frequency_hz: f64,
    frequency_ratio: f64,
    #[serde(serialize_with = "regime_as_text")]
    regime: Regime,
    force_ratio: f64,
    force_n: f64,
    force_ratio_worst: f64,
    band_low_hz: f64,
    band_high_hz: f64,
    safe_band_low_hz: f64,
    safe_band_high_hz: f64,
    period_doubling_hz: Option<f64>,
    multipliers: f64,
    jump_free: bool,
    force_ratio_at_natural_frequency: f64,
    energy_per_blow_j: f64,
    blows_per_second: f64,
    cart: CartModel,
    recoil_force_ratio: Option<f64>,
    recoil_frequency_hz: Option<f64>,
    prescribed_force_ratio: Option<f64>,
    prescribed_frequency_hz: Option<f64>,
    amplitude_mm: f64,
    loop_force_n: Option<f64>,
    modes: Option<usize>,
    modes_force_ratio: Option<f64>,
    modes_force_ratio_worst: Option<f64>,
    one_mode_safe_band_low_hz: Option<f64>,
    one_mode_safe_band_high_hz: Option<f64>,
}

impl<'a> From<&'a Answer> for Line<'a> {
    fn from(a: &'a Answer) -> Self {
        Self {
            rig: &a.rig,
            gap_mm: a.gap_mm,
            operating_frequency_hz: a.operating_frequency_hz,
            frequency_ratio: a.frequency_ratio,
            regime: a.regime,
            force_ratio: a.force_ratio,
            force_n: a.force_n,
            force_ratio_worst: a.force_ratio_worst,
            band_low_hz: a.band_hz[0],
            band_high_hz: a.band_hz[1],
            safe_band_low_hz: a.safe_band_hz[0],
            safe_band_high_hz: a.safe_band_hz[1],
            period_doubling_hz: a.period_doubling_hz,
            multipliers: a.multipliers,
            jump_free: a.jump_free,
            force_ratio_at_natural_frequency: a.force_ratio_at_natural_frequency,
            energy_per_blow_j: a.shaker.energy_per_blow_j,
            blows_per_second: a.shaker.blows_per_second,
            cart: a.cart,
            recoil_force_ratio: a.recoil_force_ratio,
            recoil_frequency_hz: a.recoil_frequency_hz,
            prescribed_force_ratio: a.prescribed_force_ratio,
            prescribed_frequency_hz: a.prescribed_frequency_hz,
            amplitude_mm: a.amplitude_mm,
            loop_force_n: a.shaker.loop_force_n,
            modes: a.bending.modes,
            modes_force_ratio: a.bending.modes_force_ratio,
            modes_force_ratio_worst: a.bending.modes_force_ratio_worst,
            one_mode_safe_band_low_hz: a.bending.one_mode_safe_band_hz.map(|hz| hz[0]),
            one_mode_safe_band_high_hz: a.bending.one_mode_safe_band_hz.map(|hz| hz[1]),
        }
    }
}
