//! `host-sim sweep`.

mod over;

use std::path::PathBuf;

use crate::cli::arguments::choice::choice;
use crate::cli::arguments::cycles::CycleArgs;
use crate::cli::arguments::drive::Drives;
use crate::cli::arguments::engine::EngineArgs;
use crate::cli::arguments::output::{Format, OutputArgs, to_json};
use crate::cli::arguments::over::{OverOption, parse_over};
use crate::cli::arguments::rig::{CartArg, RigArgs};
use crate::cli::terminal::print;
use crate::pictures::drawn;
use crate::pictures::pick::by_regime;
use crate::pictures::regimes::regime_points;
use crate::progress::ProgressLine;
use crate::words::{number, some_of};
use files::UserError;
use files::table::to_csv;
use numerics::error::MotionError;
use numerics::row::RunRow;
use numerics::sweep::{Direction, MeasuredCurve, MeasuredError, sweep};
use plot::chart::Chart;
use plot::{Axis, Color, Figure, Item, Panel};

/// Compute the force curve over frequency, from rest or with the state carried up or down
#[derive(Debug, clap::Args)]
#[command(
    after_help = "On two cores 370 runs take 3 s from rest, 6 s carried up or down.\n\nExamples:\n  host-sim sweep --ratio 0.8:4.5:0.01 --direction up --out out\n  host-sim sweep --ratio 2 --over contact_stiffness_n_per_m=1e5:1e7:log20"
)]
#[command(group(clap::ArgGroup::new("drive").required(true).args(["ratio", "frequency"])))]
pub struct Args {
    #[command(flatten)]
    drive: Drives,

    /// Sweep a rig's parameter at one frequency: FROM:TO:STEP, FROM:TO:linN, FROM:TO:logN (N values evenly spaced, or by
    /// even factors), or values with commas: contact_stiffness_n_per_m=1e5:1e7:log20
    #[arg(long, value_name = "KEY=VALUES", value_parser = parse_over, conflicts_with = "measured")]
    over: Option<OverOption>,

    /// Start each frequency from rest, or carry the state up or down (which shows the jumps)
    #[arg(long, value_parser = choice::<Direction>(), default_value = "rest")]
    direction: Direction,

    #[command(flatten)]
    cycles: CycleArgs,

    /// A measured curve to compare with: CSV with the columns frequency_hz and force_n
    #[arg(long, value_name = "FILE.csv")]
    measured: Option<PathBuf>,

    #[command(flatten)]
    rig: RigArgs,

    #[command(flatten)]
    cart: CartArg,

    #[command(flatten)]
    engine: EngineArgs,

    #[command(flatten)]
    pub output: OutputArgs,
}

pub fn run(args: &Args) -> Result<(), UserError> {
    if let Some(asked) = &args.over {
        return over::run(args, asked);
    }
    let rig = args.cart.apply(args.rig.load()?)?;
    let output = &args.output.about([&rig])?;
    output.doubt_without_uncertainty(&rig);
    let engine = args.engine.engine(output)?;
    let plan = args.cycles.plan()?;
    let natural_hz = rig.params.natural_frequency_hz();
    let frequencies = args.drive.needed_hz(natural_hz)?;
    let measured = args
        .measured
        .as_deref()
        .map(|file| crate::measured::force_curve(file, |line| output.note(line)))
        .transpose()?;
    // The picture shows both directions, so that a jump is seen.
    let both = args.direction != Direction::Rest && output.out.is_some();
    let runs = frequencies.len() as u64 * if both { 2 } else { 1 };
    let progress = ProgressLine::new("frequencies", runs, output.quiet);
    let run = |direction| sweep(&rig, engine, &frequencies, direction, plan, &progress);
    let other = match args.direction {
        Direction::Up if both => Some(Direction::Down),
        Direction::Down if both => Some(Direction::Up),
        _ => None,
    };
    let (rows, others) = rayon::join(|| run(args.direction), || other.map(run).transpose());
    let (rows, others) = (rows?, others?);
    progress.finish();
    note_failed(output, rows.iter().chain(others.iter().flatten()));
    let error = measured.as_ref().map(|m| m.error(&rows));
    if let Some(dir) = &output.out {
        let figure = figure(
            args.direction,
            &rows,
            others.as_deref(),
            measured.as_ref(),
            error,
        );
        let mut contents = drawn(&output.name(""), &figure)?;
        contents.extend(output.tables(&output.name(""), &rows, &rows)?);
        if let (Some(others), Some(other)) = (&others, other) {
            let end = format!("-{}.csv", other.name());
            contents.push((output.name(&end), to_csv(others)));
        }
        if let Some(error) = &error {
            contents.push((output.name("-error.json"), to_json(error)?.into_bytes()));
        }
        output.write(dir, contents)?;
    }
    output.emit(&rows, &rows, || text(&rows))?;
    if let Some(error) = &error {
        let line = describe(error);
        if output.format == Format::Text {
            print(&format!("{line}\n"));
        } else {
            output.note(&line);
        }
    }
    Ok(())
}

