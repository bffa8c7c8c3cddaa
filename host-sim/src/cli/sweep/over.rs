//! `sweep --over`: the force at one drive frequency over any parameter of the rig.

use serde::Serialize;

use super::{Args, why_failed};
use crate::cli::arguments::output::OutputArgs;
use crate::cli::arguments::over::OverOption;
use crate::pictures::over::axis_label;
use crate::pictures::pick::by_regime;
use crate::pictures::regimes::regime_points;
use crate::progress::ProgressLine;
use crate::words::some_of;
use files::UserError;
use files::table::Selection;
use files::words::digits::significant;
use numerics::CartModel;
use numerics::NamedRig;
use numerics::row::RunRow;
use numerics::sweep::{Direction, over};
use plot::chart::Chart;
use plot::{Axis, Color, Figure, Item, Panel};

/// One value of the parameter.
#[derive(Debug, Serialize)]
struct OverRow<'a> {
    /// The parameter, as rig files name it.
    parameter: &'a str,
    /// Its value, in the unit of its name.
    value: f64,
    row: &'a RunRow,
}

/// What a table has of it.
const COLUMNS: &[&str] = &[
    "parameter",
    "value",
    "rig",
    "gap_mm",
    "cart",
    "frequency_hz",
    "frequency_ratio",
    "impacts",
    "periods",
    "regime",
    "force_ratio",
    "force_n",
    "approach_speed_m_per_s",
    "contact_time_ms",
];

/// The sweep over the parameter.
///
/// # Errors
/// If a rig cannot be, more than one frequency is given, or a run fails.
pub fn run(args: &Args, asked: &OverOption) -> Result<(), UserError> {
    asked.check(&args.rig)?;
    let rig = args.cart.apply(args.rig.load()?)?;
    let output = &args.output.about([&rig])?;
    output.doubt_without_uncertainty(&rig);
    let engine = args.engine.engine(output)?;
    let plan = args.cycles.plan()?;
    let runs = runs(args, asked)?;
    let progress = ProgressLine::new("values", runs.len() as u64, output.quiet);
    let rows = over(&runs, engine, args.direction, plan, &progress)?;
    progress.finish();
    super::note_failed(output, rows.iter());
    let rows: Vec<OverRow<'_>> = rows
        .iter()
        .zip(&asked.values.list)
        .map(|(row, value)| OverRow {
            parameter: &asked.key,
            value: *value,
            row,
        })
        .collect();
    let lines: Vec<_> = rows.iter().map(|r| Selection::of(r, COLUMNS)).collect();
    let picture = || output.picture(&figure(&rig, args.direction, asked, &rows));
    output.answer(&lines, &lines, picture, || text(output, &rig, asked, &rows))
}

/// A rig and its drive frequency for each value.
fn runs(args: &Args, asked: &OverOption) -> Result<Vec<(NamedRig, f64)>, UserError> {
    let one = |value: &f64| {
        let name = args.rig.name.name();
        let rig = args.rig.load_with(name, &asked.setting(*value));
        let rig = args.cart.apply(rig.map_err(|error| asked.at(error))?)?;
        let hz = args.drive.needed_hz(rig.params.natural_frequency_hz())?;
        match hz.as_slice() {
            [hz] => Ok((rig, *hz)),
            _ => Err(UserError::new(
                "--over goes with one drive frequency; give --ratio or --frequency one value",
            )),
        }
    };
    asked.values.list.iter().map(one).collect()
}

/// What is computed, for text and picture: the rig, and the gap, cart and drive that all values share.
fn heading(rig: &NamedRig, asked: &OverOption, rows: &[OverRow<'_>]) -> String {
    let cart = CartModel::of(&rig.params).words();
    let shared = |value: fn(&RunRow) -> f64| {
        let first = value(rows.first()?.row);
        let same = |x: f64| (x - first).abs() <= 1e-9 * first.abs();
        rows.iter().all(|r| same(value(r.row))).then_some(first)
    };
    let gap = shared(|row| row.gap_mm).map_or(String::new(), |mm| format!(", gap {mm:?} mm"));
    let drive = match (
        shared(|row| row.frequency_hz),
        shared(|row| row.frequency_ratio),
    ) {
        (Some(hz), _) => format!(", {} Hz", significant(hz, 5)),
        (None, Some(ratio)) => format!(", {} times the natural frequency", significant(ratio, 5)),
        (None, None) => String::new(),
    };
    format!(
        "{}{gap}, {cart}{drive}: force over {}",
        rig.name,
        axis_label(&asked.key)
    )
}

fn text(output: &OutputArgs, rig: &NamedRig, asked: &OverOption, rows: &[OverRow<'_>]) -> String {
    let mut text = format!(
        "{}\n\n{:>28}   Hz        Ω/ω      regime      force/weight  force, N\n",
        heading(rig, asked, rows),
        asked.key
    );
    let (shown, left_out) = some_of(rows);
    for OverRow { value, row, .. } in shown {
        text += &format!(
            "{:>28} {:>9.4} {:>8.4}   ",
            significant(*value, 6),
            row.frequency_hz,
            row.frequency_ratio
        );
        text += &match why_failed(row) {
            Some(why) => format!("failed: {why}\n"),
            None => format!(
                "{:<10} {:>13.3} {:>9.2}\n",
                row.outcome.to_string(),
                row.force_ratio,
                row.force_n
            ),
        };
    }
    text += &left_out;
    text.push('\n');
    if asked.values.log {
        output.note("note: the chart's axis is the logarithm of the parameter");
    }
    let known = rows.iter().filter(|r| !r.row.failed);
    let curve = known.map(|r| (asked.along(r.value), r.row.force_n));
    text + &Chart::new(asked.axis(), "contact force, N")
        .series("force", curve.collect())
        .render()
}

const BLUE: Color = Color(0x1f, 0x4e, 0x79);

fn figure(
    rig: &NamedRig,
    direction: Direction,
    asked: &OverOption,
    rows: &[OverRow<'_>],
) -> Figure {
    let how = match direction {
        Direction::Rest => "each value from rest",
        Direction::Up => "state carried from value to value, upwards",
        Direction::Down => "state carried from value to value, downwards",
    };
    let axis = Axis::new(axis_label(&asked.key));
    let axis = if asked.values.log { axis.log() } else { axis };
    let curve = rows.iter().map(|r| (r.value, r.row.force_n)).collect();
    let mut panel = Panel::new(axis, Axis::new("contact force, N").with_zero())
        .item(Item::line("force", BLUE, curve));
    let placed = rows.iter().map(|r| (r.row, (r.value, r.row.force_n)));
    panel.items.extend(by_regime(placed, regime_points));
    Figure::new(heading(rig, asked, rows))
        .subtitle(format!(
            "Largest contact force of the recorded cycles, {how}."
        ))
        .size(1000, 640)
        .panel(panel)
}
