//! One run as one answer, with its section and its contacts as rows.

use serde::Serialize;
use shared::model::rig::Rig;

use super::{CycleRecorder, Engine, Method, Observation, Plan, Precision};
use crate::row::{NamedRig, RunRow, tidy};

/// What a run showed. Units are in the names.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunAnswer {
    /// Rig, frequency, regime and force, as in a row of a sweep.
    #[serde(flatten)]
    pub row: RunRow,
    /// Finished contacts in the recorded cycles.
    pub contacts_recorded: usize,
    /// Drive periods from the start after which the motion repeats; none if it does not by the end.
    pub settling_cycles: Option<u32>,
    /// Time from the start after which the motion repeats, s; none if it does not by the end.
    pub settling_s: Option<f64>,
    /// Rebound speed of the strongest contact, m/s.
    pub rebound_speed_m_per_s: Option<f64>,
    /// Energy that the strongest contact took from the hammer, J.
    pub energy_per_blow_j: Option<f64>,
    /// Impulse of the strongest contact, N·s.
    pub impulse_n_s: Option<f64>,
    /// Drive cycles in all.
    pub cycles: u32,
    /// How many of the first were not recorded.
    pub transient: u32,
    /// Engine that ran: "event" or "switch".
    pub engine: &'static str,
    /// How the switch engine handles the switch.
    pub stepper: Option<&'static str>,
    /// Arithmetic of the run: "f32" or "f64".
    pub precision: &'static str,
    /// Tick of the switch engine, µs.
    pub tick_us: Option<f64>,
}

/// One contact as a table shows it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ContactRow {
    /// When it began, s.
    pub onset_s: f64,
    /// How long it lasted, ms.
    pub duration_ms: f64,
    /// Speed of the hammer into the surface at the onset, m/s.
    pub approach_speed_m_per_s: f64,
    /// Speed of the hammer out of the surface at the release, m/s.
    pub rebound_speed_m_per_s: f64,
    /// Largest contact force, N.
    pub peak_force_n: f64,
    /// Impulse of the contact, ∫F dt, N·s.
    pub impulse_n_s: f64,
    /// Energy it took from the hammer, J.
    pub energy_lost_j: f64,
}

/// One point of the section at drive phase 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SectionRow {
    /// Displacement relative to the cart (l sin θ or Δ), mm.
    pub relative_displacement_mm: f64,
    /// Velocity relative to the cart, m/s.
    pub relative_velocity_m_per_s: f64,
}

impl RunAnswer {
    /// Of the run of `rig` that showed `seen` and left `recorder`.
    pub fn new(
        rig: &NamedRig,
        engine: Engine,
        plan: Plan,
        seen: &Observation,
        recorder: &CycleRecorder,
    ) -> Self {
        let setting = match engine {
            Engine::Event => None,
            Engine::Switch(setting) => Some(setting),
        };
        Self {
            row: RunRow::new(&rig.name, &rig.params, seen),
            contacts_recorded: recorder.contacts.len(),
            settling_cycles: seen.settled_after,
            settling_s: seen.settled_after.map(|n| f64::from(n) / seen.frequency_hz),
            rebound_speed_m_per_s: seen.strongest.map(|c| c.rebound_speed_m_per_s),
            energy_per_blow_j: seen.strongest.map(|c| c.energy_lost_j),
            impulse_n_s: seen.strongest.map(|c| c.impulse_n_s),
            cycles: plan.cycles,
            transient: plan.transient,
            engine: setting.map_or("event", |_| "switch"),
            stepper: setting.map(|setting| match setting.method {
                Method::Corrected => "corrected",
                Method::Banded { .. } => "banded",
                Method::Smoothed { .. } => "smoothed",
            }),
            precision: match setting.map(|setting| setting.precision) {
                Some(Precision::F32) => "f32",
                Some(Precision::F64) | None => "f64",
            },
            tick_us: setting.map(|setting| tidy(setting.tick_s * 1e6)),
        }
    }
}

/// The section as rows.
pub fn section_rows(seen: &Observation, rig: &Rig<f64>) -> Vec<SectionRow> {
    let row = |[q, v]: &[f64; 2]| SectionRow {
        relative_displacement_mm: rig.relative_displacement(*q) * 1e3,
        relative_velocity_m_per_s: rig.kinematics(*q, *v).rate,
    };
    seen.section.iter().map(row).collect()
}

/// The finished contacts as rows.
pub fn contact_rows(recorder: &CycleRecorder) -> Vec<ContactRow> {
    let rows = recorder.contacts.iter().map(|c| ContactRow {
        // A contact that the run begins with has its onset at 0, but for the last digits.
        onset_s: if c.onset_s.abs() < 1e-15 {
            0.0
        } else {
            c.onset_s
        },
        duration_ms: c.duration_s * 1e3,
        approach_speed_m_per_s: c.approach_speed_m_per_s,
        rebound_speed_m_per_s: c.rebound_speed_m_per_s,
        peak_force_n: c.peak_force_n,
        impulse_n_s: c.impulse_n_s,
        energy_lost_j: c.energy_lost_j,
    });
    rows.collect()
}
