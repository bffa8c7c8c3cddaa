//! Measured regimes, to lay over a map (figure 3.25).

use std::path::Path;

use serde::Serialize;
use shared::model::regime::{MAX_PERIODS, Regime};

use super::Map;
use super::agree::{places, same_label};
use crate::error::UserError;
use crate::table::{Line, read_columns};

/// One measured point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// What was seen.
    pub regime: Regime,
}

/// How a map agrees with what was measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Hits {
    /// Points that lie on the map.
    pub points: usize,
    /// Points outside it, not compared.
    pub outside: usize,
    /// Points whose nearest cell has the regime measured.
    pub same: usize,
}

/// Reads a CSV with the columns gap_mm, frequency_hz and regime ("1/1", "none", "aperiodic" or "chatter").
///
/// # Errors
/// One line naming file, line and mend.
pub fn read(path: &Path) -> Result<Vec<Measured>, UserError> {
    let point = |line: &Line| {
        let frequency_hz = line.number("frequency_hz")?;
        if frequency_hz <= 0.0 {
            return Err(line.complaint(format!("frequency_hz is {frequency_hz}, must be positive")));
        }
        let text = line.text("regime");
        let regime = regime(text).ok_or_else(|| {
            line.complaint(format!(
                "regime is '{text}', must be p/n such as 1/1, or none, aperiodic or chatter"
            ))
        })?;
        Ok(Measured {
            gap_mm: line.number("gap_mm")?,
            frequency_hz,
            regime,
        })
    };
    let lines = read_columns(path, &["gap_mm", "frequency_hz", "regime"])?;
    lines.iter().map(point).collect()
}

/// A regime by its name; how many impacts an aperiodic one has is not said by it.
fn regime(text: &str) -> Option<Regime> {
    match text {
        "none" => Some(Regime::None),
        "aperiodic" => Some(Regime::Aperiodic { impacts: 0 }),
        "chatter" => Some(Regime::Chatter {
            impacts: 0,
            periods: None,
        }),
        _ => {
            let (impacts, periods) = text.split_once('/')?;
            let (impacts, periods) = (impacts.trim().parse().ok()?, periods.trim().parse().ok()?);
            let known = (1..=MAX_PERIODS).contains(&usize::from(periods));
            known.then_some(Regime::Periodic { impacts, periods })
        }
    }
}

/// The points that lie on the map, each with what the nearest cell shows.
pub fn on_map(points: &[Measured], map: &Map) -> Vec<(Measured, Regime)> {
    let gaps: Vec<f64> = points.iter().map(|p| p.gap_mm).collect();
    let frequencies: Vec<f64> = points.iter().map(|p| p.frequency_hz).collect();
    let rows = places(&gaps, &map.grid.gaps_mm);
    let columns = places(&frequencies, &map.grid.frequencies_hz);
    let at = rows.into_iter().zip(columns);
    let seen = points.iter().zip(at);
    seen.filter_map(|(point, at)| Some((*point, map.cell(at.0?, at.1?).regime)))
        .collect()
}

/// Compares every point with the nearest cell.
pub fn hits(points: &[Measured], map: &Map) -> Hits {
    let inside = on_map(points, map);
    let same = |(point, here): &&(Measured, Regime)| same_label(*here, point.regime);
    Hits {
        points: inside.len(),
        outside: points.len() - inside.len(),
        same: inside.iter().filter(same).count(),
    }
}
