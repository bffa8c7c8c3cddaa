//! The smoothing method integrated to the reference's tolerance: arctangents in place of the switch, no event.
//!
//! It is the reference's march with a flow that has one phase, so the steps of the two can be counted against each other.

use shared::model::params::RigParams;
use shared::model::rig::Rig;
use shared::model::step::Smoothed;

use super::Reference;
use crate::error::Error;
use crate::flow::Scalar;

impl<R: Scalar> Reference<R> {
    /// A hammer of `params` driven at `frequency_hz`, at drive phase 0 at coordinate `q` and rate `v`, whose contact
    /// fades in over `epsilon_m` of penetration and out over the force the law gives at that penetration ([`Smoothed`]). No
    /// contact begins or ends.
    ///
    /// # Errors
    /// If a parameter is out of range, if the width is not positive, or if the law depends on the approach speed at
    /// the onset.
    ///
    /// # Panics
    /// If `frequency_hz` is not a positive number.
    pub fn smoothed(
        params: &RigParams,
        frequency_hz: f64,
        epsilon_m: f64,
        (q, v): (R, R),
    ) -> Result<Self, Error> {
        Rig::<R>::new(params)?;
        if params.cart.recoils() {
            return Err(Error::Recoil("the smoothing method"));
        }
        if !(epsilon_m > 0.0 && epsilon_m.is_finite()) {
            return Err(Error::SmoothingWidth(epsilon_m));
        }
        if params.contact.kind().needs_approach_speed() {
            return Err(Error::SmoothingLaw);
        }
        let smoothed = Smoothed {
            epsilon_alpha: R::from_f64(epsilon_m),
            epsilon_beta: R::from_f64(params.contact.force(epsilon_m, 0.0, 1.0)),
        };
        Ok(Self {
            smoothed: Some(smoothed),
            approach: R::ZERO,
            equations: None,
            ..Self::in_flight(params, frequency_hz, q, v)?
        })
    }

    /// ε_β, N: the force the law gives at the width's penetration; 0 where contact is not smoothed.
    pub fn epsilon_n(&self) -> f64 {
        self.smoothed.map_or(0.0, |s| s.epsilon_beta.to_f64())
    }
}
