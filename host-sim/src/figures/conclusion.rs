//! The chapter's conclusion: the operating frequency, and why a gap of 0.0 mm in the field. Every rig at three gaps.

use serde::Serialize;

use super::section::rig;
use super::{Effort, Page, stem};
use crate::pictures::drawn;
use crate::progress::Progress;
use files::UserError;
use files::table::to_csv;
use files::words::pick::{jumping_at, why};
use numerics::Limits;
use numerics::basins::{BasinsRequest, explore};
use numerics::branch::End;
use numerics::engine::Engine;
use numerics::pick::{Pick, pick};
use numerics::row::regime_as_text;
use numerics::uncertainty::Uncertainty;
use plot::{Axis, Color, Figure, Item, Panel};
use shared::model::regime::Regime;

/// Every rig, and the gaps the chapter measures it at, mm.
const RIGS: [(&str, [f64; 3]); 4] = [
    ("wires", [0.0, 1.0, 2.4]),
    ("beam-170", [0.0, 1.0, 3.0]),
    ("beam-150", [0.0, 1.0, 3.0]),
    ("beam-135", [0.0, 1.0, 3.0]),
];

/// A row of the table: the merits and drawbacks of a gap.
#[derive(Clone, Debug, Serialize)]
struct Row {
    rig: String,
    gap_mm: f64,
    frequency_hz: f64,
    frequency_ratio: f64,
    force_ratio: f64,
    /// Smallest force ratio over the uncertainty.
    force_ratio_worst: f64,
    /// Where 1/1 keeps 90 % of its force for every rig within the uncertainty, Hz.
    safe_band_from_hz: f64,
    safe_band_to_hz: f64,
    /// Its width over the frequency, %.
    safe_band_percent: f64,
    /// Upper end of the stable 1/1, Hz; how it ends there; its distance above the frequency, %.
    one_one_to_hz: f64,
    one_one_ends_by: String,
    one_one_margin_percent: f64,
    /// Where the hammer jumps (up and down sweeps differ, or the 1/1 folds), Hz.
    jumps_from_hz: Option<f64>,
    jumps_to_hz: Option<f64>,
    #[serde(serialize_with = "regime_as_text")]
    regime_from_rest: Regime,
    /// Of the starts within the chapter's window, the share that ends in 1/1, %.
    one_one_from_percent: f64,
    why: String,
}

/// The page "conclusion".
///
/// # Errors
/// If a rig has no stable 1/1 at 0.0 mm.
pub fn pages(effort: Effort, progress: &Progress) -> Result<Vec<Page>, UserError> {
    let (samples, side, rigs) = match effort {
        Effort::Full => (64, 40, &RIGS[..]),
        Effort::Coarse => (0, 4, &RIGS[..1]),
    };
    let (mut rows, mut refused, mut panels) = (Vec::new(), Vec::new(), Vec::new());
    for (name, gaps) in rigs {
        let mut curves = Vec::new();
        for gap in gaps {
            let Some((row, found)) = at(name, *gap, samples, side, progress).unwrap_or_else(|e| {
                refused.push(e.to_string());
                None
            }) else {
                continue;
            };
            curves.push((*gap, found));
            rows.push(row);
            progress.inc(1);
        }
        panels.push(panel(name, &curves));
    }
    let title = "Which frequency, and why at 0.0 mm";
    let figure = Figure::new(title)
        .subtitle("Force of the stable 1/1 over drive frequency at three gaps; ringed: the frequency to run at, the strongest that holds over the stated uncertainty.")
        .columns(if panels.len() > 1 { 2 } else { 1 })
        .size(1300, if panels.len() > 1 { 1000 } else { 640 });
    let figure = panels.into_iter().fold(figure, Figure::panel);
    let stem = stem("conclusion");
    let mut files = drawn(&stem, &figure)?;
    files.push((format!("{stem}.csv"), to_csv(&rows)));
    Ok(vec![Page {
        figure: "conclusion",
        title: title.to_owned(),
        chapter: "3.5: \"it is recommended to operate with 0.0 mm gap\": forces are \"in the same range\" as at higher gaps, where nonlinear jumps occur, and near the maximum \"for a wider frequency range\".",
        found: summary(&rows, &refused),
        command: "host-sim pick --rig wires --gap 0 --cart prescribed".to_owned(),
        files,
    }])
}

