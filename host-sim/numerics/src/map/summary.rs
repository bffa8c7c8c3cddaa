//! What a map comes to, in a few numbers.

use serde::Serialize;
use shared::model::regime::Regime;

use super::Map;
use crate::row::{Outcome, kind};

/// A map in a few numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MapSummary {
    /// Cells of the map, failed ones included.
    pub cells: usize,
    /// How many show what, the most frequent first.
    pub regimes: Vec<RegimeShare>,
    /// Cells whose section had converged.
    pub settled: usize,
    /// Cells whose motion still changed: their regime is not known.
    pub unsettled: usize,
    /// Cells flagged as uncertain, and run again by the reference.
    pub uncertain: usize,
    /// Where z = 1/1 has the largest force, if there is one.
    pub strongest_one_one: Option<StrongestCell>,
    /// Where the force is largest whatever the regime, if the hammer strikes anywhere.
    pub strongest_of_all: Option<StrongestCell>,
    /// Cells whose hammer could not be followed; they are none of the regimes.
    pub failed: usize,
}

/// How many cells show a regime.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RegimeShare {
    /// The regime, without its count of impacts if it is aperiodic or chatter; or that the motion still changes.
    pub regime: Outcome,
    /// Cells that show it.
    pub cells: usize,
}

/// The cell with the largest force.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StrongestCell {
    /// Regime of the cell, or that it has not settled.
    pub regime: Outcome,
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// Drive frequency over the natural frequency, Ω/ω.
    pub frequency_ratio: f64,
    /// Contact force over m g.
    pub force_ratio: f64,
    /// Largest contact force in the recorded cycles, N.
    pub force_n: f64,
}

impl MapSummary {
    /// The summary of `map`.
    pub fn of(map: &Map) -> Self {
        let mut regimes: Vec<RegimeShare> = Vec::new();
        // Neighbours are mostly alike: the kinds are few, and the last one found is tried first.
        let mut last = 0;
        for cell in map.cells.iter().filter(|c| !c.failed) {
            let kind = Outcome::new(kind(cell.regime), cell.unsettled, false);
            if regimes.get(last).is_none_or(|s| s.regime != kind) {
                let found = regimes.iter().position(|s| s.regime == kind);
                last = found.unwrap_or(regimes.len());
            }
            if last == regimes.len() {
                regimes.push(RegimeShare {
                    regime: kind,
                    cells: 0,
                });
            }
            regimes[last].cells += 1;
        }
        // Stable: of equally frequent ones the first met stays first.
        regimes.sort_by_key(|share| std::cmp::Reverse(share.cells));
        let count =
            |which: fn(&super::MapCell) -> bool| map.cells.iter().filter(|c| which(c)).count();
        Self {
            cells: map.cells.len(),
            regimes,
            settled: count(|c| c.settled_after.is_some()),
            unsettled: count(|c| c.unsettled),
            uncertain: count(|c| c.uncertain),
            strongest_one_one: strongest(map, |regime| regime.is(1, 1)),
            strongest_of_all: strongest(map, |regime| regime != Regime::None),
            failed: count(|c| c.failed),
        }
    }
}

/// The strongest of the cells whose regime is one of those asked for; of equals the first.
fn strongest(map: &Map, asked: impl Fn(Regime) -> bool) -> Option<StrongestCell> {
    let force = |i: usize| map.cells[i].force_n;
    let cells =
        (0..map.cells.len()).filter(|i| !map.cells[*i].failed && asked(map.cells[*i].regime));
    let index = cells.reduce(|a, b| if force(b) > force(a) { b } else { a })?;
    let (gap_mm, frequency_hz) = map.grid.at(index);
    Some(StrongestCell {
        regime: map.cells[index].label(),
        gap_mm,
        frequency_hz,
        frequency_ratio: frequency_hz / map.rig.params.natural_frequency_hz(),
        force_ratio: map.force_ratio(index),
        force_n: force(index),
    })
}
