//! Millions of short simulations: cells of a map, initial conditions of a basin, points of a diagram.
//!
//! A [`Cell`] is one simulation; [`run`] takes many and gives a [`CellOutcome`] each, in their order. Nothing is kept per
//! step; what a cell showed is reduced as it runs.
//!
//! Cells run side by side in the lanes of vector registers (the crate `lanes`); what the lanes cannot run or find
//! uncertain goes to the reference. `docs/lanes.md` has the figures.

mod fast;
mod one;

use shared::model::params::RigParams;

use crate::engine::{Engine, Plan};
use crate::error::Error;
use crate::parallel;

pub use ::lanes::{
    Cell, CellOutcome, CellPlan, Instructions, LaneStrobe, SETTLED_WITHIN, Strobes, Work,
};
pub use fast::{Report, run_with};
pub use one::run_one;
pub(crate) use one::strobes;

/// Cells per piece of work of a thread: enough that lanes left over at its end do not matter. Outcomes do not depend on
/// it.
const CHUNK: usize = 2048;

/// Runs every cell, on every thread there is.
///
/// # Errors
/// If a cell has a parameter, frequency or start out of range, or its hammer leaves what the model describes: the
/// first such cell.
pub fn run(cells: &[Cell], plan: &CellPlan) -> Result<Vec<CellOutcome>, Error> {
    run_reported(cells, plan).map(|(outcomes, _)| outcomes)
}

/// Runs every cell, on every thread there is, and reports how many were run by what.
///
/// # Errors
/// As [`run`].
pub fn run_reported(cells: &[Cell], plan: &CellPlan) -> Result<(Vec<CellOutcome>, Report), Error> {
    let chunks: Vec<_> = cells.chunks(CHUNK).collect();
    let parts = parallel::try_map(&chunks, |chunk| run_with(Instructions::Widest, chunk, plan))?;
    let mut report = Report::default();
    let mut outcomes = Vec::with_capacity(cells.len());
    for (part, done) in parts {
        outcomes.extend(part);
        report += done;
    }
    Ok((outcomes, report))
}

/// Runs every cell, on every thread there is: a cell whose hammer cannot be followed is an error of its own and takes
/// no other with it.
pub fn run_each(cells: &[Cell], plan: &CellPlan) -> Vec<Result<CellOutcome, Error>> {
    let chunks: Vec<_> = cells.chunks(CHUNK).collect();
    let parts = parallel::map(&chunks, |chunk| {
        fast::each(Instructions::Widest, chunk, plan, &mut Report::default()).collect::<Vec<_>>()
    });
    parts.into_iter().flatten().collect()
}

/// [`run_each`] by `engine` instead of the lanes, one cell after the other in every thread.
pub fn each_by_engine(
    engine: Engine,
    cells: &[Cell],
    plan: &CellPlan,
) -> Vec<Result<CellOutcome, Error>> {
    parallel::map(cells, |cell| run_one(engine, cell, plan))
}

/// An outcome, or none where the hammer could not be followed.
///
/// # Errors
/// Any other error.
pub fn or_failed(outcome: Result<CellOutcome, Error>) -> Result<Option<CellOutcome>, Error> {
    match outcome {
        Ok(outcome) => Ok(Some(outcome)),
        Err(Error::Motion(_)) => Ok(None),
        Err(error) => Err(error),
    }
}

/// A run of `plan` from the section point `start` in a lane; none where the lanes must leave it to the reference.
pub(crate) fn settled(
    params: &RigParams,
    frequency_hz: f64,
    start: [f64; 2],
    plan: Plan,
) -> Option<CellOutcome> {
    let cell = Cell {
        params: *params,
        frequency_hz,
        start,
        phase: 0.0,
    };
    let plan = CellPlan {
        cycles: plan.cycles,
        recorded: plan.cycles - plan.transient,
        early: true,
        strobes: 0,
    };
    let tried = ::lanes::try_run(Instructions::Widest, &[cell], &plan);
    tried.outcomes.into_iter().next()?
}
