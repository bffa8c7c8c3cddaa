//! The smoothing method integrated to the reference's tolerance: arctangents in place of the switch, no event.
//!
//! The same integrator, the same tolerance and the same bound on the step as the reference, so that the steps of the
//! two can be counted against each other.

use std::f64::consts::TAU;

use shared::model::params::RigParams;
use shared::model::rig::{Mode, Rig};
use shared::model::step::Smoothed;

use super::flow::{Field, Point, Scalar};
use super::tableau;
use super::{FIRST_STEP_S, MAX_STEPS_PER_PERIOD, STEPS_PER_PERIOD, TOLERANCE};
use crate::error::Error;

/// A hammer whose contact fades in and out ([`Smoothed`]), from drive phase 0 to drive phase 0.
#[derive(Clone, Copy, Debug)]
pub struct SmoothedReference<R> {
    rig: Rig<R>,
    smoothed: Smoothed<R>,
    omega: f64,
    period_s: f64,
    units: (f64, f64),
    max_step: f64,
    point: Point<R>,
    next_step: f64,
    steps: u64,
}

impl<R: Scalar> SmoothedReference<R> {
    /// A hammer of `params` driven at `frequency_hz`, at drive phase 0 at coordinate `q` and rate `v`, whose contact
    /// fades in over `epsilon_m` of penetration and out over the force the law gives at that penetration.
    ///
    /// # Errors
    /// If a parameter is out of range, if the width is not positive, or if the law depends on the approach speed at
    /// the onset.
    pub fn new(
        params: &RigParams,
        frequency_hz: f64,
        epsilon_m: f64,
        (q, v): (R, R),
    ) -> Result<Self, Error> {
        let rig = Rig::<R>::new(params)?;
        let scale = rig.coordinate_scale().to_f64();
        if params.cart.recoils() {
            return Err(Error::Recoil("the smoothing method"));
        }
        if !(epsilon_m > 0.0 && epsilon_m.is_finite()) {
            return Err(Error::SmoothingWidth(epsilon_m));
        }
        if matches!(
            params.contact,
            shared::model::contact::Law::LankaraniNikravesh { .. }
        ) {
            return Err(Error::SmoothingLaw);
        }
        let omega = TAU * frequency_hz;
        let fastest = frequency_hz.max(params.natural_frequency_hz());
        let unit = TOLERANCE * scale;
        Ok(Self {
            smoothed: Smoothed {
                epsilon_alpha: R::from_f64(epsilon_m),
                epsilon_beta: R::from_f64(params.contact.force(epsilon_m, 0.0, 1.0)),
            },
            rig,
            omega,
            period_s: 1.0 / frequency_hz,
            units: (unit, unit * omega),
            max_step: 1.0 / (STEPS_PER_PERIOD * fastest),
            point: Point::on_course(R::ZERO, q, v),
            next_step: FIRST_STEP_S,
            steps: 0,
        })
    }

    /// Runs to the next drive phase 0. A motion that cannot be followed ends in a state that is not a number.
    pub fn run_period(&mut self) {
        let amplitude = self.rig.amplitude().to_f64();
        for _ in 0..MAX_STEPS_PER_PERIOD {
            let to_go = self.period_s - self.point.t.to_f64();
            let h = self.next_step.min(self.max_step).min(to_go);
            let field = Field {
                rig: &self.rig,
                omega: self.omega,
                drive_acceleration: amplitude * self.omega * self.omega,
                mode: Mode::Flight,
                approach: R::ZERO,
                smoothed: Some(self.smoothed),
                recoil: None,
            };
            let step = field.step(&self.point, R::from_f64(h), self.units);
            self.steps += 1;
            if step.error > 1.0 {
                self.next_step = tableau::shorter(h, step.error);
                continue;
            }
            self.point = step.end;
            if h == to_go {
                self.point.t = R::ZERO;
                return;
            }
            self.next_step = tableau::next(h, step.error);
        }
        self.point.q = R::from_f64(f64::NAN);
        self.point.v = R::from_f64(f64::NAN);
    }

    /// Coordinate and rate now.
    pub fn state(&self) -> (R, R) {
        (self.point.q, self.point.v)
    }

    /// Sends coordinate and rate through `f`; see [`super::Reference::redirect`].
    pub fn redirect(&mut self, f: impl Fn(R) -> R) {
        self.point.q = f(self.point.q);
        self.point.v = f(self.point.v);
    }

    /// ε_β, N: the force the law gives at the width's penetration.
    pub fn epsilon_n(&self) -> f64 {
        self.smoothed.epsilon_beta.to_f64()
    }

    /// Steps tried since the start, those refused included.
    pub fn steps(&self) -> u64 {
        self.steps
    }
}
