//! A bit between hammer and ground: a third body.
//!
//! The hammer strikes the bit, and the bit stands on the ground that gives way ([`super::slider`]). A static feed force W
//! presses it on. The bit is guided in the cart, and so is the ground, as without a bit.
//!
//! Let u be the bit's depth beyond the nominal place of the front (m), w = u̇ (m/s), and δ the hammer's depth beyond the
//! same place, all relative to the cart and positive into the ground; ÿ the cart's acceleration (m/s²). With
//!
//! - x = δ − u, the penetration of the hammer into the bit, and F = k_b x + c_b ẋ while hammer and bit touch, else 0 (N),
//! - R, what the ground presses back with: the force of the slider whose top the bit is (N),
//!
//! the bit moves as
//!
//! m_b ẇ = F + W − R − m_b ÿ.
//!
//! The hammer's own equation ([`super::rig`]) has F as its contact force. F + W − R is what the bit has from bodies that the
//! cart carries, so a cart that recoils feels its opposite ([`super::cart`]).
//!
//! # Switches
//! Hammer and bit touch as the hammer touches a surface that stays ([`Law::indicator`]): from x = 0 rising until F has
//! fallen to 0. Bit and ground touch as [`super::slider::Touch`] says, and part when R has fallen to 0: the bit can leave the
//! ground, and W brings it back.

use serde::{Deserialize, Serialize};

use crate::model::contact::Law;
use crate::model::number::{Allowed, ParamError, within};
use crate::model::params::GRAVITY_M_PER_S2;
use crate::model::scalar::Real;
use crate::model::slider::Slider;

/// A bit (SI: kg, N, m, s).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bit<R> {
    /// Mass m_b of the bit, kg.
    pub mass: R,
    /// k_b of the hammer on the bit, N/m.
    pub stiffness: R,
    /// c_b of the hammer on the bit, N·s/m.
    pub damping: R,
    /// W, N: the static force that presses it on the ground.
    pub feed_force: R,
}

const MASS: Allowed = Allowed(1e-4, 1e4, "a positive number from 0.0001 to 10000");
const STIFFNESS: Allowed = Allowed(1e-3, 1e12, "a positive number from 0.001 to 1e12");
const DAMPING: Allowed = Allowed(0.0, 1e9, "a number from 0 to 1e9");

impl Bit<f64> {
    /// m_b g, N: the feed force of a bit that is pressed on by no more than its own weight.
    pub fn weight_n(mass_kg: f64) -> f64 {
        mass_kg * GRAVITY_M_PER_S2
    }

    /// Checks every parameter, and that `ground` bears the feed force.
    ///
    /// # Errors
    /// The first that is out of range.
    pub fn check(&self, ground: &Slider<f64>) -> Result<(), ParamError> {
        within("bit_mass_kg", self.mass, &MASS)?;
        within("bit_stiffness_n_per_m", self.stiffness, &STIFFNESS)?;
        within("bit_damping_n_s_per_m", self.damping, &DAMPING)?;
        let borne = Allowed(
            0.0,
            0.9 * ground.threshold,
            "a number from 0 to 0.9 of threshold_n, so that the ground bears it",
        );
        within("bit_feed_force_n", self.feed_force, &borne)
    }
}

impl<R: Real> Bit<R> {
    /// How the hammer's contact with it is decided.
    #[inline]
    fn law(&self) -> Law<R> {
        Law::SpringDashpot {
            stiffness: self.stiffness,
            damping: self.damping,
        }
    }

    /// k_b x + c_b ẋ, N: the force between hammer and bit while they touch. Below 0 they part.
    #[inline]
    pub fn force(&self, x: R, rate: R) -> R {
        self.stiffness * x + self.damping * rate
    }

    /// Positive where hammer and bit touch and push; min(k_b x, F).
    #[inline]
    pub fn indicator(&self, x: R, rate: R) -> R {
        self.law().indicator(x, rate, R::ZERO)
    }

    /// Rate of [`Self::indicator`] where ẍ is `acceleration`.
    #[inline]
    pub fn indicator_rate(&self, rate: R, acceleration: R) -> R {
        if rate >= R::ZERO {
            self.stiffness * rate
        } else {
            self.force(rate, acceleration)
        }
    }

    /// F + W − R, N: what hammer, feed and ground press the bit on with.
    #[inline]
    pub fn pressed(&self, force: R, ground: R) -> R {
        force + self.feed_force - ground
    }

    /// ẇ, m/s², from [`Self::pressed`]; `drive` is the inertial acceleration −ÿ.
    #[inline]
    pub fn acceleration(&self, pressed: R, drive: R) -> R {
        pressed / self.mass + drive
    }

    /// Power that the contact of hammer and bit turns to heat while they touch, W.
    #[inline]
    pub fn dashpot_power(&self, rate: R) -> R {
        self.damping * (rate * rate)
    }

    /// Energy in the contact of hammer and bit, J. What is left of it when they part is lost: the surfaces relax at once.
    #[inline]
    pub fn stored_energy(&self, x: R) -> R {
        R::HALF * self.stiffness * (x * x)
    }

    /// ½ m_b w², J.
    #[inline]
    pub fn kinetic_energy(&self, w: R) -> R {
        R::HALF * self.mass * (w * w)
    }

    /// W/k, m: how far `ground` is compressed under a bit at rest.
    #[inline]
    pub fn rest_compression(&self, ground: &Slider<R>) -> R {
        self.feed_force / ground.stiffness
    }

    /// This bit with its numbers converted to the scalar `T`.
    pub fn cast<T: Real>(&self) -> Bit<T> {
        let t = |x: R| T::from_f64(x.to_f64());
        Bit {
            mass: t(self.mass),
            stiffness: t(self.stiffness),
            damping: t(self.damping),
            feed_force: t(self.feed_force),
        }
    }
}

#[cfg(test)]
mod tests;
