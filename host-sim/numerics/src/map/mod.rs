//! The Peterka map: what the hammer does over gap and drive frequency (figures 3.24–3.26 and 3.46–3.51).
//!
//! A [`Map`] is a [`Grid`] and a [`MapCell`] for each of its points. Its layers (p, n, regime, force, settling) are
//! fields of the cells.

pub mod agree;
mod compute;
pub mod measured;
pub mod request;
mod run;
pub mod summary;

use serde::Serialize;
use shared::model::regime::Regime;

pub use self::agree::{Agreement, Similarity, audit, similarity};
pub use self::request::{MapRequest, Runner};
pub use self::run::run;
pub use self::summary::{MapSummary, RegimeShare, StrongestCell};
use crate::lanes::CellOutcome;
use crate::row::CartModel;
use crate::row::{self, NamedRig, tidy};
use crate::sweep::Direction;

/// The points of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Clearances at rest, mm, rising.
    pub gaps_mm: Vec<f64>,
    /// Drive frequencies Ω/2π, Hz, rising.
    pub frequencies_hz: Vec<f64>,
}

impl Grid {
    /// How many cells it has.
    pub fn len(&self) -> usize {
        self.gaps_mm.len() * self.frequencies_hz.len()
    }

    /// Whether it has none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Gap (mm) and frequency (Hz) of the cell at `index`.
    ///
    /// # Panics
    /// If there is no such cell.
    pub fn at(&self, index: usize) -> (f64, f64) {
        let columns = self.frequencies_hz.len();
        (
            self.gaps_mm[index / columns],
            self.frequencies_hz[index % columns],
        )
    }
}

/// The part of a cell's [`CellOutcome`] that a map keeps: it has the same size for every cell, and no strobes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapCell {
    /// z = p/n over the recorded cycles.
    pub regime: Regime,
    /// Largest contact force in the recorded cycles, N.
    pub force_n: f64,
    /// Cycle after which the section had converged; none: it had not.
    pub settled_after: Option<u32>,
    /// Whether what the regime calls the motion may pass: it still changes.
    pub unsettled: bool,
    /// Longest section period searched for.
    pub searched: u8,
    /// Whether the fast engine was uncertain, so that the reference ran the cell again.
    pub uncertain: bool,
    /// Whether the hammer could not be followed, so that the other fields say nothing.
    pub failed: bool,
}

impl MapCell {
    /// A cell whose hammer left what the model describes.
    pub const FAILED: Self = Self {
        regime: Regime::None,
        force_n: 0.0,
        settled_after: None,
        unsettled: false,
        searched: 0,
        uncertain: false,
        failed: true,
    };

    /// Its regime, or that it has not settled or failed.
    pub fn label(&self) -> row::Outcome {
        row::Outcome::new(self.regime, self.unsettled, self.failed)
    }
}

impl From<&CellOutcome> for MapCell {
    fn from(seen: &CellOutcome) -> Self {
        Self {
            regime: seen.regime,
            force_n: seen.force_n,
            settled_after: seen.settled_after,
            unsettled: seen.unsettled,
            searched: seen.searched,
            uncertain: seen.uncertain,
            failed: false,
        }
    }
}

/// A map with the rig it is of.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// The rig; its own gap does not count.
    pub rig: NamedRig,
    /// Where the cells are.
    pub grid: Grid,
    /// Whether its cells are from rest, or carried.
    pub from: Direction,
    /// Row-major: every frequency of the first gap, then of the second.
    pub cells: Vec<MapCell>,
}

impl Map {
    /// The cell at gap `row` and frequency `column`.
    ///
    /// # Panics
    /// If there is no such cell.
    pub fn cell(&self, row: usize, column: usize) -> &MapCell {
        &self.cells[row * self.grid.frequencies_hz.len() + column]
    }

    /// Ω/ω of every frequency.
    pub fn frequency_ratios(&self) -> Vec<f64> {
        let natural = self.rig.params.natural_frequency_hz();
        let ratio = |f: &f64| tidy(f / natural);
        self.grid.frequencies_hz.iter().map(ratio).collect()
    }

    /// Every gap over the cart amplitude A0.
    pub fn gap_ratios(&self) -> Vec<f64> {
        let amplitude_mm = self.rig.params.amplitude_m * 1e3;
        let ratio = |gap: &f64| tidy(gap / amplitude_mm);
        self.grid.gaps_mm.iter().map(ratio).collect()
    }

    /// Largest contact force over m g, of the cell at `index`.
    pub fn force_ratio(&self, index: usize) -> f64 {
        self.cells[index].force_n / self.rig.params.weight_n()
    }

    /// The rows of its table, cell by cell.
    pub fn rows(&self) -> impl Iterator<Item = CellRow> {
        let natural = self.rig.params.natural_frequency_hz();
        let weight_n = self.rig.params.weight_n();
        let cart = CartModel::of(&self.rig.params);
        self.cells.iter().enumerate().map(move |(index, cell)| {
            let (gap_mm, frequency_hz) = self.grid.at(index);
            CellRow {
                gap_mm,
                frequency_hz,
                frequency_ratio: tidy(frequency_hz / natural),
                impacts: cell.regime.impacts(),
                periods: cell.regime.periods(),
                regime: cell.label(),
                force_ratio: cell.force_n / weight_n,
                force_n: cell.force_n,
                settled: cell.settled_after.is_some(),
                settling_cycles: cell.settled_after,
                largest_period_searched: cell.searched,
                uncertain: cell.uncertain,
                failed: cell.failed,
                cart,
            }
        })
    }
}

/// One cell as a row of a table. Units are in the names.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CellRow {
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// Drive frequency Ω/2π, Hz.
    pub frequency_hz: f64,
    /// Drive frequency over the natural frequency, Ω/ω.
    pub frequency_ratio: f64,
    /// p: contacts in n periods; when nothing repeats, in the last 16 recorded periods.
    pub impacts: u16,
    /// n; none when the section does not repeat, or nothing touches.
    pub periods: Option<u8>,
    /// "p/n", "none", "aperiodic", "chatter", "unsettled" or "failed".
    pub regime: row::Outcome,
    /// Largest contact force in the recorded cycles over m g.
    pub force_ratio: f64,
    /// Largest contact force in the recorded cycles, N.
    pub force_n: f64,
    /// Whether the section had converged.
    pub settled: bool,
    /// After how many cycles.
    pub settling_cycles: Option<u32>,
    /// Longest section period searched for.
    pub largest_period_searched: u8,
    /// Whether the fast engine was uncertain, so that the reference ran the cell again.
    pub uncertain: bool,
    /// Whether the hammer left what the model describes, so that the other columns say nothing.
    pub failed: bool,
    /// How the cart is moved.
    pub cart: CartModel,
}
