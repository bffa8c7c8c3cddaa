//! Basins of attraction (figures 3.36–3.38 and 3.52–3.54): from which starts contact goes on for good, and on what
//! motion the hammer settles.
//!
//! A grid of starts gives the picture, its entropy and shares with the mesh's own error. A random sample of
//! starts gives shares with a confidence interval, and, run much longer, how the picture changes with the number of cycles one waits.

pub mod attractors;
pub mod cells;
pub mod chapter;
pub mod entropy;
pub mod share;
pub mod start;
mod summary;
#[cfg(test)]
mod tests;

use serde::Serialize;

use crate::engine::{Engine, check_recorded};
use crate::error::{BasinsError, Error, StartError};
use crate::progress::Progress;
use crate::range::within_samples;
use crate::row::NamedRig;
pub use attractors::{Attractor, AttractorKind, AttractorName};
pub use entropy::{Entropy, StartUncertainty};
pub use share::SampledShare;
pub use start::{BasinDrive, Fate, StartWindow};
pub use summary::{AttractorShare, BasinsSummary};

/// Which basins are asked for: rig, drive, window of starts, and how long each start is run.
#[derive(Clone, Debug, PartialEq)]
pub struct BasinsRequest {
    /// The rig, with its gap.
    pub rig: NamedRig,
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// Drive phase at the start, turns from 0 to below 1.
    pub phase: f64,
    /// Window of starts, with the grid of cells it is cut into.
    pub window: StartWindow,
    /// Drive cycles of each.
    pub cycles: u32,
    /// How many of the last are recorded.
    pub recorded: u32,
    /// Random starts; 0: none.
    pub samples: u32,
    /// Seed of the random starts: the same seed draws the same starts.
    pub seed: u64,
    /// Cycles to which random starts are run on, for the table over cycles.
    pub until: u32,
}

/// Cycles between the rows of the table over cycles.
const COMPARED_EVERY: u32 = 50;

impl BasinsRequest {
    /// The chapter's: the usual window at phase 0, 300 cycles with 100 recorded; 2000 random starts, run on to 1000.
    pub fn usual(rig: NamedRig, frequency_hz: f64, columns: usize, rows: usize) -> Self {
        let window = StartWindow::usual(&rig.params, columns, rows);
        Self {
            rig,
            frequency_hz,
            phase: 0.0,
            window,
            cycles: 300,
            recorded: 100,
            samples: 2000,
            seed: 1,
            until: 1000,
        }
    }

    /// Starts run in all, which is what progress counts.
    pub fn runs(&self) -> u64 {
        let grid = self.window.columns * self.window.rows;
        grid as u64 + 2 * u64::from(self.samples)
    }

    /// Refuses what cannot be asked, before anything runs.
    ///
    /// # Errors
    /// If the window, the number of cells, the phase, the cycles or the samples are out of range.
    pub fn check(&self) -> Result<(), Error> {
        let [x, v] = [self.window.displacement_m, self.window.velocity_m_per_s];
        for (side, [from, to]) in [("displacement", x), ("velocity", v)] {
            if !(from < to && from.is_finite() && to.is_finite()) {
                return Err(BasinsError::Window { side, from, to }.into());
            }
        }
        if !(0.0..1.0).contains(&self.phase) {
            return Err(StartError::Phase(self.phase).into());
        }
        let cells = self.window.columns.saturating_mul(self.window.rows);
        if !(1..=MOST_CELLS).contains(&cells) {
            return Err(BasinsError::Cells {
                columns: self.window.columns,
                rows: self.window.rows,
                most: MOST_CELLS,
            }
            .into());
        }
        let (cycles, until) = (self.cycles, self.until);
        check_recorded(self.recorded, cycles)?;
        if until < cycles {
            return Err(BasinsError::Until { until, cycles }.into());
        }
        within_samples(self.samples, MOST_SAMPLES)
    }
}

/// Random starts at most.
const MOST_SAMPLES: u32 = 1_000_000;

/// Cells of a grid at most: what is kept of each is held in memory.
const MOST_CELLS: usize = 4_000_000;

