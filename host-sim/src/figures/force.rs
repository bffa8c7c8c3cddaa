//! Force over frequency, figures 3.12–3.14 (wires) and 3.40–3.42 (beams): the largest force at each frequency, from
//! rest, and carried up and down, which shows the jumps.

use serde::Serialize;

use super::force_curves::{SweepCurves, curves, gap_mm};
use super::{Effort, Page};
use crate::pictures::pick::grouped;
use crate::pictures::regimes::{regime_group, regime_style};
use crate::progress::ProgressLine;
use files::UserError;
use files::table::Selection;
use numerics::row::RunRow;
use plot::{Axis, Color, Figure, Item, Panel};

/// Figures 3.12, 3.13 and 3.14.
///
/// # Errors
/// If a motion cannot be followed or a picture cannot be drawn.
pub fn wires(effort: Effort, progress: &ProgressLine) -> Result<Vec<Page>, UserError> {
    const GAPS_MM: [f64; 3] = [0.0, 1.0, 2.4];
    let curves = curves(&["wires"], &GAPS_MM, (0.6, 5.0), effort, progress)?;
    let figures = ["3.12", "3.13", "3.14"];
    figures
        .iter()
        .zip(&curves)
        .map(|(figure, curve)| {
            let title = format!(
                "Wires, gap {:?} mm: force over frequency",
                gap_mm(&curve.params)
            );
            page(figure, title, std::slice::from_ref(curve))
        })
        .collect()
}

/// Figures 3.40, 3.41 and 3.42.
///
/// # Errors
/// If a motion cannot be followed or a picture cannot be drawn.
pub fn beams(effort: Effort, progress: &ProgressLine) -> Result<Vec<Page>, UserError> {
    const RIGS: [&str; 3] = ["beam-170", "beam-150", "beam-135"];
    let curves = curves(&RIGS, &[0.0, 1.0, 3.0], (0.6, 4.0), effort, progress)?;
    let figures = ["3.40", "3.41", "3.42"];
    figures
        .iter()
        .zip(curves.chunks(3))
        .map(|(figure, curves)| {
            let title = format!(
                "{}, gaps 0.0, 1.0 and 3.0 mm: force over frequency",
                curves[0].rig
            );
            page(figure, title, curves)
        })
        .collect()
}

/// A row, and which sweep it is from.
#[derive(Serialize)]
struct CurveRow<'a> {
    from: &'static str,
    row: &'a RunRow,
}

/// What a table has of it.
const COLUMNS: &[&str] = &[
    "from",
    "rig",
    "gap_mm",
    "frequency_hz",
    "frequency_ratio",
    "regime",
    "force_ratio",
    "force_n",
];

fn page(figure: &'static str, title: String, curves: &[SweepCurves]) -> Result<Page, UserError> {
    let picture = curves.iter().fold(
        Figure::new(title.clone())
            .subtitle("Largest contact force over the hammer's weight. Dots: from rest at each frequency, by regime. Lines: the state carried up and down in frequency.")
            .size(1100, if curves.len() > 1 { 1500 } else { 640 }),
        |picture, curve| picture.panel(panel(curve, curves.len() > 1)),
    );
    let command = format!(
        "host-sim sweep --rig {} --gap {:?} --ratio 0.6:4:0.01 --direction up --cart prescribed",
        curves[0].rig,
        gap_mm(&curves[0].params)
    );
    let rows = curves.iter().flat_map(|c| {
        let ways = [("rest", &c.rest), ("up", &c.up), ("down", &c.down)];
        let rows = ways.map(|(from, rows)| rows.iter().map(move |row| CurveRow { from, row }));
        rows.into_iter().flatten()
    });
    let table: Vec<_> = rows.map(|row| Selection::of(&row, COLUMNS)).collect();
    Ok(Page::new(figure, title, command, &picture)?.table("", &table))
}

fn panel(curve: &SweepCurves, titled: bool) -> Panel {
    let at = |r: &RunRow| (r.frequency_ratio, r.force_ratio);
    let line = |rows: &[RunRow]| rows.iter().map(at).collect::<Vec<_>>();
    let mut panel = Panel::new(
        "drive frequency over natural frequency, Ω/ω",
        Axis::new("force ratio, F/(m g)").with_zero(),
    )
    .item(Item::line(
        "carried up",
        Color(0x55, 0x55, 0x55),
        line(&curve.up),
    ))
    .item(Item::dashed(
        "carried down",
        Color(0x99, 0x33, 0x33),
        line(&curve.down),
    ));
    let group = |row: &RunRow| regime_group(&row.regime.to_string()).to_owned();
    let rest = curve.rest.iter().map(|row| (group(row), at(row)));
    panel.items.extend(grouped(rest, small));
    if titled {
        panel = panel.titled(format!("gap {:?} mm", gap_mm(&curve.params)));
    }
    panel
}

/// Dots of a regime, small enough that a curve stays a curve.
fn small(regime: &str, points: Vec<(f64, f64)>) -> Item {
    let style = regime_style(regime);
    Item::marks(regime, style.color, (style.mark, 2.0), points)
}

/// The run with the largest force of those in 1/1; none if none is.
pub(crate) fn strongest(rows: &[RunRow]) -> Option<&RunRow> {
    let of = rows.iter().filter(|r| r.regime.is(1, 1));
    of.max_by(|a, b| a.force_n.total_cmp(&b.force_n))
}
