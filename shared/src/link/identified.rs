//! The identified parameters of the rig, as a message.

use serde::{Deserialize, Serialize};

use crate::sense::identification::Identification;

/// The identified parameters of the rig. `None`: too few samples yet, or not plausible.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Identified {
    /// Contact stiffness ki, N/m.
    pub stiffness_n_per_m: Option<f32>,
    /// Contact damping ci, N·s/m.
    pub damping_n_s_per_m: Option<f32>,
    /// Natural frequency of the hammer on its support, Hz.
    pub natural_frequency_hz: Option<f32>,
    /// Clearance at rest, m.
    pub gap_m: Option<f32>,
    /// Contacts that stiffness and damping rest on.
    pub contacts: u32,
    /// Implausible pulses and results, left out.
    pub refused: u32,
}

impl Identified {
    /// The estimates so far.
    pub fn of(identification: &Identification) -> Self {
        let estimates = identification.estimates();
        Self {
            stiffness_n_per_m: estimates.stiffness.map(|e| e.value),
            damping_n_s_per_m: estimates.damping.map(|e| e.value),
            natural_frequency_hz: estimates.natural_hz.map(|e| e.value),
            gap_m: estimates.gap_m.map(|e| e.value),
            contacts: estimates.stiffness.map_or(0, |e| e.samples),
            refused: identification.refused(),
        }
    }
}