/// Share of the random starts that still touch after some number of cycles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ImpactAfter {
    /// The number of cycles.
    pub cycles: u32,
    /// Starts with a contact in the recorded cycles before.
    pub impact: SampledShare,
}

/// The basins found: what became of each start, the attractors, and the share of impact over the cycles.
#[derive(Clone, Debug)]
pub struct Basins {
    /// The request that these basins answer.
    pub query: BasinsRequest,
    /// What became of the grid's starts, in the order of [`StartWindow::starts`].
    pub grid: Vec<Fate>,
    /// Which attractor each ends in, an index of `attractors`.
    pub which: Vec<u16>,
    /// What became of the random starts.
    pub random: Vec<Fate>,
    /// Which attractor each of those ends in.
    pub random_which: Vec<u16>,
    /// The attractors, those with most starts of both kinds first.
    pub attractors: Vec<Attractor>,
    /// Share of impact over the number of cycles; empty without random starts.
    pub over_cycles: Vec<ImpactAfter>,
}

/// Finds the basins.
///
/// # Errors
/// As [`BasinsRequest::check`]; also if a parameter or the frequency is out of range, if a start is out of the rig's
/// reach, or if the work is interrupted.
pub fn explore(
    engine: Engine,
    query: &BasinsRequest,
    progress: &dyn Progress,
) -> Result<Basins, Error> {
    query.check()?;
    let drive = BasinDrive {
        params: query.rig.params,
        frequency_hz: query.frequency_hz,
        phase: query.phase,
    };
    let run = |starts: &[[f64; 2]], cycles: u32| {
        start::fates(engine, &drive, starts, cycles, query.recorded, progress)
    };
    let mut fates = run(&query.window.starts(), query.cycles)?;
    let cells = fates.len();
    let sample = query.window.sample(query.samples, query.seed);
    fates.extend(run(&sample, query.cycles)?);
    let (attractors, mut which) = attractors::tell_apart(&fates);
    let over_cycles = if sample.is_empty() {
        Vec::new()
    } else {
        let (at, of) = (cycles_compared(query), sample.len() as u64);
        let counts = start::touching(engine, &drive, &sample, &at, query.recorded, progress)?;
        let share = |(cycles, count)| ImpactAfter {
            cycles,
            impact: SampledShare::wilson(count, of),
        };
        at.into_iter().zip(counts).map(share).collect()
    };
    Ok(Basins {
        query: query.clone(),
        random: fates.split_off(cells),
        grid: fates,
        random_which: which.split_off(cells),
        which,
        attractors,
        over_cycles,
    })
}

/// The numbers of cycles that are compared.
fn cycles_compared(query: &BasinsRequest) -> Vec<u32> {
    let from = query.recorded.max(COMPARED_EVERY);
    let mut at: Vec<u32> = (from..=query.until)
        .step_by(COMPARED_EVERY as usize)
        .collect();
    if at.last() != Some(&query.until) {
        at.push(query.until);
    }
    at
}

impl Basins {
    /// Share of the grid for which `is` holds (given fate and attractor), and the mesh's own error
    /// ([`share::on_grid`]).
    pub fn grid_share(&self, is: impl Fn(&Fate, u16) -> bool) -> (f64, Option<f64>) {
        let window = &self.query.window;
        share::on_grid(window.columns, window.rows, |column, row| {
            let i = row * window.columns + column;
            is(&self.grid[i], self.which[i])
        })
    }

    /// Share of the random starts for which `is` holds, with its interval.
    pub fn random_share(&self, is: impl Fn(&Fate, u16) -> bool) -> SampledShare {
        let all = self.random.iter().zip(&self.random_which);
        let count = all.filter(|(fate, which)| is(fate, **which)).count();
        SampledShare::wilson(count as u64, self.random.len() as u64)
    }

    /// Impact 1, no impact 0, cell by cell.
    pub fn impact_picture(&self) -> Vec<u16> {
        self.grid.iter().map(|f| u16::from(f.impacts())).collect()
    }

    /// The summary a program reads.
    pub fn summary(&self) -> BasinsSummary {
        BasinsSummary::new(self)
    }
}