/// The pick at one gap; none if no 1/1 is stable over the uncertainty.
fn at(
    name: &str,
    gap_mm: f64,
    samples: u32,
    side: usize,
    progress: &Progress,
) -> Result<Option<(Row, Pick)>, UserError> {
    let rig = rig(name, gap_mm)?;
    let uncertainty = (samples > 0).then(|| Uncertainty {
        samples,
        ..Uncertainty::default()
    });
    let found = pick(&rig, uncertainty, Limits::default(), progress)?;
    let answer = &found.answer;
    let query = BasinsRequest {
        samples: 0,
        until: 300,
        ..BasinsRequest::usual(rig, answer.operating_frequency_hz, side, side)
    };
    let basins = explore(Engine::Event, &query, progress)?;
    let (share, _) = basins.grid_share(|fate, _| fate.regime.is(1, 1));
    let [low, high] = answer.safe_band_hz;
    let row = Row {
        rig: name.to_owned(),
        gap_mm,
        frequency_hz: answer.operating_frequency_hz,
        frequency_ratio: answer.frequency_ratio,
        force_ratio: answer.force_ratio,
        force_ratio_worst: answer.force_ratio_worst,
        safe_band_from_hz: low,
        safe_band_to_hz: high,
        safe_band_percent: 100.0 * (high - low) / answer.operating_frequency_hz,
        one_one_to_hz: answer.stable_one_one_hz[1],
        one_one_ends_by: name_of(answer.stable_one_one_ends[1]),
        one_one_margin_percent: 100.0
            * (answer.stable_one_one_hz[1] / answer.operating_frequency_hz - 1.0),
        jumps_from_hz: answer.jump_range_hz.map(|j| j[0]),
        jumps_to_hz: answer.jump_range_hz.map(|j| j[1]),
        regime_from_rest: answer.regime_from_rest,
        one_one_from_percent: 100.0 * share,
        why: why(answer),
    };
    Ok(Some((row, found)))
}

fn panel(rig: &str, curves: &[(f64, Pick)]) -> Panel {
    let mut panel = Panel::new(
        Axis::new("drive frequency, Hz"),
        Axis::new("force ratio of stable 1/1, F/(m g)").with_zero(),
    )
    .titled(rig);
    for (k, (gap, found)) in curves.iter().enumerate() {
        let color = Color::series(k);
        panel = panel.item(Item::line(
            format!("{gap:?} mm"),
            color,
            found.curve.clone(),
        ));
        let answer = &found.answer;
        panel = panel.item(Item::MarkPoint {
            x: answer.operating_frequency_hz,
            y: answer.force_ratio,
            label: format!("{:.3} Hz", answer.operating_frequency_hz),
            color,
        });
    }
    panel
}

/// What the rows show, in numbers.
fn summary(rows: &[Row], refused: &[String]) -> String {
    let mut text = verdict(rows);
    for (rig, gaps) in RIGS {
        let of: Vec<&Row> = rows.iter().filter(|r| r.rig == rig).collect();
        let Some(zero) = of.iter().find(|r| r.gap_mm == gaps[0]) else {
            continue;
        };
        text += &format!(
            "{rig}: run at {:.3} Hz (Ω/ω = {:.2}) with no gap, for {:.1} m g ({:.1} at worst), {}, band {:.1} % wide, {}, {:.0} % of starts reach 1/1.",
            zero.frequency_hz,
            zero.frequency_ratio,
            zero.force_ratio,
            zero.force_ratio_worst,
            jumps(zero),
            zero.safe_band_percent,
            end(zero),
            zero.one_one_from_percent
        );
        for row in of.iter().filter(|r| r.gap_mm != gaps[0]) {
            text += &format!(
                " At {:?} mm {:+.0} % of force ({:.1} m g at {:.3} Hz), {}, band {:.1} % wide, {}, {:.0} % of starts reach 1/1.",
                row.gap_mm,
                100.0 * (row.force_ratio / zero.force_ratio - 1.0),
                row.force_ratio,
                row.frequency_hz,
                jumps(row),
                row.safe_band_percent,
                end(row),
                row.one_one_from_percent
            );
        }
        text += " ";
    }
    for line in refused {
        text += &format!("Not to be run: {line}. ");
    }
    text.trim_end().to_owned()
}

/// On how many rigs the chapter's recommendation of 0.0 mm holds.
fn verdict(rows: &[Row]) -> String {
    let (mut asked, mut forceful, mut steady, mut wide) = (0, 0, 0, 0);
    for (rig, gaps) in RIGS {
        let (zero, others): (Vec<&Row>, Vec<&Row>) = rows
            .iter()
            .filter(|r| r.rig == rig)
            .partition(|r| r.gap_mm == gaps[0]);
        let [zero] = zero[..] else { continue };
        asked += 1;
        let best = others.iter().map(|r| r.force_ratio).fold(0.0, f64::max);
        forceful += usize::from(zero.force_ratio >= 0.95 * best);
        steady += usize::from(zero.jumps_from_hz.is_none());
        let narrower = |r: &&Row| r.safe_band_percent < zero.safe_band_percent;
        wide += usize::from(others.iter().all(narrower));
    }
    let word = if forceful.min(steady).min(wide) == asked {
        "Agrees"
    } else {
        "Differs in part"
    };
    format!(
        "{word}: of {asked} rigs, {forceful} strike at 0.0 mm within 5 % of the hardest of the other gaps or harder, {steady} do not jump there, and {wide} have their widest band there. "
    )
}

fn jumps(row: &Row) -> String {
    match (row.jumps_from_hz, row.jumps_to_hz) {
        (Some(low), Some(high)) => format!("jumps {}", jumping_at(low, high)),
        _ => "no jumps".to_owned(),
    }
}

fn end(row: &Row) -> String {
    format!(
        "1/1 ends {:.0} % higher by {}",
        row.one_one_margin_percent, row.one_one_ends_by
    )
}

/// The end of a branch in words.
fn name_of(end: End) -> String {
    let name = serde_json::to_value(end).ok();
    let name = name.as_ref().and_then(|name| name.as_str());
    name.unwrap_or("an unknown end").replace('_', " ")
}
