//! The twin: rig, drive, stepper and state, advanced a tick at a time.

use crate::model::contacts::{Contact, Ledger, Period};
use crate::model::drive::{Drive, DriveError};
use crate::model::regime::Detector;
use crate::model::rig::Rig;
use crate::model::scalar::Real;
use crate::model::step::{HammerState, Span, Stepper};

/// The section at drive phase 0 and the period that ended there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwinStrobe<R> {
    /// Coordinate q at phase 0, m or rad.
    pub q: R,
    /// q̇ at phase 0, m/s or rad/s.
    pub v: R,
    /// What happened since the last strobe.
    pub period: Period<R>,
}

/// The events of a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwinTick<R> {
    /// Contact force at the end of the tick, N.
    pub force: R,
    /// ∫F dt over the tick, N·s: over the tick's length, the force as a sensor that averages would see it.
    pub impulse: R,
    /// A contact that ended in this tick.
    pub contact: Option<Contact<R>>,
    /// The strobe, if the tick passed drive phase 0.
    pub strobe: Option<TwinStrobe<R>>,
}

/// A hammer under prescribed cart motion, stepped at a fixed tick.
#[derive(Clone, Copy, Debug)]
pub struct Twin<R, S> {
    rig: Rig<R>,
    drive: Drive<R>,
    drive_acceleration: R,
    stepper: S,
    state: HammerState<R>,
    ledger: Ledger<R>,
}

impl<R: Real, S: Stepper<R>> Twin<R, S> {
    /// A twin of `rig` in `state` under `drive`.
    pub fn new(rig: Rig<R>, drive: Drive<R>, stepper: S, state: HammerState<R>) -> Self {
        let mut ledger = Ledger::default();
        if state.mode == crate::model::rig::SwitchMode::Contact {
            ledger.resume(drive.now(), state.approach);
        }
        Self {
            drive_acceleration: drive_acceleration(&rig, &drive),
            rig,
            drive,
            stepper,
            state,
            ledger,
        }
    }

    /// A twin at rest relative to the cart.
    pub fn at_rest(rig: Rig<R>, drive: Drive<R>, stepper: S) -> Self {
        Self::new(rig, drive, stepper, HammerState::at_rest(&rig))
    }

    /// Changes the drive frequency without a jump in phase.
    ///
    /// # Errors
    /// If the frequency is out of range ([`DriveError`]); nothing has then changed.
    pub fn set_frequency(&mut self, frequency_hz: f64, tick_s: f64) -> Result<(), DriveError> {
        self.drive.set_frequency(frequency_hz, tick_s)?;
        self.drive_acceleration = drive_acceleration(&self.rig, &self.drive);
        Ok(())
    }

    /// The rig that is stepped.
    pub fn rig(&self) -> &Rig<R> {
        &self.rig
    }

    /// The drive as of the last tick.
    pub fn drive(&self) -> &Drive<R> {
        &self.drive
    }

    /// The state at the last tick.
    pub fn state(&self) -> &HammerState<R> {
        &self.state
    }

    /// A tick short enough for the contacts so far, s, if this one is not ([`Ledger::tick_needed`]).
    pub fn tick_needed_s(&self) -> Option<R> {
        self.ledger.tick_needed()
    }

    /// A regime detector on this rig's and frequency's scales.
    pub fn detector(&self) -> Detector<R> {
        let scale = self.rig.coordinate_scale();
        let omega = R::from_f64(self.drive.angular_frequency());
        Detector::new(scale, scale * omega)
    }

    /// Advances by one tick. A strobe within the tick splits it, so that the section is the integrator's
    /// and not an interpolation.
    #[inline]
    pub fn tick(&mut self) -> TwinTick<R> {
        let strobe_at = self.drive.strobe_ahead();
        let strobe = strobe_at.map(|fraction| {
            self.advance(R::ZERO, fraction);
            TwinStrobe {
                q: self.state.q.hi,
                v: self.state.v.hi,
                period: self.ledger.close_period(),
            }
        });
        self.advance(strobe_at.unwrap_or(R::ZERO), R::ONE);
        self.drive.advance();
        TwinTick {
            force: self.stepper.force(&self.rig, &self.state),
            impulse: self.ledger.take_impulse(),
            contact: self.ledger.take_finished(),
            strobe,
        }
    }

    #[inline]
    fn advance(&mut self, from: R, to: R) {
        if from >= to {
            return;
        }
        let span = Span {
            drive: &self.drive,
            drive_acceleration: self.drive_acceleration,
            cart: None,
            from,
            to,
        };
        self.stepper
            .advance(&self.rig, &span, &mut self.state, &mut self.ledger);
    }
}

/// Amplitude A0 Ω² of the cart's acceleration, m/s².
fn drive_acceleration<R: Real>(rig: &Rig<R>, drive: &Drive<R>) -> R {
    let omega = drive.angular_frequency();
    rig.amplitude() * R::from_f64(omega * omega)
}
