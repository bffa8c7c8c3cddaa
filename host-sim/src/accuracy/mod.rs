//! How far the switch model's steppers are from the event-located reference: what `docs/accuracy.md` is
//! made from.
//!
//! [`Method`] names a stepper with its settings, [`settle`] runs it to a periodic orbit, and
//! [`settle_reference`] runs the reference at the very frequency the switch model's phase accumulator
//! rounded to, so that both are asked the same question.

pub mod band;
pub mod named;
pub mod survey;

use shared::Real;
use shared::contacts::Period;
use shared::drive::{Drive, TURN};
use shared::params::RigParams;
use shared::regime::Regime;
use shared::rig::Rig;
use shared::step::{Banded, Corrected, Smoothed, State, Stepper};
use shared::switch::Band;
use shared::twin::Twin;

use crate::engine::{Engine, Machine, Plan, Precision, Recorder, Start, machine, observe};
use crate::error::UserError;
use crate::reference::Contact;

/// How the switch is handled within a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// The step is split where the switch falls.
    Corrected,
    /// The band of the chapter, with its two widths.
    Banded {
        /// η_α, m.
        eta_alpha_m: f64,
        /// η_β, N.
        eta_beta_n: f64,
    },
    /// Arctangents in place of the switch, with their two widths.
    Smoothed {
        /// ε_α, m.
        epsilon_alpha_m: f64,
        /// ε_β, N.
        epsilon_beta_n: f64,
    },
}

/// A stepper, its arithmetic and its tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// How the switch is handled.
    pub method: Method,
    /// The arithmetic.
    pub precision: Precision,
    /// The tick, s.
    pub tick_s: f64,
}

impl Setting {
    /// The corrected stepper in f32, as it runs on the microcontroller.
    pub fn corrected_f32(tick_s: f64) -> Self {
        Self {
            method: Method::Corrected,
            precision: Precision::F32,
            tick_s,
        }
    }
}

/// What a run came to over its recorded periods.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
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

impl Outcome {
    /// Error of this outcome's force relative to another's.
    pub fn force_error(&self, truth: &Self) -> f64 {
        self.force_n / truth.force_n - 1.0
    }

    /// Error of this outcome's approach speed relative to another's.
    pub fn approach_error(&self, truth: &Self) -> f64 {
        self.approach_m_per_s / truth.approach_m_per_s - 1.0
    }
}

/// Runs the switch model as `setting` says.
///
/// # Errors
/// A parameter, frequency or start that cannot be.
pub fn settle(
    setting: Setting,
    params: &RigParams,
    frequency_hz: f64,
    start: Start,
    plan: Plan,
) -> Result<Outcome, UserError> {
    match setting.precision {
        Precision::F32 => settle_in::<f32>(setting, params, frequency_hz, start, plan),
        Precision::F64 => settle_in::<f64>(setting, params, frequency_hz, start, plan),
    }
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
) -> Result<Outcome, UserError> {
    let mut machine = machine(Engine::Event, params, frequency_hz, start)?;
    outcome(machine.as_mut(), plan)
}

/// How long the reference runs from rest before it counts as settled.
pub const SETTLING: Plan = Plan {
    cycles: 600,
    transient: 480,
};

/// The settled reference, and the switch model started from where the reference ended.
///
/// # Errors
/// As [`settle`].
pub fn from_settled(
    setting: Setting,
    params: &RigParams,
    frequency_hz: f64,
    plan: Plan,
) -> Result<(Outcome, Outcome), UserError> {
    let real = real_frequency(setting, frequency_hz)?;
    let truth = settle_reference(params, real, Start::Rest, SETTLING)?;
    let start = Start::Section(truth.section);
    Ok((truth, settle(setting, params, frequency_hz, start, plan)?))
}

/// The frequency a `setting` really runs at when asked for `frequency_hz`.
///
/// # Errors
/// A frequency or tick the drive refuses.
pub fn real_frequency(setting: Setting, frequency_hz: f64) -> Result<f64, UserError> {
    Ok(match setting.precision {
        Precision::F32 => Drive::<f32>::new(frequency_hz, setting.tick_s)?.frequency_hz(),
        Precision::F64 => Drive::<f64>::new(frequency_hz, setting.tick_s)?.frequency_hz(),
    })
}

