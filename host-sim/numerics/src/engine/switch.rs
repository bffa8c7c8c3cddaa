//! The switch model of `shared` behind the engines' interface: any of its steppers, in f32 or f64.

use shared::Real;
use shared::model::contacts::Period;
use shared::model::drive::{Drive, Stamp, TURN};
use shared::model::params::RigParams;
use shared::model::rig::Rig;
use shared::model::step::{Banded, Corrected, HammerState, Smoothed, Stepper};
use shared::model::switch::Band;
use shared::model::twin::Twin;

use super::{CycleRecorder, Machine, RecordedSample};
use crate::error::Error;
use crate::reference::LocatedContact;

/// Which arithmetic the switch model runs in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// Single precision, as on the microcontroller.
    F32,
    /// Double precision, for analysis.
    F64,
}

/// How the switch is handled within a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// The step is split where the switch falls.
    Corrected,
    /// The band of the chapter, with its two widths.
    Banded {
        /// η_α, m: |δ| below this is "on Σα".
        eta_alpha_m: f64,
        /// η_β, N: |F| below this is "on Σβ".
        eta_beta_n: f64,
    },
    /// Arctangents in place of the switch, with their two widths.
    Smoothed {
        /// ε_α, m: penetration over which contact fades in.
        epsilon_alpha_m: f64,
        /// ε_β, N: force over which contact fades out.
        epsilon_beta_n: f64,
    },
}

/// A stepper, its arithmetic and its tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// How the switch is handled.
    pub method: Method,
    /// Arithmetic that the switch model runs in.
    pub precision: Precision,
    /// Length of the fixed step, s.
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

/// The switch model as `setting` says, on `section`.
pub fn machine(
    setting: Setting,
    params: &RigParams,
    frequency_hz: f64,
    section: [f64; 2],
) -> Result<Box<dyn Machine>, Error> {
    match setting.precision {
        Precision::F32 => machine_in::<f32>(setting, params, frequency_hz, section),
        Precision::F64 => machine_in::<f64>(setting, params, frequency_hz, section),
    }
}

fn machine_in<R: Real + 'static>(
    setting: Setting,
    params: &RigParams,
    frequency_hz: f64,
    section: [f64; 2],
) -> Result<Box<dyn Machine>, Error> {
    let at = (params, frequency_hz, setting.tick_s, section);
    Ok(match setting.method {
        Method::Corrected => Box::new(Switch::<R, _>::new(Corrected, at)?),
        Method::Banded {
            eta_alpha_m,
            eta_beta_n,
        } => {
            let band = Band::new(eta_alpha_m, eta_beta_n);
            Box::new(Switch::<R, _>::new(Banded { band }, at)?)
        }
        Method::Smoothed {
            epsilon_alpha_m,
            epsilon_beta_n,
        } => {
            let stepper = Smoothed {
                epsilon_alpha: R::from_f64(epsilon_alpha_m),
                epsilon_beta: R::from_f64(epsilon_beta_n),
            };
            Box::new(Switch::<R, _>::new(stepper, at)?)
        }
    })
}

/// The switch model with a stepper, run a drive period at a time.
#[derive(Clone, Debug)]
pub struct Switch<R, S> {
    twin: Twin<R, S>,
    plain: Rig<f64>,
    section: [f64; 2],
    ticks: u64,
}

impl<R: Real, S: Stepper<R>> Switch<R, S> {
    /// A hammer of these parameters driven at this frequency (Hz), with this tick (s), from a section (coordinate and rate at
    /// phase 0).
    ///
    /// # Errors
    /// If a parameter, the frequency or the tick is out of range.
    pub fn new(
        stepper: S,
        (params, frequency_hz, tick_s, section): (&RigParams, f64, f64, [f64; 2]),
    ) -> Result<Self, Error> {
        let rig = Rig::<R>::new(params)?;
        let state = HammerState::new(&rig, R::from_f64(section[0]), R::from_f64(section[1]));
        Ok(Self {
            twin: Twin::new(rig, Drive::new(frequency_hz, tick_s)?, stepper, state),
            plain: Rig::<f64>::new(params)?,
            section,
            ticks: 0,
        })
    }

    /// Keeps a finished contact and, now and then and always in contact, a sample.
    fn record(
        &self,
        contact: Option<&shared::model::contacts::Contact<R>>,
        force: R,
        recorder: &mut CycleRecorder,
    ) {
        let drive = self.twin.drive();
        let frequency_hz = drive.frequency_hz();
        let turns = |at: Stamp| f64::from(at.cycle) + f64::from(at.phase) / TURN;
        if let Some(contact) = contact {
            recorder.contacts.push(LocatedContact {
                onset_s: turns(contact.onset) / frequency_hz,
                duration_s: contact.duration_s.to_f64(),
                approach_speed_m_per_s: contact.approach_speed.to_f64(),
                rebound_speed_m_per_s: contact.rebound_speed.to_f64(),
                peak_force_n: contact.peak_force.to_f64(),
                peak_at_s: f64::NAN,
                impulse_n_s: contact.impulse.to_f64(),
                energy_lost_j: contact.energy_lost.to_f64(),
            });
        }
        if recorder.samples_per_period == 0 {
            return;
        }
        let now = turns(drive.now());
        let per_tick = frequency_hz * drive.tick_s().to_f64();
        let per_period = recorder.samples_per_period as f64;
        let due = if recorder.evenly {
            // The first tick at or after each even instant; an instant on a tick counts once whatever its last digit.
            let passed = |turns: f64| (turns * per_period + 1e-6).floor();
            passed(now) > passed(now - per_tick)
        } else {
            let every = (1.0 / (per_tick * per_period)).max(1.0) as u64;
            self.ticks.is_multiple_of(every) || force > R::ZERO
        };
        if due {
            let state = self.twin.state();
            let at = (state.q.hi.to_f64(), state.v.hi.to_f64());
            let sample =
                RecordedSample::new(&self.plain, frequency_hz, now, at, [0.0; 2], force.to_f64());
            recorder.samples.push(sample);
        }
    }
}

impl<R: Real, S: Stepper<R>> Machine for Switch<R, S> {
    fn period(&mut self, mut recorder: Option<&mut CycleRecorder>) -> Period<f64> {
        loop {
            let tick = self.twin.tick();
            self.ticks += 1;
            if let Some(recorder) = recorder.as_deref_mut() {
                self.record(tick.contact.as_ref(), tick.force, recorder);
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
    fn tick_needed_s(&self) -> Option<f64> {
        self.twin.tick_needed_s().map(Real::to_f64)
    }
}
