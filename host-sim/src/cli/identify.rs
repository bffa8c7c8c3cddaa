//! `host-sim identify`.

use shared::model::contact::LawKind;
use std::path::PathBuf;

use serde::Serialize;

use super::arguments::choice::choice;
use super::arguments::output::OutputArgs;
use super::arguments::rig::RigArgs;
use super::coverage::CoverageArgs;
use crate::pictures;
use crate::progress::ProgressLine;
use files::UserError;
use files::table::to_csv;
use files::words::identify::{IdentifyAnswer, WordedFit};
use numerics::NamedRig;
use numerics::identify::{
    FilterKind, IdentifiedFit, ImpactRow, MeasuredImpacts, Misfit, ProfileEstimate, SearchSettings,
    identify, release_m,
};
use numerics::signal::Signal;
use plot::chart::Chart;

/// Identify the contact parameters of any contact law from a drop test (CSV), with 95 % intervals
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  host-sim identify drop.csv --misfit force --out out")]
pub struct Args {
    /// A drop test: CSV with the columns time_s and force_n (displacement_mm, if present, gives the release)
    #[arg(value_name = "FILE.csv", required_unless_present = "coverage")]
    file: Option<PathBuf>,

    /// Contact law to identify; may be given several times [default: spring-dashpot]
    #[arg(long, value_parser = choice::<LawKind>())]
    law: Vec<LawKind>,

    /// All laws
    #[arg(long, conflicts_with = "law")]
    all_laws: bool,

    /// Quantity to minimise [default: both, one after the other]
    #[arg(long, value_parser = choice::<Misfit>())]
    misfit: Option<Misfit>,

    /// Displacement at the release, mm from the hammer's rest position; negative: away from the surface [default: the
    /// record's first displacement, or -3]
    #[arg(long, value_name = "MM")]
    release_mm: Option<f64>,

    /// Identify the point of release, too
    #[arg(long)]
    seek_release: bool,

    /// Identify the exponent n of the nonlinear laws, too (otherwise 1.5)
    #[arg(long)]
    seek_exponent: bool,

    /// Most impacts that the fit uses
    #[arg(long, value_name = "N", default_value_t = 6)]
    impacts: usize,

    /// Uncertainty of the force sensor's gain: standard deviation, %
    #[arg(long, value_name = "PERCENT", default_value_t = SearchSettings::DEFAULT.gain_percent)]
    gain_percent: f64,

    /// Uncertainty of the distance of the release from rest: standard deviation, %
    #[arg(long, value_name = "PERCENT", default_value_t = SearchSettings::DEFAULT.release_height_percent)]
    release_height_percent: f64,

    /// Uncertainty of the clock of the samples: standard deviation, %
    #[arg(long, value_name = "PERCENT", default_value_t = SearchSettings::DEFAULT.clock_percent)]
    clock_percent: f64,

    #[command(flatten)]
    coverage: CoverageArgs,

    #[command(flatten)]
    rig: RigArgs,

    #[command(flatten)]
    pub output: OutputArgs,
}

/// A line of the table.
#[derive(Serialize)]
struct Row {
    law: LawKind,
    misfit: Misfit,
    parameter: &'static str,
    value: f64,
    low_95: Option<f64>,
    high_95: Option<f64>,
    rms_n: f64,
    noise_n: f64,
    widened: f64,
    refused: bool,
    intervals: bool,
    misses_share: f64,
}

pub fn run(args: &Args) -> Result<(), UserError> {
    let Some(file) = args.file.as_ref().filter(|_| !args.coverage.wanted()) else {
        return args.coverage.run(args.misfit, &args.output);
    };
    let families = families(args)?;
    let rig = args.rig.load()?;
    args.output.doubt(&rig);
    let output = &args.output.about([&rig])?;
    let signal = crate::record::read(file, |line| output.note(line), |_| ())?;
    let settings = settings(args, &signal)?;
    let misfits = args
        .misfit
        .map_or(vec![Misfit::Force, Misfit::Peaks], |m| vec![m]);
    let work = (families.len() * misfits.len()) as u64;
    let progress = ProgressLine::new("searches", work, output.quiet);
    let (measured, fits) = identify(
        &signal,
        &rig.params,
        &families,
        &misfits,
        &settings,
        &progress,
    )?;
    progress.finish();
    let answer = IdentifyAnswer::new(&rig, &measured, &settings, &fits);
    refuse(&answer, args.all_laws)?;
    let rows = rows(&fits);
    let files = || {
        let mut files = output.picture(&figure(&rig, &measured, &fits, &settings))?;
        let impacts = |fit: &IdentifiedFit| (output.name("-impacts.csv"), to_csv(&fit.impacts));
        files.extend(fits.first().map(impacts));
        Ok(files)
    };
    output.answer(&answer, &rows, files, || text(&answer))
}

