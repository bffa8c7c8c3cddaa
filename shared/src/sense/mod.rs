//! What the sensors tell: contacts, the hammer between them, the section, the regime, the cart.

use serde::{Deserialize, Serialize};

use crate::regime::Regime;

/// One tick's samples in SI units, fixed frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Contact force, N.
    pub force_n: f32,
    /// Hammer displacement x, m.
    pub hammer_m: f32,
    /// Cart displacement y, m.
    pub cart_m: f32,
}

/// One contact as measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pulse {
    /// Control tick of the onset.
    pub onset_tick: u32,
    /// Drive phase at the onset, turns, 0 to 1.
    pub onset_turns: f32,
    /// Largest force sample, N (the surface's ringing included).
    pub peak_n: f32,
    /// ∫F dt, N·s.
    pub impulse_ns: f32,
    /// Time above the threshold, onset to first fall, interpolated, s.
    pub duration_s: f32,
    /// Speed of the hammer relative to the cart just before, m/s, from the observer.
    pub approach_m_per_s: f32,
    /// And just after, away from the surface, m/s; 0 until enough samples have been seen.
    pub rebound_m_per_s: f32,
}

/// The measured section: once per drive period, at drive phase 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Strobe {
    /// Hammer displacement relative to the cart, m (observer).
    pub relative_m: f32,
    /// Its rate, m/s.
    pub rate_m_per_s: f32,
    /// Contacts that began in the period.
    pub contacts: u16,
    /// Largest force sample of the period, N.
    pub peak_n: f32,
    /// Impulse of the period's contacts, N·s.
    pub impulse_ns: f32,
    /// Largest displacement of the hammer relative to the cart in the period, m, either way.
    pub travel_m: f32,
    /// Cart amplitude at the drive frequency, m.
    pub amplitude_m: f32,
    /// Lag of the cart behind the command, rad.
    pub lag_rad: f32,
}

/// What a tick brought.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// A contact that ended.
    pub pulse: Option<Pulse>,
    /// The strobe, if the tick passed drive phase 0.
    pub strobe: Option<Strobe>,
}

/// The measured regime and how sure it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// z = p/n.
    pub regime: Regime,
    /// Drive periods it rests on.
    pub periods: u8,
}
