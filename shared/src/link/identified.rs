//! What the controller has learned of its rig from the rig's own pulses, for the reader.

use serde::{Deserialize, Serialize};

/// What the controller has learned of its rig. `None`: not told yet, or never plausibly.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Identified {
    /// Contact stiffness ki, N/m.
    pub stiffness_n_per_m: Option<f32>,
    /// Contact damping ci, N·s/m.
    pub damping_n_s_per_m: Option<f32>,
    /// Natural frequency, Hz.
    pub natural_frequency_hz: Option<f32>,
    /// Clearance at rest, m.
    pub gap_m: Option<f32>,
    /// Pulses that were used.
    pub accepted: u32,
    /// Pulses that were not plausible and were left out.
    pub refused: u32,
}
