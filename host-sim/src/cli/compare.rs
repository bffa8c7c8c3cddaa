//! `host-sim compare`.

use std::path::PathBuf;

use super::arguments::choice::choice;
use super::arguments::cycles::{CycleArgs, parse_start};
use super::arguments::drive::OneFrequency;
use super::arguments::engine::EngineArgs;
use super::arguments::output::OutputArgs;
use super::arguments::rig::{CartArg, RigArgs};
use crate::pictures;
use crate::pictures::drawn;
use crate::progress::ProgressLine;
use crate::words::compare::WordedComparison;
use crate::words::number;
use files::UserError;
use numerics::CartModel;
use numerics::NamedRig;
use numerics::compare::{
    ComparedSample, Comparison, ComparisonErrors, ComparisonRequest, MeasuredFrame, compare,
};
use numerics::engine::Start;
use numerics::signal::Signal;
use plot::chart::Chart;

/// Compare a measured displacement or force with a simulation: both curves, and the differences
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  host-sim compare record.csv --from-s 2 --to-s 10 --out out")]
#[command(group(clap::ArgGroup::new("drive").args(["ratio", "frequency"])))]
pub struct Args {
    /// A record: CSV with the columns time_s and displacement_mm, force_n or both (and cart_mm, if measured), or a
    /// log (Parquet) of `link record` or `emulate`
    #[arg(value_name = "FILE")]
    file: PathBuf,

    #[command(flatten)]
    drive: OneFrequency,

    /// Frame of the measured displacement
    #[arg(long, value_parser = choice::<MeasuredFrame>(), default_value = "fixed")]
    frame: MeasuredFrame,

    /// Compare from this time of the record, s
    #[arg(long, alias = "from", value_name = "S")]
    from_s: Option<f64>,

    /// Compare to this time of the record, s
    #[arg(long, alias = "to", value_name = "S")]
    to_s: Option<f64>,

    #[command(flatten)]
    cycles: CycleArgs,

    /// Initial condition of the simulation: rest (relative to the cart), fixed (at rest in the laboratory), or
    /// DISPLACEMENT_MM,VELOCITY_M_PER_S relative to the cart
    #[arg(long, value_parser = parse_start, default_value = "rest", allow_hyphen_values = true)]
    initial: Start,

    #[command(flatten)]
    rig: RigArgs,

    #[command(flatten)]
    cart: CartArg,

    #[command(flatten)]
    engine: EngineArgs,

    #[command(flatten)]
    pub output: OutputArgs,
}

/// What reading, comparing and writing a long record take of the time, %.
const READING: f64 = 50.0;
const COMPARING: f64 = 15.0;
const WRITING: f64 = 35.0;

pub fn run(args: &Args) -> Result<(), UserError> {
    let rig = args.cart.apply(args.rig.load()?)?;
    let output = &args.output.about([&rig])?;
    output.doubt_without_uncertainty(&rig);
    let question = ComparisonRequest {
        params: rig.params,
        engine: args.engine.engine(output)?,
        frequency_hz: args.drive.hz(rig.params.natural_frequency_hz()),
        start: args.initial,
        plan: args.cycles.plan()?,
        frame: args.frame,
    };
    for (option, value) in [("--from-s", args.from_s), ("--to-s", args.to_s)] {
        if value.is_some_and(f64::is_nan) {
            return Err(UserError::new(format!("{option} is NaN, must be a number")));
        }
    }
    let all = READING + COMPARING + output.out.as_ref().map_or(0.0, |_| WRITING);
    let progress = ProgressLine::in_parts("record", all, output.quiet);
    let note = |line: &str| progress.aside(|| output.note(line));
    let advance = |share: f64| progress.part_done(READING * share);
    let whole = crate::record::read(&args.file, note, advance)?;
    let signal = whole.between(
        args.from_s.unwrap_or(f64::NEG_INFINITY),
        args.to_s.unwrap_or(f64::INFINITY),
    )?;
    let comparison = compare(&signal, &question)?;
    progress.part_done(COMPARING);
    let answer = WordedComparison::from(&comparison.errors);
    if let Some(dir) = &output.out {
        let title = format!(
            "{} against {}, gap {:?} mm, {}",
            signal.name,
            rig.name,
            numerics::row::tidy(rig.params.gap_m * 1e3),
            CartModel::of(&rig.params).words()
        );
        let figure = pictures::compare::figure(title, &comparison, args.frame);
        let mut contents = drawn(&output.name(""), &figure)?;
        contents.extend(output.tables(&output.name(""), &answer, &comparison.rows)?);
        let written = files::write::write_all(dir, &output.stamped(contents)?)?;
        progress.finish();
        output.note_written(&written);
    }
    progress.finish();
    output.emit(&answer, &comparison.rows, || {
        text(&signal, &rig, &comparison, &answer.notes)
    })
}