/// An error if none of the laws fits: there is no answer then.
fn refuse(answer: &IdentifyAnswer, all_laws: bool) -> Result<(), UserError> {
    if answer.fits.iter().any(|worded| !worded.fit.refused) {
        return Ok(());
    }
    let mut names: Vec<_> = answer.fits.iter().map(|w| w.fit.law.name()).collect();
    names.dedup();
    let least = answer.fits.iter().map(|w| w.fit.misses_share);
    Err(UserError::new(format!(
        "{}: {} {} not fit: at least {:.0} % of the force is missed; {}check the units of time and force, --rig, --gap and --release-mm; a filter in the converter may be why, too",
        answer.file,
        names.join(", "),
        if names.len() == 1 { "does" } else { "do" },
        100.0 * least.fold(f64::INFINITY, f64::min),
        if all_laws { "" } else { "try --all-laws, and " }
    )))
}

/// The laws to identify.
fn families(args: &Args) -> Result<Vec<LawKind>, UserError> {
    let families = match (args.all_laws, args.law.as_slice()) {
        (true, _) => LawKind::all().collect(),
        (false, []) => vec![LawKind::SpringDashpot],
        (false, some) => some.to_vec(),
    };
    if args.seek_exponent && families.contains(&LawKind::SpringDashpot) {
        if families.len() == 1 {
            return Err(UserError::new(
                "--seek-exponent: the spring-dashpot law has no exponent; name another with --law, or leave the option out",
            ));
        }
        args.output.note(
            "note: --seek-exponent is for the other laws; the spring-dashpot law has no exponent",
        );
    }
    Ok(families)
}

fn settings(args: &Args, signal: &Signal) -> Result<SearchSettings, UserError> {
    let settings = SearchSettings {
        release_m: release_m(args.release_mm, signal)?,
        seek_release: args.seek_release,
        seek_exponent: args.seek_exponent,
        impacts: args.impacts,
        gain_percent: args.gain_percent,
        release_height_percent: args.release_height_percent,
        clock_percent: args.clock_percent,
    };
    settings.check()?;
    Ok(settings)
}

fn rows(fits: &[IdentifiedFit]) -> Vec<Row> {
    let of = |fit: &'_ IdentifiedFit| -> Vec<Row> {
        let row = |p: &ProfileEstimate| Row {
            law: fit.law,
            misfit: fit.misfit,
            parameter: p.key,
            value: p.value,
            low_95: p.low,
            high_95: p.high,
            rms_n: fit.rms_n,
            noise_n: fit.noise_n,
            widened: fit.widened,
            refused: fit.refused,
            intervals: fit.intervals,
            misses_share: fit.misses_share,
        };
        fit.parameters.iter().map(row).collect()
    };
    fits.iter().flat_map(of).collect()
}

/// Four significant digits.
fn short(x: f64) -> String {
    scientific(x, 4)
}

/// So many significant digits, of small and large values with an exponent.
fn scientific(x: f64, digits: usize) -> String {
    if x != 0.0 && !(1e-2..1e5).contains(&x.abs()) {
        return format!("{x:.*e}", digits - 1);
    }
    if x == 0.0 {
        return "0".to_owned();
    }
    let decimals = digits as i32 - 1 - x.abs().max(1e-9).log10().floor() as i32;
    format!("{x:.*}", decimals.max(0) as usize)
}

/// How many digits show the width of the interval: four, or more for a narrow one.
fn digits(estimate: &ProfileEstimate) -> usize {
    let width = estimate
        .low
        .zip(estimate.high)
        .map(|(low, high)| high - low);
    let shares = width.map_or(0.0, |width| (estimate.value.abs() / width).log10().ceil());
    shares.clamp(2.0, 10.0) as usize + 2
}

