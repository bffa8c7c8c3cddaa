//! What the lanes are given, how they run it, and what they count.

use std::f64::consts::TAU;

use super::Cell;
use super::constants::Constants;
use super::meet::EventMargins;
use super::ring::Reach;

/// A cell ready for a lane.
#[derive(Clone, Copy, Debug)]
pub struct Job {
    /// The cell without units.
    pub constants: Constants,
    /// Coordinate at the start.
    pub x: f64,
    /// Rate at the start.
    pub v: f64,
    /// Drive phase at the start, rad.
    pub tau: f64,
}

impl Job {
    /// The start of `cell`, without units.
    pub fn new(cell: &Cell, constants: Constants) -> Self {
        Self {
            x: cell.start[0] / constants.scale,
            v: cell.start[1] / (constants.scale * constants.omega),
            tau: cell.phase * TAU,
            constants,
        }
    }
}

/// Step size and event tolerances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning {
    /// Step of flight, in radians of the faster of drive and hammer.
    pub step: f64,
    /// Tolerances with which a meeting with the surface is found.
    pub margins: EventMargins,
    /// Distance between strobes that rounding and truncation alone make.
    pub grain: f64,
    /// Steps while a recoiling cart rings.
    pub reach: Reach,
    /// A ring lower than this, in cart amplitudes, has died out.
    pub dead: f64,
}

/// Counts of the work that the lanes did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Iterations of all lanes together.
    pub iterations: u64,
    /// Lane steps done: iterations times lanes, less the idle ones.
    pub steps: u64,
    /// Lanes times iterations: steps that there was room for.
    pub room: u64,
    /// Iterations in which the contact was computed.
    pub contact_rounds: u64,
    /// Contacts done in the lanes.
    pub contacts: u64,
    /// Sustained contacts, or parts of them up to a section, computed one at a time.
    pub sustained: u64,
    /// Drive cycles run, of all cells together.
    pub cycles: u64,
}

impl std::ops::AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        self.iterations += other.iterations;
        self.steps += other.steps;
        self.room += other.room;
        self.contact_rounds += other.contact_rounds;
        self.contacts += other.contacts;
        self.sustained += other.sustained;
        self.cycles += other.cycles;
    }
}
