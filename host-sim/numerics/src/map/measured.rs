//! Measured regimes, to lay over a map (figure 3.25).

use serde::Serialize;
use shared::model::regime::Regime;

use super::agree::{places, same_label};
use super::{Map, MapCell};

/// A regime measured at one gap and drive frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredRegime {
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// Regime measured there.
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

/// The points that lie on the map, each with what the nearest cell shows.
pub fn on_map<'a>(points: &[MeasuredRegime], map: &'a Map) -> Vec<(MeasuredRegime, &'a MapCell)> {
    let gaps: Vec<f64> = points.iter().map(|p| p.gap_mm).collect();
    let frequencies: Vec<f64> = points.iter().map(|p| p.frequency_hz).collect();
    let rows = places(&gaps, &map.grid.gaps_mm);
    let columns = places(&frequencies, &map.grid.frequencies_hz);
    let at = rows.into_iter().zip(columns);
    let seen = points.iter().zip(at);
    seen.filter_map(|(point, at)| Some((*point, map.cell(at.0?, at.1?))))
        .collect()
}

/// Compares every point with the nearest cell.
pub fn hits(points: &[MeasuredRegime], map: &Map) -> Hits {
    let inside = on_map(points, map);
    // A run that failed shows nothing, which is not "no contact".
    let same = |(point, here): &&(MeasuredRegime, &MapCell)| {
        !here.failed && same_label(here.regime, point.regime)
    };
    Hits {
        points: inside.len(),
        outside: points.len() - inside.len(),
        same: inside.iter().filter(same).count(),
    }
}
