//! `host-sim pick`.

mod bending;
mod beside;
mod gaps;
mod line;
pub(super) mod measure_first;
mod over;
mod report;
mod rop;
mod text;

use std::path::PathBuf;

use plot::Figure;
use serde::Serialize;
use serde_json::{Map, Value};
use shared::model::params::PRESETS;

use super::arguments::choice::Objective;
use super::arguments::ground::GroundArgs;
use super::arguments::output::{OutputArgs, no_json, replaced, to_json};
use super::arguments::over::{OverOption, parse_over};
use super::arguments::request::object;
use super::arguments::rig::{CartArg, RigAtGaps};
use super::arguments::uncertainty::UncertaintyArgs;
use crate::pictures::pick::figure;
use crate::progress::ProgressLine;
use files::UserError;
use files::decimal::comma;
use files::range::positive;
use files::table::{Selection, to_csv};
use files::words::pick::WordedPick;
use line::{COLUMNS, curve_rows};
use numerics::NamedRig;
use numerics::PickLimits;
use numerics::drill::pick::DrillPickRequest;
use numerics::pick::{Pick, pick_for_force, pick_on, steps};
use numerics::uncertainty::Uncertainty;

/// Random starts per gap, if nothing else is asked for.
const STARTS: u32 = 400;

/// Find the frequency to run at: the strongest stable 1/1, with safe band, margins and the demands on the shaker
#[derive(Debug, clap::Args)]
#[command(
    after_help = "On two cores a rig, a gap of --gap or a value of --over takes 1 to 2 s, --objective rop 7 s.\n\nExamples:\n  host-sim pick\n  host-sim pick --rig mine.toml --report mine.html\n  host-sim pick --max-force-n 70 --max-frequency-hz 3.5\n  host-sim pick --beside wires,amplitude_mm=1.2\n  host-sim pick --gap 0:2.4:0.4\n  host-sim pick --over contact_stiffness_n_per_m=1e6:1e7:log5\n  host-sim pick --objective rop --threshold-n 50"
)]
#[command(mut_arg("gaps", |gaps| gaps.help("Clearance at rest, mm [default: 0.0, not the rig's]. FROM:TO:STEP, or several: pick at each, and recommend one")))]
pub struct Args {
    /// All four rigs side by side
    #[arg(long, conflicts_with = "rig")]
    all: bool,

    /// Another rig, or a rig with other settings, side by side with --rig: NAME|FILE.toml,KEY=VALUE,...; may be given
    /// several times
    #[arg(long, value_name = "RIG[,KEY=VALUE]", conflicts_with = "all")]
    beside: Vec<String>,

    /// Also write a report of one printable page: answer, picture, assumptions, what to measure first
    #[arg(long, value_name = "FILE.html", conflicts_with_all = ["all", "beside"], help_heading = "Output")]
    report: Option<PathBuf>,

    /// With several gaps: random initial conditions per gap; the answer has the share that settles on the recommended orbit
    #[arg(long, value_name = "N", default_value_t = STARTS)]
    starts: u32,

    /// Pick at each of these values of a rig's parameter: FROM:TO:STEP, FROM:TO:linN, FROM:TO:logN, or values with
    /// commas: contact_stiffness_n_per_m=1e6:1e7:log5
    #[arg(long, value_name = "KEY=VALUES", value_parser = parse_over, conflicts_with_all = ["all", "beside", "report"])]
    over: Option<OverOption>,

    /// Quantity to maximise
    #[arg(long, value_enum, default_value = "force")]
    objective: Objective,

    /// Contact force wanted at the recommended point, N: the answer has the stroke that gives it, and whether the shaker's
    /// force is enough
    #[arg(long, value_name = "N", conflicts_with_all = ["max_force_n", "all", "beside", "over"])]
    want_force_n: Option<f64>,

    /// Largest contact force allowed, N
    #[arg(long, value_name = "N", help_heading = "Limits")]
    max_force_n: Option<f64>,

    /// Largest drive frequency allowed, Hz
    #[arg(long, value_name = "HZ", help_heading = "Limits")]
    max_frequency_hz: Option<f64>,

    /// Largest force that the shaker can give, N, including its answer to the recoil. Replaces the rig's shaker_max_force_n
    #[arg(long, value_name = "N", help_heading = "Limits")]
    max_shaker_force_n: Option<f64>,

    #[command(flatten)]
    uncertainty: UncertaintyArgs,

    #[command(flatten)]
    rig: RigAtGaps,

    #[command(flatten)]
    cart: CartArg,

    #[command(flatten)]
    ground: GroundArgs,

    #[command(flatten)]
    springs: bending::SpringsArgs,

    #[command(flatten)]
    pub output: OutputArgs,
}

