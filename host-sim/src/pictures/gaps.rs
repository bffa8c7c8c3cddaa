//! The picture of the gap advice: force, frequency and safe band, basin and multiplier over the gap.

use crate::pictures::over::{around, jumps};
use crate::words::gaps::{GapRow, GapTable};
use plot::{Axis, Color, Figure, Item, Panel};

/// Four panels over the gap; gaps that jump carry an orange diamond. `cart` is how a heading says it moves.
pub fn figure(advice: &GapTable, cart: &str) -> Figure {
    let rig = advice.gaps.first().map_or("", |row| row.rig.as_str());
    let title = match advice.advised_gap_mm {
        Some(gap) => format!("{rig}: run at a gap of {gap:?} mm ({cart})"),
        None => format!("{rig}: no gap to run at ({cart})"),
    };
    Figure::new(title)
        .subtitle(advice.why.clone())
        .columns(2)
        .size(1300, 1000)
        .panel(force(advice))
        .panel(frequency(advice))
        .panel(basin(advice))
        .panel(multiplier(advice))
}

/// Points of `value` over the gap, where there is one.
fn over(advice: &GapTable, value: impl Fn(&GapRow) -> Option<f64>) -> Vec<(f64, f64)> {
    let rows = advice.gaps.iter();
    rows.filter_map(|row| Some((row.gap_mm, value(row)?)))
        .collect()
}

fn panel(advice: &GapTable, label: &str, title: &str) -> Panel {
    let panel = Panel::new("gap, mm", Axis::new(label).with_zero()).titled(title);
    match advice.advised_gap_mm {
        Some(gap) => panel.item(Item::mark_x("advised", gap)),
        None => panel,
    }
}

fn force(advice: &GapTable) -> Panel {
    let jumping = |row: &GapRow| row.force_ratio.filter(|_| row.jumps == Some(true));
    panel(advice, "contact force over weight", "force")
        .item(Item::dashed(
            "largest 1/1, nominal rig",
            Color::GREY,
            over(advice, |r| r.largest_force_ratio),
        ))
        .dotted("at the pick", Color::BLUE, over(advice, |r| r.force_ratio))
        .item(jumps(over(advice, jumping)))
}

fn frequency(advice: &GapTable) -> Panel {
    let edge = |label: &str, value: fn(&GapRow) -> Option<f64>| {
        Item::dashed(label, Color::GREEN, over(advice, value))
    };
    let pick = over(advice, |r| r.operating_frequency_hz);
    let edges = advice.gaps.iter();
    let edges = edges.flat_map(|r| [r.safe_band_low_hz, r.safe_band_high_hz]);
    let mut panel = panel(advice, "drive frequency, Hz", "frequency and safe band");
    panel.y = around("drive frequency, Hz", edges.flatten()).unwrap_or(panel.y);
    panel
        .item(edge("safe band", |r| r.safe_band_low_hz))
        .item(edge("", |r| r.safe_band_high_hz))
        .dotted("pick", Color::BLUE, pick)
}

fn basin(advice: &GapTable) -> Panel {
    let percent = |value: Option<f64>| value.map(|share| 100.0 * share);
    let share = over(advice, |r| percent(r.basin_share));
    let mut panel = panel(advice, "share of the starts, %", "where starts end");
    panel.y = Axis::new("share of the starts, %").fixed(0.0, 105.0);
    // Intervals: a short upright line each.
    let intervals = advice.gaps.iter().filter_map(|row| {
        let (low, high) = (
            percent(row.basin_share_low)?,
            percent(row.basin_share_high)?,
        );
        Some([(row.gap_mm, low), (row.gap_mm, high), (f64::NAN, f64::NAN)])
    });
    panel
        .item(Item::line("", Color::BLUE, intervals.flatten().collect()))
        .dotted("on the orbit picked (95 %)", Color::BLUE, share)
        .item(Item::dashed(
            "without impact",
            Color::RED,
            over(advice, |r| percent(r.silent_share)),
        ))
}

fn multiplier(advice: &GapTable) -> Panel {
    let points = over(advice, |r| r.multiplier);
    let ends = advice.gaps.first().zip(advice.gaps.last());
    let limit = ends.map_or(Vec::new(), |(a, b)| vec![(a.gap_mm, 1.0), (b.gap_mm, 1.0)]);
    panel(
        advice,
        "largest modulus of a multiplier",
        "stability at the pick",
    )
    .dotted("orbit picked", Color::BLUE, points)
    .item(Item::dashed("limit of stability", Color::INK, limit))
}
