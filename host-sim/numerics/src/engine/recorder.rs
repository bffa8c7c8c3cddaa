//! What is kept of a run for pictures and tables.

use shared::model::rig::Rig;

use crate::reference::LocatedContact;

/// The motion at one recorded instant.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct RecordedSample {
    /// Time since the start, s.
    pub time_s: f64,
    /// Displacement relative to the cart (l sin θ or Δ), mm.
    pub relative_displacement_mm: f64,
    /// Velocity relative to the cart, m/s.
    pub relative_velocity_m_per_s: f64,
    /// In the fixed frame (3-18): x, mm.
    pub displacement_mm: f64,
    /// In the fixed frame: ẋ, m/s.
    pub velocity_m_per_s: f64,
    /// Contact force, N.
    pub force_n: f64,
}

/// Keeps what the recorded cycles did.
#[derive(Clone, Debug, Default)]
pub struct CycleRecorder {
    /// Samples per drive period kept; 0 keeps none.
    pub samples_per_period: usize,
    /// Keeps these samples alone, evenly spaced (the switch model's to a tick). Without it there are more in contact,
    /// so that a picture shows each force.
    pub evenly: bool,
    /// The samples, in time.
    pub samples: Vec<RecordedSample>,
    /// The finished contacts, in time.
    pub contacts: Vec<LocatedContact>,
}

impl RecordedSample {
    /// The sample at coordinate `q` and rate `v`, `turns` drive periods after the start, with the cart `deviation` (m, m/s)
    /// off its course.
    pub(super) fn new(
        rig: &Rig<f64>,
        frequency_hz: f64,
        turns: f64,
        (q, v): (f64, f64),
        deviation: [f64; 2],
        force_n: f64,
    ) -> Self {
        let (sin, cos) = (std::f64::consts::TAU * turns.fract()).sin_cos();
        let relative = rig.relative_displacement(q);
        let rate = rig.kinematics(q, v).rate;
        let omega = std::f64::consts::TAU * frequency_hz;
        Self {
            time_s: turns / frequency_hz,
            relative_displacement_mm: relative * 1e3,
            relative_velocity_m_per_s: rate,
            displacement_mm: (relative + rig.amplitude() * sin + deviation[0]) * 1e3,
            velocity_m_per_s: rate + rig.amplitude() * omega * cos + deviation[1],
            force_n,
        }
    }
}