pub fn run(args: &Args) -> Result<(), UserError> {
    let output = &args.output;
    let limits = limits(args)?;
    let springs = args.springs.springs()?;
    args.uncertainty.check()?;
    args.report.as_deref().map_or(Ok(()), report::check)?;
    if args.objective == Objective::Rop {
        return for_progress(args, output, limits);
    }
    if let Some(option) = args.ground.given() {
        return Err(UserError::new(format!(
            "{option} is for --objective rop; the other objective is on a surface that stays"
        )));
    }
    if let Some(gaps_mm) = args.rig.several_mm()? {
        refuse_others(args, "several gaps")?;
        let gaps = gaps::Gaps {
            mm: gaps_mm,
            springs,
            starts: args.starts,
            seed: args.uncertainty.seed(),
        };
        let rig = args.cart.apply(args.rig.name.load()?)?;
        output.doubt(&rig);
        let uncertainty = args.uncertainty.of(&rig)?;
        let output = output.about([&rig])?;
        let output = output.with_uncertainty(uncertainty.map(stated));
        return gaps::run(&rig, &output, &gaps, uncertainty, limits);
    }
    if args.starts != STARTS {
        return Err(UserError::new(
            "--starts goes with several gaps: --gap FROM:TO:STEP",
        ));
    }
    if let Some(asked) = &args.over {
        return over::run(args, asked, springs, limits);
    }
    let rigs = rigs(args, output)?;
    for rig in &rigs {
        output.doubt(rig);
    }
    let uncertain = |rig: &NamedRig| args.uncertainty.of(rig);
    let widths: Vec<_> = rigs.iter().map(uncertain).collect::<Result<_, _>>()?;
    let first = widths.first().copied().flatten();
    let output = &output.about(&rigs)?.with_uncertainty(first.map(stated));
    let work = widths.iter().map(|width| steps(*width)).sum();
    let progress = ProgressLine::new("rigs tried", work, output.quiet);
    let picks = rigs.iter().zip(&widths);
    let picks = picks.map(|(rig, width)| match args.want_force_n {
        Some(wanted) => pick_for_force(rig, springs, *width, (limits, wanted), &progress),
        None => pick_on(rig, springs, *width, limits, &progress),
    });
    let picks: Vec<Pick> = picks.collect::<Result<_, _>>()?;
    progress.finish();
    let answer = json(&picks)?;
    let curve: Vec<_> = picks.iter().flat_map(curve_rows).collect();
    write(output, &figure(&picks), &answer, &curve)?;
    if let (Some(file), [rig], [pick]) = (&args.report, rigs.as_slice(), picks.as_slice()) {
        let before = report::write(file, rig, pick, output.made_from())?;
        output.note(&format!("wrote {}{}", file.display(), replaced(before)));
    }
    let rows: Vec<_> = picks
        .iter()
        .map(|p| Selection::of(&p.answer, COLUMNS))
        .collect();
    output.emit(&answer, &rows, || {
        if args.beside.is_empty() {
            text::text(&picks)
        } else {
            beside::text(&rigs, &picks)
        }
    })
}

/// For the largest rate of penetration.
fn for_progress(args: &Args, output: &OutputArgs, limits: PickLimits) -> Result<(), UserError> {
    refuse_others(args, "--objective rop, which is for one rig at one gap")?;
    if args.rig.several_mm()?.is_some() {
        return Err(UserError::new(
            "--objective rop is for one rig at one gap; host-sim drill --gap FROM:TO:STEP goes over gaps",
        ));
    }
    if let Some(option) = args.springs.given() {
        return Err(UserError::new(format!(
            "{option} cannot be used with --objective rop, which computes beams with one bending mode"
        )));
    }
    let rig = rig_of(args, output, args.rig.name.name(), &[])?;
    output.doubt(&rig);
    let uncertainty = args.uncertainty.of(&rig)?;
    let asked = args.ground.asked();
    let ground = asked.ground(&rig)?;
    let request = DrillPickRequest {
        ground,
        bit: asked.bit(&rig, &ground)?,
        ground_uncertainty: asked.uncertainty()?,
        uncertainty,
        limits,
    };
    let carried = uncertainty.map(|u| {
        let mut all = stated(u);
        let ground = request.ground_uncertainty;
        all.extend(object([
            ("threshold_percent", ground.threshold_percent),
            ("ground_stiffness_percent", ground.ground_stiffness_percent),
        ]));
        all
    });
    let output = output.about([&rig])?.with_uncertainty(carried);
    rop::run(&rig, &request, &output)
}

/// Refuses what asks for more than one rig, or another kind of answer, where `beside` is asked for.
fn refuse_others(args: &Args, beside: &str) -> Result<(), UserError> {
    let others = [
        ("--all", args.all),
        ("--beside", !args.beside.is_empty()),
        ("--over", args.over.is_some()),
        ("--report", args.report.is_some()),
        ("--want-force-n", args.want_force_n.is_some()),
    ];
    match others.iter().find(|(_, given)| *given) {
        Some((option, _)) => Err(UserError::new(format!(
            "{option} cannot be used with {beside}"
        ))),
        None => Ok(()),
    }
}