fn settle_in<R: Real>(
    setting: Setting,
    params: &RigParams,
    frequency_hz: f64,
    start: Start,
    plan: Plan,
) -> Result<Outcome, UserError> {
    match setting.method {
        Method::Corrected => with::<R, _>(Corrected, setting, params, frequency_hz, start, plan),
        Method::Banded {
            eta_alpha_m,
            eta_beta_n,
        } => {
            let band = Band::<R>::new(eta_alpha_m, eta_beta_n);
            with(Banded { band }, setting, params, frequency_hz, start, plan)
        }
        Method::Smoothed {
            epsilon_alpha_m,
            epsilon_beta_n,
        } => {
            let stepper = Smoothed::<R> {
                epsilon_alpha: R::from_f64(epsilon_alpha_m),
                epsilon_beta: R::from_f64(epsilon_beta_n),
            };
            with(stepper, setting, params, frequency_hz, start, plan)
        }
    }
}

fn with<R: Real, S: Stepper<R>>(
    stepper: S,
    setting: Setting,
    params: &RigParams,
    frequency_hz: f64,
    start: Start,
    plan: Plan,
) -> Result<Outcome, UserError> {
    let mut stepped = Stepped::<R, S>::new(stepper, params, frequency_hz, setting.tick_s, start)?;
    outcome(&mut stepped, plan)
}

fn outcome(machine: &mut dyn Machine, plan: Plan) -> Result<Outcome, UserError> {
    let seen = observe(machine, plan, &mut Recorder::default())?;
    Ok(Outcome {
        frequency_hz: seen.frequency_hz,
        regime: seen.regime,
        force_n: seen.force_n,
        approach_m_per_s: seen.strongest.map_or(0.0, |c| c.approach_speed_m_per_s),
        section: machine.section(),
    })
}

/// The switch model with any stepper, run a drive period at a time.
#[derive(Clone, Debug)]
pub struct Stepped<R, S> {
    twin: Twin<R, S>,
    plain: Rig<f64>,
    section: [f64; 2],
}

impl<R: Real, S: Stepper<R>> Stepped<R, S> {
    /// A hammer of `params` driven at `frequency_hz` from `start`.
    ///
    /// # Errors
    /// As [`settle`].
    pub fn new(
        stepper: S,
        params: &RigParams,
        frequency_hz: f64,
        tick_s: f64,
        start: Start,
    ) -> Result<Self, UserError> {
        let plain = Rig::<f64>::new(params)?;
        let section = start.section(&plain, std::f64::consts::TAU * frequency_hz)?;
        let rig = Rig::<R>::new(params)?;
        let state = State::new(&rig, R::from_f64(section[0]), R::from_f64(section[1]));
        Ok(Self {
            twin: Twin::new(rig, Drive::new(frequency_hz, tick_s)?, stepper, state),
            plain,
            section,
        })
    }
}

impl<R: Real, S: Stepper<R>> Machine for Stepped<R, S> {
    fn period(&mut self, mut recorder: Option<&mut Recorder>) -> Period<f64> {
        let frequency_hz = self.twin.drive().frequency_hz();
        loop {
            let tick = self.twin.tick();
            if let (Some(contact), Some(recorder)) = (&tick.contact, recorder.as_deref_mut()) {
                let onset = contact.onset;
                let turns = f64::from(onset.cycle) + f64::from(onset.phase) / TURN;
                recorder.contacts.push(Contact {
                    onset_s: turns / frequency_hz,
                    duration_s: contact.duration_s.to_f64(),
                    approach_speed_m_per_s: contact.approach_speed.to_f64(),
                    rebound_speed_m_per_s: contact.rebound_speed.to_f64(),
                    peak_force_n: contact.peak_force.to_f64(),
                    peak_at_s: f64::NAN,
                    impulse_n_s: contact.impulse.to_f64(),
                    energy_lost_j: contact.energy_lost.to_f64(),
                });
            }
            if let Some(strobe) = tick.strobe {
                self.section = [strobe.q.to_f64(), strobe.v.to_f64()];
                return Period {
                    onsets: strobe.period.onsets,
                    touched: strobe.period.touched,
                    chatter: strobe.period.chatter,
                    peak_force: strobe.period.peak_force.to_f64(),
                };
            }
        }
    }
    fn section(&self) -> [f64; 2] {
        self.section
    }
    fn rig(&self) -> &Rig<f64> {
        &self.plain
    }
    fn frequency_hz(&self) -> f64 {
        self.twin.drive().frequency_hz()
    }
}
