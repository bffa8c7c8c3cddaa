//! Runs of both engines to a periodic orbit, at the very frequency to which the switch model's phase accumulator rounds: so both
//! are asked the same question.

use shared::model::drive::Drive;
use shared::model::params::RigParams;
use shared::model::regime::Regime;

use numerics::Error;
use numerics::engine::{
    CycleRecorder, Engine, Machine, Plan, Precision, Setting, Start, machine, observe,
};

/// What the recorded periods of a run showed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeriodsOutcome {
    /// Frequency really driven, Hz.
    pub frequency_hz: f64,
    /// Impact regime.
    pub regime: Regime,
    /// Largest contact force, N.
    pub force_n: f64,
    /// Approach speed of the contact with that force, m/s (0 without contact).
    pub approach_m_per_s: f64,
    /// Coordinate and rate on the last section.
    pub section: [f64; 2],
}

impl PeriodsOutcome {
    /// Error of this outcome's force relative to another's.
    pub fn force_error(&self, truth: &Self) -> f64 {
        self.force_n / truth.force_n - 1.0
    }
}

/// Runs the switch model as `setting` says.
///
/// # Errors
/// If a parameter, the frequency or the start is out of range.
pub fn settle(
    setting: Setting,
    params: &RigParams,
    frequency_hz: f64,
    start: Start,
    plan: Plan,
) -> Result<PeriodsOutcome, Error> {
    let mut machine = machine(Engine::Switch(setting), params, frequency_hz, start)?;
    outcome(machine.as_mut(), plan)
}

/// Runs the reference.
///
/// # Errors
/// As [`settle`].
pub fn settle_reference(
    params: &RigParams,
    frequency_hz: f64,
    start: Start,
    plan: Plan,
) -> Result<PeriodsOutcome, Error> {
    let mut machine = machine(Engine::Event, params, frequency_hz, start)?;
    outcome(machine.as_mut(), plan)
}

/// How long the reference runs from rest before it counts as settled.
pub const SETTLING: Plan = Plan {
    cycles: 600,
    transient: 480,
};

/// The frequency a `setting` really runs at when asked for `frequency_hz`.
///
/// # Errors
/// If the drive cannot have this frequency and tick.
pub fn real_frequency(setting: Setting, frequency_hz: f64) -> Result<f64, Error> {
    Ok(match setting.precision {
        Precision::F32 => Drive::<f32>::new(frequency_hz, setting.tick_s)?.frequency_hz(),
        Precision::F64 => Drive::<f64>::new(frequency_hz, setting.tick_s)?.frequency_hz(),
    })
}

fn outcome(machine: &mut dyn Machine, plan: Plan) -> Result<PeriodsOutcome, Error> {
    let seen = observe(machine, plan, &mut CycleRecorder::default())?;
    Ok(PeriodsOutcome {
        frequency_hz: seen.frequency_hz,
        regime: seen.regime,
        force_n: seen.force_n,
        approach_m_per_s: seen.strongest.map_or(0.0, |c| c.approach_speed_m_per_s),
        section: machine.section(),
    })
}
