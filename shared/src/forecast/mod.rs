//! The forecast (the online twin): the hammer's regime and 1/1 orbit at each frequency, computed in slices while
//! control is idle.
//!
//! [`march`] runs the hammer in long steps, [`settle`] from rest until its section repeats; [`variation`]
//! carries the derivative along, with which [`shoot`] finds the 1/1 orbit, stable or not; [`refine`] finds where a
//! stretch of stable 1/1 ends and where it is strongest; [`Forecaster`] does one after the other in slices.

mod forecaster;
pub mod march;
pub mod monodromy;
pub mod refine;
pub mod settle;
pub mod shoot;
mod stable_range;
pub mod variation;

pub use forecaster::Forecaster;

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::model::params::RigParams;
use crate::model::regime::Regime;

/// Frequencies of a forecast at most.
pub const MAX_ROWS: usize = 40;

/// A request for a forecast.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ForecastRequest {
    /// Counts requests; the answer carries it.
    pub id: u32,
    /// The rig to forecast, as it is believed to be.
    pub rig: RigParams,
    /// Lowest and highest frequency, Hz.
    pub range_hz: (f32, f32),
    /// Frequencies, 2 to [`MAX_ROWS`].
    pub rows: u8,
}

impl ForecastRequest {
    /// [`MAX_ROWS`] rows from 0.75 to 2.9 times the natural frequency: below it is chatter, above it the
    /// doubled orbits of every gap the forecast is measured at.
    pub fn bench(rig: &RigParams) -> Self {
        let natural_hz = rig.natural_frequency_hz();
        Self {
            id: 1,
            rig: *rig,
            range_hz: ((0.75 * natural_hz) as f32, (2.9 * natural_hz) as f32),
            rows: MAX_ROWS as u8,
        }
    }
}

/// The 1/1 orbit at a frequency.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ForecastOrbit {
    /// Peak contact force, N.
    pub force_n: f32,
    /// Impulse of the contact, N·s.
    pub impulse_n_s: f32,
    /// Penetration rate at the onset, m/s.
    pub approach_m_per_s: f32,
    /// Drive phase at onset, turns.
    pub onset_turns: f32,
    /// Largest modulus of the Floquet multipliers, the eigenvalues of the return map's derivative over one period.
    pub multiplier: f32,
    /// The characteristic polynomial at −1: zero where the period doubles, positive before.
    pub doubling_test: f32,
}

impl ForecastOrbit {
    /// Whether the orbit attracts: every multiplier is below 1 in modulus.
    pub fn is_stable(&self) -> bool {
        self.multiplier < 1.0
    }
}

/// One frequency of the forecast.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ForecastRow {
    /// Drive frequency, Hz.
    pub frequency_hz: f32,
    /// Regime that a start from rest settles to.
    pub regime: Regime,
    /// Peak force from rest over the recorded periods, N.
    pub force_n: f32,
    /// The 1/1 orbit, if there is an admissible one (one contact per period, no other touch).
    pub orbit: Option<ForecastOrbit>,
}

/// The frequency to run at.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// The strongest stable 1/1, Hz.
    pub frequency_hz: f32,
    /// The orbit at that frequency.
    pub orbit: ForecastOrbit,
    /// Lower and upper end of the stable 1/1 around it, Hz (within the range asked for).
    pub band_hz: (f32, f32),
    /// Where the period doubles, Hz, if the upper end is a doubling (a multiplier at −1).
    pub doubling_hz: Option<f32>,
    /// A frequency from which the search can start: a start from rest comes to strike there, and the 1/1
    /// can be followed from there to the target. The target itself if rest leads to 1/1 there.
    pub entry_hz: f32,
}

/// A forecast: what the hammer does at each frequency, and where to run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Forecast {
    /// Number of the request that it answers ([`ForecastRequest::id`]).
    pub id: u32,
    /// One row per frequency, by rising frequency; empty for an invalid request.
    pub rows: Vec<ForecastRow, MAX_ROWS>,
    /// The frequency to run at; `None` without a stable 1/1.
    pub target: Option<Target>,
}

impl Forecast {
    /// A digest of every number in it, bit for bit (FNV-1a over 32-bit words): equal forecasts on different
    /// machines have the same.
    pub fn digest(&self) -> u32 {
        let mut digest = Digest(0x811c_9dc5);
        for row in &self.rows {
            digest.number(row.frequency_hz);
            digest.regime(row.regime);
            digest.number(row.force_n);
            digest.orbit(row.orbit.as_ref());
        }
        if let Some(target) = &self.target {
            digest.number(target.frequency_hz);
            digest.orbit(Some(&target.orbit));
            digest.number(target.band_hz.0);
            digest.number(target.band_hz.1);
            digest.number(target.doubling_hz.unwrap_or(0.0));
            digest.number(target.entry_hz);
        }
        digest.0
    }
}

struct Digest(u32);

impl Digest {
    fn word(&mut self, word: u32) {
        self.0 = (self.0 ^ word).wrapping_mul(0x0100_0193);
    }

    fn number(&mut self, x: f32) {
        self.word(x.to_bits());
    }

    fn regime(&mut self, regime: Regime) {
        let kind = match regime {
            Regime::None => 0,
            Regime::Periodic { .. } => 1,
            Regime::Aperiodic { .. } => 2,
            Regime::Chatter { .. } => 3,
        };
        self.word(kind);
        self.word(regime.impacts().into());
        self.word(regime.periods().map_or(0, u32::from));
    }

    fn orbit(&mut self, orbit: Option<&ForecastOrbit>) {
        let Some(orbit) = orbit else {
            return self.word(0);
        };
        self.number(orbit.force_n);
        self.number(orbit.impulse_n_s);
        self.number(orbit.approach_m_per_s);
        self.number(orbit.onset_turns);
        self.number(orbit.multiplier);
        self.number(orbit.doubling_test);
    }
}
