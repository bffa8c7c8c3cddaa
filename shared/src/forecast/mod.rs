//! The online twin: what the hammer will do at each frequency, computed in slices while control has
//! nothing to do.
//!
//! [`march`] runs the hammer in long steps, [`settle`] from rest until its section repeats; [`variation`]
//! carries the derivative along, with which [`shoot`] finds the 1/1 orbit, stable or not; [`refine`] finds where a
//! stretch of stable 1/1 ends and where it is strongest; [`Forecaster`] does one after the other in slices.

mod forecaster;
pub mod march;
pub mod refine;
pub mod settle;
pub mod shoot;
pub mod variation;

pub use forecaster::Forecaster;

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::params::RigParams;
use crate::regime::Regime;

/// Frequencies of a forecast at most.
pub const MAX_ROWS: usize = 40;

/// What to forecast.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Counts requests; the answer carries it.
    pub id: u32,
    /// The rig as it is believed to be.
    pub rig: RigParams,
    /// Lowest and highest frequency, Hz.
    pub range_hz: (f32, f32),
    /// Frequencies, 2 to [`MAX_ROWS`].
    pub rows: u8,
}

/// The 1/1 orbit at a frequency.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Orbit {
    /// Peak contact force, N.
    pub force_n: f32,
    /// Impulse of the contact, N·s.
    pub impulse_ns: f32,
    /// Approach speed, m/s.
    pub approach_m_per_s: f32,
    /// Drive phase at onset, turns.
    pub onset_turns: f32,
    /// Trace and determinant of the monodromy matrix of the return map over one period.
    pub trace: f32,
    /// Determinant.
    pub determinant: f32,
}

impl Orbit {
    /// Largest modulus of the two Floquet multipliers, the roots of μ² − trace μ + determinant.
    pub fn multiplier(&self) -> f32 {
        let quarter = 0.25 * self.trace * self.trace - self.determinant;
        if quarter < 0.0 {
            libm::sqrtf(self.determinant)
        } else {
            0.5 * libm::fabsf(self.trace) + libm::sqrtf(quarter)
        }
    }

    /// Whether it attracts.
    pub fn is_stable(&self) -> bool {
        self.multiplier() < 1.0
    }
}

/// One frequency of the forecast.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Drive frequency, Hz.
    pub frequency_hz: f32,
    /// Regime that a start from rest settles to.
    pub regime: Regime,
    /// Peak force from rest over the recorded periods, N.
    pub force_n: f32,
    /// The 1/1 orbit, if there is an admissible one (one contact per period, no other touch).
    pub orbit: Option<Orbit>,
}

/// The frequency to run at.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// The strongest stable 1/1, Hz.
    pub frequency_hz: f32,
    /// Its orbit.
    pub orbit: Orbit,
    /// Lower and upper end of the stable 1/1 around it, Hz (within the range asked for).
    pub band_hz: (f32, f32),
    /// Where the period doubles, Hz, if the upper end is a doubling (a multiplier at −1).
    pub doubling_hz: Option<f32>,
    /// A frequency from which the search can start: a start from rest comes to strike there, and the 1/1
    /// can be followed from there to the target. The target itself if rest leads to 1/1 there.
    pub entry_hz: f32,
}

/// The forecast.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Forecast {
    /// [`Request::id`].
    pub id: u32,
    /// By rising frequency.
    pub rows: Vec<Row, MAX_ROWS>,
    /// Where to run; none if no stable 1/1 was found.
    pub target: Option<Target>,
}
