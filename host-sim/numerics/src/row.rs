//! One run as a row of a table, and numbers without the noise of a unit conversion.

use serde::{Serialize, Serializer};
use shared::model::cart::{CartDrive, LoopParams};
use shared::model::params::{RigParams, preset};
use shared::model::regime::Regime;

use crate::engine::Observation;
use crate::error::{Error, PickError};
use crate::pick::uncertainty::Stated;

/// A rig and its name.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedRig {
    /// The preset's name, or the stem of the file the rig was read from; in brackets what is set over it.
    pub name: String,
    /// Its parameters, with the cart as it is computed with.
    pub params: RigParams,
    /// The shaker that moves its cart, if one is known.
    pub shaker: Option<LoopParams>,
    /// What was set over the preset or the file it was read from, `key=value`.
    pub overridden: Vec<String>,
    /// What its file states of its uncertainty.
    pub stated: Stated,
}

impl NamedRig {
    /// A rig called `name`, whose shaker is the one its cart is computed with, if any.
    pub fn new(name: impl Into<String>, params: RigParams) -> Self {
        let shaker = match params.cart {
            CartDrive::Prescribed => None,
            CartDrive::Loop(held) => Some(held),
        };
        Self {
            name: name.into(),
            params,
            shaker,
            overridden: Vec::new(),
            stated: Stated::default(),
        }
    }

    /// The same rig with its cart moved as prescribed.
    #[must_use]
    pub fn prescribed(mut self) -> Self {
        self.params.cart = CartDrive::Prescribed;
        self
    }

    /// The same rig with a cart that recoils under its shaker. `None` if no shaker is known.
    pub fn recoiling(&self) -> Option<Self> {
        let mut rig = self.clone();
        rig.params.cart = CartDrive::Loop(self.shaker?);
        Some(rig)
    }

    /// The preset `name`.
    ///
    /// # Errors
    /// [`Error::Preset`] if there is none of this name.
    pub fn preset(name: &str) -> Result<Self, Error> {
        let params = preset(name).ok_or_else(|| Error::Preset(name.to_owned()))?;
        Ok(Self::new(name, params))
    }

    /// The error that says why this rig has no operating point.
    pub fn no_pick(&self, what: PickError) -> Error {
        Error::Pick {
            rig: self.name.clone(),
            what,
        }
    }
}

/// One run. Units are in the names.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Name of the rig.
    pub rig: String,
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// Drive frequency Ω/2π, Hz.
    pub frequency_hz: f64,
    /// Ω/ω.
    pub frequency_ratio: f64,
    /// p: contacts in n periods; when nothing repeats, in the last 16 recorded periods.
    pub impacts: u16,
    /// n; none when the section does not repeat, or nothing touches.
    pub periods: Option<u8>,
    /// Written as "p/n", "none", "aperiodic" or "chatter".
    #[serde(serialize_with = "regime_as_text")]
    pub regime: Regime,
    /// Largest contact force in the recorded cycles over m g.
    pub force_ratio: f64,
    /// The same, N.
    pub force_n: f64,
    /// Approach speed of the strongest contact, m/s.
    pub approach_speed_m_per_s: Option<f64>,
    /// Duration of the strongest contact, ms.
    pub contact_time_ms: Option<f64>,
}

impl Row {
    /// The row of a run of the rig `rig` with `params`.
    pub fn new(rig: &str, params: &RigParams, seen: &Observation) -> Self {
        Self {
            rig: rig.to_owned(),
            gap_mm: tidy(params.gap_m * 1e3),
            frequency_hz: tidy(seen.frequency_hz),
            frequency_ratio: tidy(seen.frequency_hz / params.natural_frequency_hz()),
            impacts: seen.regime.impacts(),
            periods: seen.regime.periods(),
            regime: seen.regime,
            force_ratio: seen.force_n / params.weight_n(),
            force_n: seen.force_n,
            approach_speed_m_per_s: seen.strongest.map(|c| c.approach_speed_m_per_s),
            contact_time_ms: seen.strongest.map(|c| c.duration_s * 1e3),
        }
    }
}

/// Serialises a regime as its name in tables: "p/n", "none", "aperiodic" or "chatter".
///
/// # Errors
/// Those of the serializer.
pub fn regime_as_text<S: Serializer>(regime: &Regime, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(regime)
}

/// The regime without the numbers that its name does not say.
pub fn kind(regime: Regime) -> Regime {
    match regime {
        Regime::Aperiodic { .. } => Regime::Aperiodic { impacts: 0 },
        Regime::Chatter { .. } => Regime::Chatter {
            impacts: 0,
            periods: None,
        },
        other => other,
    }
}

/// Removes the last-digit noise of a unit conversion, so that 2.4 mm prints as 2.4.
pub fn tidy(x: f64) -> f64 {
    let rounded = (x * 1e9).round() / 1e9;
    if (rounded - x).abs() <= 1e-12 * x.abs() {
        rounded
    } else {
        x
    }
}