fn text(signal: &Signal, rig: &NamedRig, comparison: &Comparison, notes: &[String]) -> String {
    let e = &comparison.errors;
    let mut text = format!(
        "{} against {}, {}: drive {:.4} Hz ({}), {:.4} times the natural frequency; simulation: regime {}\n\n",
        signal.name,
        rig.name,
        CartModel::of(&rig.params).words(),
        e.frequency_hz,
        e.frequency_from.name(),
        e.frequency_ratio,
        e.regime
    );
    text += &table(e);
    for note in notes {
        text += &format!("  note: {note}\n");
    }
    let begin = comparison.rows.first().map_or(0.0, |r| r.time_s);
    let end = begin + 4.0 / e.frequency_hz;
    let shown = || comparison.rows.iter().take_while(|r| r.time_s <= end);
    type Value = fn(&ComparedSample) -> Option<f64>;
    let (label, measured, model): (_, Value, Value) = match signal.displacement_mm {
        None => (
            "contact force, N",
            |r| r.measured_force_n,
            |r| Some(r.simulated_force_n),
        ),
        Some(_) => (
            "displacement, mm",
            |r| r.measured_displacement_mm,
            |r| Some(r.simulated_displacement_mm),
        ),
    };
    let curve = |value: Value| {
        shown()
            .filter_map(|r| Some((r.time_s, value(r)?)))
            .collect()
    };
    text.push('\n');
    text += &Chart::new("record time, s", label)
        .series("simulation", curve(model))
        .series("measured", curve(measured))
        .render();
    text
}

fn table(e: &ComparisonErrors) -> String {
    let mut text = String::from("                               measured    simulated\n");
    let mut line = |what: &str, measured: Option<f64>, simulated: Option<f64>, digits: usize| {
        if measured.is_some() {
            text += &format!(
                "  {what:<27} {:>9} {:>12}\n",
                number(measured, digits),
                number(simulated, digits)
            );
        }
    };
    line(
        "peak to peak, mm",
        e.measured_peak_to_peak_mm,
        Some(e.simulated_peak_to_peak_mm),
        4,
    );
    line(
        "largest force, N",
        e.measured_force_n,
        Some(e.simulated_force_n),
        2,
    );
    line("mean of the peaks, N", e.measured_peak_mean_n, None, 2);
    line(
        "contacts per drive period",
        e.measured_contacts_per_period,
        Some(e.simulated_contacts_per_period),
        3,
    );
    line(
        "contact time, ms",
        e.measured_contact_time_ms,
        e.simulated_contact_time_ms,
        3,
    );
    if let (Some(rms), Some(percent), Some(mean)) = (
        e.displacement_rms_mm,
        e.displacement_rms_percent,
        e.displacement_mean_mm,
    ) {
        text += &format!(
            "  displacement differs by {rms:.4} mm rms ({percent:.2} % of the travel), {mean:+.4} mm on average\n"
        );
    }
    if let (Some(rms), Some(percent)) = (e.force_rms_n, e.force_peak_percent) {
        text += &format!("  force differs by {rms:.3} N rms, the largest by {percent:+.2} %\n");
    }
    text
}
