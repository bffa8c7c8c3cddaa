//! Millions of short simulations: cells of a map, initial conditions of a basin, points of a diagram.
//!
//! A [`Cell`] is one simulation; [`run`] takes many and gives an [`Outcome`] each, in their order. Nothing is kept per
//! step; what a cell showed is reduced as it runs.
//!
//! Cells run side by side in the lanes of vector registers: flight by Taylor steps ([`flight`]), contact in closed form
//! ([`touch`], and [`stay`] where that does not fit), both switches located on the step's own polynomial ([`pool`] is the
//! loop, [`reduce`] the end). What the lanes cannot run or find uncertain goes to the reference. `docs/lanes.md` has the
//! figures.

mod constants;
mod fast;
mod flight;
mod number;
mod one;
mod pool;
mod reduce;
mod stay;
mod touch;

use rayon::prelude::*;
use shared::params::RigParams;
use shared::regime::Regime;

use crate::engine::Engine;
use crate::error::UserError;

pub use fast::{How, Instructions, Precision, Report, run_with};
pub use one::run_one;
pub use pool::Work;
pub use reduce::SETTLED_WITHIN;

/// One simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// The rig, with its gap.
    pub params: RigParams,
    /// Drive frequency Ω/2π, Hz.
    pub frequency_hz: f64,
    /// Coordinate and rate at the start, in the rig's coordinate ([`shared::rig`]).
    pub start: [f64; 2],
    /// Drive phase at the start, turns from 0 to below 1. The section stays at phase 0: what comes before the first
    /// phase 0 is not counted as a cycle.
    pub phase: f64,
}

/// How long to run, and what to keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Drive cycles at most.
    pub cycles: u32,
    /// How many of the last are recorded: regime and force are told from them.
    pub recorded: u32,
    /// Whether a cell may stop before `cycles` once its section has converged.
    pub early: bool,
    /// How many strobes (the last ones) are kept in [`Outcome::strobes`].
    pub strobes: u32,
}

impl Plan {
    /// The chapter's: 300 cycles, the last 100 recorded.
    pub const CHAPTER: Self = Self {
        cycles: 300,
        recorded: 100,
        early: true,
        strobes: 0,
    };
}

/// A point of the section, and what happened in the drive period that ended with it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Strobe {
    /// Coordinate.
    pub q: f64,
    /// Its rate.
    pub v: f64,
    /// Largest contact force of the period, N.
    pub force_n: f64,
    /// Contacts that began in the period.
    pub onsets: u16,
}

/// What a cell showed.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// The regime over the recorded cycles.
    pub regime: Regime,
    /// Largest contact force in the recorded cycles, N.
    pub force_n: f64,
    /// Cycle after which the section had converged on the orbit it keeps to; none: it had not.
    pub settled_after: Option<u32>,
    /// Cycles run.
    pub cycles: u32,
    /// Longest section period looked for.
    pub searched: u8,
    /// Cycle in which the hammer last touched the surface, counted from 1; none: never.
    pub last_contact: Option<u32>,
    /// Whether an event of the fast engine was uncertain, so that the cell was run again by the reference.
    pub uncertain: bool,
    /// The section at the end: coordinate and rate.
    pub section: [f64; 2],
    /// The last strobes, oldest first, as many as the plan wants and were run.
    pub strobes: Vec<Strobe>,
}

/// Cells per piece of work of a thread. Outcomes do not depend on it.
const CHUNK: usize = 512;

/// Runs every cell, on every thread there is.
///
/// # Errors
/// The first cell whose parameters, frequency or start cannot be, or whose hammer leaves what the model describes.
pub fn run(cells: &[Cell], plan: &Plan) -> Result<Vec<Outcome>, UserError> {
    run_reported(cells, plan).map(|(outcomes, _)| outcomes)
}

/// Runs every cell, on every thread there is, and tells what became of them.
///
/// # Errors
/// As [`run`].
pub fn run_reported(cells: &[Cell], plan: &Plan) -> Result<(Vec<Outcome>, Report), UserError> {
    let parts: Vec<_> = cells
        .par_chunks(CHUNK)
        .map(|chunk| run_with(How::default(), chunk, plan))
        .collect::<Result<_, _>>()?;
    let mut report = Report::default();
    let mut outcomes = Vec::with_capacity(cells.len());
    for (part, done) in parts {
        outcomes.extend(part);
        report += done;
    }
    Ok((outcomes, report))
}

/// Runs every cell in this thread: for work that is shared out by the caller. The same outcomes as [`run`].
///
/// # Errors
/// As [`run`].
pub fn run_serial(cells: &[Cell], plan: &Plan) -> Result<Vec<Outcome>, UserError> {
    run_with(How::default(), cells, plan).map(|(outcomes, _)| outcomes)
}

/// Runs every cell by `engine`, one after the other in every thread: the reference for an audit, or the switch model.
///
/// # Errors
/// As [`run`].
pub fn by_engine(engine: Engine, cells: &[Cell], plan: &Plan) -> Result<Vec<Outcome>, UserError> {
    cells
        .par_iter()
        .map(|cell| run_one(engine, cell, plan))
        .collect()
}