/// Why the run of `row` failed, if it did.
fn why_failed(row: &RunRow) -> Option<&'static str> {
    row.failed.then(|| {
        row.failure
            .map_or("the run did not end", MotionError::in_few_words)
    })
}

/// Says how many rows failed.
fn note_failed<'a>(output: &OutputArgs, rows: impl Iterator<Item = &'a RunRow>) {
    let (mut failed, mut all) = (0, 0);
    for row in rows {
        all += 1;
        failed += usize::from(row.failed);
    }
    if failed > 0 {
        output.note(&format!(
            "note: {failed} of {all} runs failed; their rows give the reason"
        ));
    }
}

fn describe(error: &MeasuredError) -> String {
    if error.points_compared == 0 {
        return "measured: no point lies inside the simulated range".to_owned();
    }
    format!(
        "measured: {} points compared ({} outside), mean {:+.1} %, largest {:.1} %, root mean square {:.2} N",
        error.points_compared,
        error.points_outside,
        error.mean_percent,
        error.largest_percent,
        error.rms_n
    )
}

fn text(rows: &[RunRow]) -> String {
    let mut text = heading(rows) + "\n\n";
    text += "   Hz        Ω/ω      regime      force/weight  force, N  approach, m/s\n";
    let (shown, left_out) = some_of(rows);
    for row in shown {
        text += &format!("{:>9.4} {:>8.4}   ", row.frequency_hz, row.frequency_ratio);
        text += &match why_failed(row) {
            Some(why) => format!("failed: {why}\n"),
            None => format!(
                "{:<10} {:>13.3} {:>9.2}  {}\n",
                row.outcome.to_string(),
                row.force_ratio,
                row.force_n,
                number(row.approach_speed_m_per_s, 5)
            ),
        };
    }
    text += &left_out;
    let curve = rows
        .iter()
        .filter(|r| !r.failed)
        .map(|r| (r.frequency_hz, r.force_n))
        .collect();
    text.push('\n');
    text += &Chart::new("drive frequency, Hz", "contact force, N")
        .series("force", curve)
        .render();
    text
}

/// What is swept, for text and picture.
fn heading(rows: &[RunRow]) -> String {
    rows.first().map_or(String::new(), |r| {
        let cart = r.cart.words();
        format!(
            "{}, gap {:?} mm, {cart}: force over frequency",
            r.rig, r.gap_mm
        )
    })
}

const BLUE: Color = Color(0x1f, 0x4e, 0x79);
const GREY: Color = Color(0x80, 0x80, 0x80);
const BLACK: Color = Color(0, 0, 0);

fn figure(
    direction: Direction,
    rows: &[RunRow],
    others: Option<&[RunRow]>,
    measured: Option<&MeasuredCurve>,
    error: Option<MeasuredError>,
) -> Figure {
    let mut subtitle = match direction {
        Direction::Rest => {
            "Largest contact force of the recorded cycles, each frequency from rest.".to_owned()
        }
        _ => "Largest contact force of the recorded cycles, state carried up and carried down."
            .to_owned(),
    };
    if let Some(error) = error {
        subtitle = format!("{subtitle} {}.", describe(&error));
    }
    let mut panel = curves(direction, rows, others);
    if let Some(measured) = measured {
        panel = panel.item(Item::points("measured", BLACK, measured.points.clone()));
    }
    Figure::new(heading(rows))
        .subtitle(subtitle)
        .size(1100, 680)
        .panel(panel)
}

/// The simulated curves, with a dot for each regime.
fn curves(direction: Direction, rows: &[RunRow], others: Option<&[RunRow]>) -> Panel {
    let curve = |rows: &[RunRow]| {
        let points = rows.iter().map(|r| (r.frequency_hz, r.force_n));
        points.collect::<Vec<_>>()
    };
    let (label, other) = match direction {
        Direction::Rest => ("from rest", "carried up"),
        Direction::Up => ("carried up", "carried down"),
        Direction::Down => ("carried down", "carried up"),
    };
    let mut panel = Panel::new(
        "drive frequency, Hz",
        Axis::new("contact force, N").with_zero(),
    )
    .item(Item::line(label, BLUE, curve(rows)));
    if let Some(others) = others {
        panel = panel.item(Item::dashed(other, GREY, curve(others)));
    }
    let all = rows.iter().chain(others.unwrap_or_default());
    // Where no force is above 0, any weight will do.
    let weight_n = all
        .clone()
        .find(|r| r.force_ratio > 0.0)
        .map_or(1.0, |r| r.force_n / r.force_ratio);
    let placed = all.map(|row| (row, (row.frequency_hz, row.force_ratio * weight_n)));
    panel.items.extend(by_regime(placed, regime_points));
    panel
}
