//! What is asked of a map, and how it is cut into tiles for threads.

use std::ops::Range;

use shared::model::params::{RigParams, WIRES};

use super::Grid;
use crate::engine::{Setting, check_frequency, check_recorded};
use crate::error::{Error, MapError};
use crate::lanes::CellPlan;
use crate::row::NamedRig;
use crate::row::tidy;
use crate::sweep::Direction;

/// What runs the cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Runner {
    /// The fast engine ([`crate::lanes::run`]).
    Lanes,
    /// The event-located reference, cell by cell: slow, for checks.
    Reference,
    /// The switch model at a fixed tick, as the microcontroller sees the rig.
    Switch(Setting),
}

impl Runner {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lanes => "event",
            Self::Reference => "reference",
            Self::Switch(_) => "switch",
        }
    }
}

/// Everything that decides what a map shows.
#[derive(Clone, Debug, PartialEq)]
pub struct MapRequest {
    /// The rig; its own gap does not count.
    pub rig: NamedRig,
    /// Gaps and drive frequencies of the cells.
    pub grid: Grid,
    /// The engine that runs the cells.
    pub runner: Runner,
    /// Cycles, and how many of the last are recorded.
    pub plan: CellPlan,
    /// Cells that have not settled run on up to so many cycles; none: they stay as they are.
    pub settle: Option<u32>,
    /// From rest, or the state carried up or down the frequencies of each gap.
    pub from: Direction,
}

/// Cells of a tile, from rest: some tenths of a second of work for the fast engine.
const TILE_CELLS: usize = 2048;

/// For the slow engines: some tens of seconds of work.
const SLOW_TILE_CELLS: usize = 128;

/// Gaps of a tile when the state is carried: the gaps run side by side, each along its frequencies.
const TILE_GAPS: usize = 32;
const SLOW_TILE_GAPS: usize = 1;

impl MapRequest {
    /// Cells of every tile but the last, which may have fewer. It depends on the request alone.
    fn tile_cells(&self) -> usize {
        let slow = self.runner != Runner::Lanes;
        match (self.from, slow) {
            (Direction::Rest, false) => TILE_CELLS,
            (Direction::Rest, true) => SLOW_TILE_CELLS,
            (_, false) => TILE_GAPS * self.grid.frequencies_hz.len(),
            (_, true) => SLOW_TILE_GAPS * self.grid.frequencies_hz.len(),
        }
    }

    /// How many tiles there are.
    pub(super) fn tiles(&self) -> usize {
        self.grid.len().div_ceil(self.tile_cells().max(1))
    }

    /// The cells of a tile: consecutive, row by row.
    pub(super) fn tile(&self, index: usize) -> Range<usize> {
        let from = index * self.tile_cells();
        from..(from + self.tile_cells()).min(self.grid.len())
    }

    /// The rig at `gap_mm`.
    pub fn params_at(&self, gap_mm: f64) -> RigParams {
        RigParams {
            gap_m: gap_mm * 1e-3,
            ..self.rig.params
        }
    }

    /// Refuses what cannot be run, before any work.
    ///
    /// # Errors
    /// If there are no cells or too many, if a frequency is out of range, or if no cycle would be recorded.
    pub fn check(&self) -> Result<(), Error> {
        let cells = self.grid.len();
        if cells == 0 || cells > MOST_CELLS {
            return Err(MapError::Cells {
                cells,
                most: MOST_CELLS,
            }
            .into());
        }
        for hz in &self.grid.frequencies_hz {
            check_frequency(*hz, &self.rig.params)?;
        }
        let cycles = self.plan.cycles;
        check_recorded(self.plan.recorded, cycles)?;
        match self.settle {
            Some(settle) if settle <= cycles => Err(MapError::Settle { settle, cycles }.into()),
            _ => Ok(()),
        }
    }
}

/// More are refused: they would need gigabytes.
const MOST_CELLS: usize = 20_000_000;

/// The chapter's gaps, mm: 0 to 3.56 in steps of 0.01, for A0 = 0.89 mm; for another A0 the same gap/A0.
pub fn chapter_gaps_mm(params: &RigParams) -> Vec<f64> {
    let scale = params.amplitude_m / WIRES.amplitude_m;
    (0..357)
        .map(|i| tidy(f64::from(i) * 0.01 * scale))
        .collect()
}

/// The chapter's frequencies, Hz: 1.41 to 7.28 in steps of 0.01 on wires; for another rig the same Ω/ω.
pub fn chapter_frequencies_hz(params: &RigParams) -> Vec<f64> {
    let scale = params.natural_frequency_hz() / WIRES.natural_frequency_hz();
    let hz = |i: u32| tidy(tidy(1.41 + f64::from(i) * 0.01) * scale);
    (0..588).map(hz).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use shared::model::params::PRESETS;

    #[test]
    fn the_default_is_the_chapter_s_grid_over_the_same_ratios_for_every_rig() {
        let hz = chapter_frequencies_hz(&WIRES);
        assert_eq!((hz.len(), hz[0], hz[587]), (588, 1.41, 7.28));
        let gaps = chapter_gaps_mm(&WIRES);
        assert_eq!((gaps.len(), gaps[7], gaps[356]), (357, 0.07, 3.56));
        assert_eq!(gaps.len() * hz.len(), 209_916);
        for (_, params) in PRESETS {
            let hz = chapter_frequencies_hz(&params);
            let ratio = hz[587] / params.natural_frequency_hz();
            let wires = 7.28 / WIRES.natural_frequency_hz();
            assert!((ratio / wires - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn tiles_cover_every_cell_once_and_chains_are_not_cut() {
        for (from, runner) in [
            (Direction::Rest, Runner::Lanes),
            (Direction::Up, Runner::Lanes),
            (Direction::Down, Runner::Reference),
        ] {
            let request = MapRequest {
                rig: NamedRig::new("wires", WIRES),
                grid: Grid {
                    gaps_mm: (0..70).map(f64::from).collect(),
                    frequencies_hz: (1..=59).map(f64::from).collect(),
                },
                runner,
                plan: CellPlan::CHAPTER,
                settle: None,
                from,
            };
            let mut next = 0;
            for tile in 0..request.tiles() {
                let cells = request.tile(tile);
                assert_eq!(cells.start, next);
                assert!(!cells.is_empty());
                assert!(from == Direction::Rest || cells.start.is_multiple_of(59));
                next = cells.end;
            }
            assert_eq!(next, request.grid.len());
        }
    }
}