/// The uncertainty as an answer carries it.
fn stated(u: Uncertainty) -> Map<String, Value> {
    let damping = match u.contact_damping_ratio_percent {
        Some(percent) => ("contact_damping_ratio_percent", percent),
        None => ("contact_damping_percent", u.contact_damping_percent),
    };
    let stiffness = match u.contact_stiffness_factor {
        Some(factor) => ("contact_stiffness_factor", factor),
        None => ("contact_stiffness_percent", u.contact_stiffness_percent),
    };
    object([
        ("natural_frequency_percent", u.natural_frequency_percent),
        ("amplitude_percent", u.amplitude_percent),
        stiffness,
        damping,
        ("gap_tolerance_mm", u.gap_mm),
        ("mass_percent", u.mass_percent),
        ("cart_mass_percent", u.cart_mass_percent),
        ("shaker_loop_percent", u.shaker_loop_percent),
        ("shaker_damping_percent", u.shaker_damping_percent),
        ("samples", f64::from(u.samples)),
        ("seed", u.seed as f64),
    ])
}

/// The rigs asked for.
fn rigs(args: &Args, output: &OutputArgs) -> Result<Vec<NamedRig>, UserError> {
    if args.all {
        let names = PRESETS.iter();
        return names
            .map(|(name, _)| rig_of(args, output, name, &[]))
            .collect();
    }
    let mut rigs = vec![rig_of(args, output, args.rig.name.name(), &[])?];
    for beside in &args.beside {
        // mass_kg=1,7: the 7 is no setting of its own.
        if let Some(write) = comma(beside) {
            return Err(UserError::new(write).at(format!("--beside {beside}")));
        }
        let mut parts = beside.split(',');
        let name = parts.next().unwrap_or_default().trim();
        let settings: Vec<String> = parts.map(str::to_owned).collect();
        let rig = rig_of(args, output, name, &settings);
        rigs.push(rig.map_err(|error| error.at_setting(format!("--beside {beside}")))?);
    }
    Ok(rigs)
}

/// A rig of the pick. If nothing sets its gap, the pick is at 0.0 mm, and a note says so where the rig has another.
fn rig_of(
    args: &Args,
    output: &OutputArgs,
    name: &str,
    settings: &[String],
) -> Result<NamedRig, UserError> {
    let (rig, own_gap_m) = load(args, name, settings)?;
    if let Some(gap_m) = own_gap_m {
        output.note(&format!(
            "note: rig {} has a gap of {:?} mm; picking at 0.0 mm (set --gap to keep it)",
            rig.name,
            numerics::row::tidy(gap_m * 1e3)
        ));
    }
    Ok(rig)
}

/// A rig of the pick; and the gap of its own, if it has one that is replaced by 0.0 mm.
fn load(
    args: &Args,
    name: &str,
    settings: &[String],
) -> Result<(NamedRig, Option<f64>), UserError> {
    let rig_args = args.rig.at_one();
    let mut rig = args.cart.apply(rig_args.load_with(name, settings)?)?;
    let keeps = rig_args.sets_gap()
        || args.over.iter().any(|over| over.key == "gap_mm")
        || settings
            .iter()
            .any(|s| s.trim_start().starts_with("gap_mm"));
    let replaced = !keeps && rig.params.gap_m != 0.0;
    let own_gap_m = replaced.then(|| std::mem::take(&mut rig.params.gap_m));
    Ok((rig, own_gap_m))
}

fn limits(args: &Args) -> Result<PickLimits, UserError> {
    let check = |name, value: Option<f64>| value.map(|x| positive(name, x)).transpose();
    check("--want-force-n", args.want_force_n)?;
    Ok(PickLimits {
        max_force_n: check("--max-force-n", args.max_force_n)?,
        max_frequency_hz: check("--max-frequency-hz", args.max_frequency_hz)?,
        max_shaker_force_n: check("--max-shaker-force-n", args.max_shaker_force_n)?,
        rig_shaker_force_n: None,
    })
}

/// Writes the picture, the answer as JSON and the curve as CSV, if a folder was asked for.
fn write(
    output: &OutputArgs,
    figure: &Figure,
    answer: &impl Serialize,
    curve: &[impl Serialize],
) -> Result<(), UserError> {
    let Some(dir) = &output.out else {
        return Ok(());
    };
    let mut contents = output.picture(figure)?;
    contents.push((output.name(".json"), to_json(answer)?.into_bytes()));
    contents.push((output.name("-curve.csv"), to_csv(curve)));
    output.write(dir, contents)
}

/// One answer as an object, several as a list.
fn json(picks: &[Pick]) -> Result<serde_json::Value, UserError> {
    let value = match picks {
        [one] => serde_json::to_value(WordedPick::from(&one.answer)),
        _ => {
            let worded = picks.iter().map(|p| WordedPick::from(&p.answer));
            serde_json::to_value(worded.collect::<Vec<_>>())
        }
    };
    value.map_err(no_json)
}
