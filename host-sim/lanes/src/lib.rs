//! Cells of a map, side by side in the lanes of vector registers, in dimensionless form and in one thread.
//!
//! | module | does |
//! |---|---|
//! | `flight` | flight by Taylor steps |
//! | `meet` | where in a step the surface is met, on the step's own polynomial |
//! | `root` | the root of that polynomial in an interval |
//! | `cart`, `linear` | a cart that recoils, split into what rings and what goes slowly |
//! | `ring` | its ring in flight, in all lanes at once |
//! | `touch` | contact in closed form, in all lanes at once |
//! | `sustained` | contacts that `touch` cannot represent, one at a time |
//! | `form` | the closed form of a contact at any time |
//! | `surface` | contacts by a law without a closed form, one at a time |
//! | `job` | what the lanes are given and count |
//! | `pool` | the loop over the lanes |
//! | `reduce` | what a cell showed, from its strobes |
//! | `width`, `number` | vectors of any instruction set, and formulas in them |
//! | `constants` | a cell in dimensionless form, if the lanes can run it |
//!
//! A cell that the lanes cannot run, or in which an event is uncertain, comes back without an outcome; the package
//! `numerics` gives it to the reference. This is a package of its own since its kernels, one per instruction set, take long to
//! compile.

mod cart;
mod constants;
mod dispatch;
mod flight;
mod form;
mod job;
mod linear;
mod meet;
mod number;
mod pool;
mod reduce;
mod ring;
mod root;
mod rows;
mod series;
mod settling;
mod surface;
mod sustained;
mod touch;
mod width;

use shared::model::params::RigParams;
use shared::model::regime::Regime;

pub use dispatch::{Instructions, Tried, try_run};
pub use job::Work;
pub use reduce::SETTLED_WITHIN;
pub use settling::Strobes;

/// A cell of a map: one simulation, by its rig, drive frequency and start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// The rig, with its gap.
    pub params: RigParams,
    /// Drive frequency Ω/2π, Hz.
    pub frequency_hz: f64,
    /// Coordinate and rate at the start, in the rig's coordinate ([`shared::model::rig`]).
    pub start: [f64; 2],
    /// Drive phase at the start, turns from 0 to below 1. The section stays at phase 0: what comes before the first
    /// phase 0 is not counted as a cycle.
    pub phase: f64,
}

/// How long to run, and what to keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellPlan {
    /// Drive cycles at most.
    pub cycles: u32,
    /// How many of the last are recorded: regime and force are those of the recorded cycles.
    pub recorded: u32,
    /// Whether a cell may stop before `cycles` once its section has converged.
    pub early: bool,
    /// How many strobes (the last ones) are kept in [`CellOutcome::strobes`].
    pub strobes: u32,
}

impl CellPlan {
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
pub struct LaneStrobe {
    /// The hammer's coordinate at the strobe ([`shared::model::rig`]), m or rad.
    pub q: f64,
    /// The hammer's rate at the strobe, m/s or rad/s.
    pub v: f64,
    /// Largest contact force of the period, N.
    pub force_n: f64,
    /// Contacts that began in the period.
    pub onsets: u16,
}

/// What a cell showed.
#[derive(Clone, Debug, PartialEq)]
pub struct CellOutcome {
    /// The regime over the recorded cycles.
    pub regime: Regime,
    /// Largest contact force in the recorded cycles, N.
    pub force_n: f64,
    /// Cycle after which the section had converged; `None` if it had not.
    pub settled_after: Option<u32>,
    /// Whether what the regime calls the motion may pass: the recorded cycles show that it still changes.
    pub unsettled: bool,
    /// Drive cycles that were run.
    pub cycles: u32,
    /// Longest section period searched for.
    pub searched: u8,
    /// Cycle in which the hammer last touched the surface, counted from 1; `None` if it never did.
    pub last_contact: Option<u32>,
    /// Whether an event of the fast engine was uncertain, so that the cell was run again by the reference.
    pub uncertain: bool,
    /// The section at the end: coordinate and rate.
    pub section: [f64; 2],
    /// The last strobes, oldest first, as many as the plan wants and were run.
    pub strobes: Vec<LaneStrobe>,
}