fn text(answer: &IdentifyAnswer) -> String {
    let mut text = format!(
        "{}: impacts: {}, at {} samples a second, noise {} N\n{}, gap {} mm, released at {} mm\nassumed errors (standard deviations): {} % of the sensor's gain, {} % of the distance of the release, {} % of the clock\nassumed: the cart was held; if it was free to move, stiffness and damping are {} % less than the values below\n",
        answer.file,
        answer.impacts,
        short(answer.sampling_hz),
        short(answer.noise_n),
        answer.rig,
        answer.gap_mm,
        answer.release_mm,
        answer.gain_percent,
        answer.release_height_percent,
        answer.clock_percent,
        scientific(answer.free_cart_percent, 2)
    );
    for WordedFit { fit, warnings } in &answer.fits {
        text += &fit_text(fit, warnings);
    }
    text += &match &answer.ring {
        Some(ring) => format!(
            "\nAfter release the surface rings at {:.0} Hz, decaying in {:.2} ms (damping ratio {:.4}), at first {:.0} % of the first peak. The fit includes it (docs/identify.md).\n",
            ring.frequency_hz,
            ring.decay_ms,
            ring.damping_ratio,
            100.0 * ring.share_at_release
        ),
        None => "\nThe record shows no ringing after release.\n".to_owned(),
    };
    if let Some(WordedFit { fit, .. }) = answer.fits.first() {
        text.push('\n');
        text += &peaks_chart(fit);
    }
    text
}

fn fit_text(fit: &IdentifiedFit, warnings: &[String]) -> String {
    let mut text = format!("\n{}, by {}\n", fit.law.name(), fit.misfit.name());
    for p in &fit.parameters {
        let digits = digits(p);
        let shown = |x| scientific(x, digits);
        let end = |e: Option<f64>| e.map_or("not bounded".to_owned(), shown);
        let interval = match (fit.refused, fit.intervals) {
            (true, _) => "no interval: the law does not fit".to_owned(),
            (_, false) => "no interval: the misfit is more than twice the noise".to_owned(),
            _ => format!("95 %: {} to {}", end(p.low), end(p.high)),
        };
        text += &format!("  {:<30} {:>10}   {interval}\n", p.key, shown(p.value));
    }
    if let Some(hz) = fit.sensor.filter_hz {
        let kind = match fit.sensor.filter {
            FilterKind::Analog => "an analog low-pass",
            FilterKind::Digital => "a digital low-pass of second order",
            FilterKind::LinearPhase => "a linear-phase low-pass before the samples (delta-sigma)",
            FilterKind::OddSamples | FilterKind::EvenSamples => {
                "weighted sums of neighbouring samples (a linear-phase filter)"
            }
        };
        text += &format!(
            "  the sensor filters from about {hz:.0} Hz on: of the filters tried, {kind} fits best\n"
        );
    }
    text += &format!(
        "  misfit {} N ({} N is noise); {} of {} searches end here; {} drop tests simulated\n",
        short(fit.rms_n),
        short(fit.noise_n),
        fit.starts_agreeing,
        fit.starts,
        fit.simulations
    );
    text += "  impact   measured peak, N   model peak, N   residual, N\n";
    for i in &fit.impacts {
        text += &format!(
            "  {:>6} {:>18} {:>15} {:>13}\n",
            i.impact,
            short(i.measured_peak_n),
            short(i.model_peak_n),
            if i.residual_n.is_finite() {
                short(i.residual_n)
            } else {
                "-".into()
            }
        );
    }
    for warning in warnings {
        text += &format!("  warning: {warning}\n");
    }
    text
}

fn peaks_chart(fit: &IdentifiedFit) -> String {
    let of = |peak: fn(&ImpactRow) -> f64| {
        let peaks = fit.impacts.iter().map(|i| (i.impact as f64, peak(i)));
        peaks.collect()
    };
    Chart::new("impact", "force peak, N")
        .size(plot::chart::terminal_width(), 10)
        .points("measured", of(|i| i.measured_peak_n))
        .points("model", of(|i| i.model_peak_n))
        .render()
}

fn figure(
    rig: &NamedRig,
    measured: &MeasuredImpacts,
    fits: &[IdentifiedFit],
    settings: &SearchSettings,
) -> plot::Figure {
    let title = format!("Drop test {}: contact parameters", measured.name);
    let found = fits.first().map_or(String::new(), |fit| {
        let each = fit.parameters.iter().map(|p| {
            let digits = digits(p);
            let shown = |x| scientific(x, digits);
            let end = |e: Option<f64>| e.map_or("?".to_owned(), shown);
            format!(
                "{} {} ({} to {})",
                p.key,
                shown(p.value),
                end(p.low),
                end(p.high)
            )
        });
        format!(
            "{}, by {}: {}",
            fit.law.name(),
            fit.misfit.name(),
            each.collect::<Vec<_>>().join(", ")
        )
    });
    let subtitle = format!(
        "{}, gap {:?} mm, released at {:?} mm. {found}. In brackets 95 % profile likelihood intervals.",
        rig.name,
        numerics::row::tidy(rig.params.gap_m * 1e3),
        numerics::row::tidy(settings.release_m * 1e3)
    );
    pictures::identify::figure(title, subtitle, measured, fits)
}
