//! The cart: on a prescribed course, or held to that course by a shaker's position loop and pushed off it by the hammer.
//!
//! The course is y* = A0 sin Ωt. A cart that recoils is at y = y* + e, and what is integrated is its deviation e: in f32
//! it keeps its digits beside a course a thousand times larger. The loop pushes with
//!
//! Fs = −kp e − kd ė + φ M ÿ*,  kp = M (2π f)², kd = 2 ζ M 2π f,
//!
//! where f and ζ are the frequency and damping ratio of the loop with the cart alone and φ is the share of M ÿ* that is fed
//! forward. The hammer pulls with −m (ÿ + δ̈). Its acceleration is affine in ÿ, δ̈ = d0 − d1 ÿ ([`super::rig`]), so
//! (M + m (1 − d1)) ÿ = Fs − m d0. A bit ([`super::bit`]) adds −(F + W − R) on the right.

use core::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use crate::model::params::RigParams;
use crate::model::rig::{Kinematics, Rig};
use crate::model::scalar::Real;

/// What moves the cart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum CartDrive {
    /// A0 sin Ωt, whatever force that takes: the chapter's model.
    #[default]
    Prescribed,
    /// A shaker's position loop.
    Loop(LoopParams),
}

impl CartDrive {
    /// Whether the hammer can push the cart off its course.
    pub const fn recoils(&self) -> bool {
        matches!(self, Self::Loop(_))
    }
}

/// A position loop of finite stiffness.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoopParams {
    /// Natural frequency of the loop with the cart alone, Hz.
    pub frequency_hz: f64,
    /// Damping ratio ζ of the loop with the cart alone.
    pub damping_ratio: f64,
    /// Share of M ÿ* that is fed forward.
    pub feed_forward: f64,
    /// The largest force that the shaker can give, N. The equations do not limit it: a motion that needs more is not this
    /// model's.
    pub max_force_n: f64,
}

impl LoopParams {
    /// The larger of the moduli of the roots of s² + 2 ζ ω s + ω², in units of ω: above 1 if the loop is overdamped.
    pub fn swiftness(&self) -> f64 {
        let damping = self.damping_ratio;
        if damping > 1.0 {
            damping + libm::sqrt(damping * damping - 1.0)
        } else {
            1.0
        }
    }
}

/// The force of a shaker whose limit is not known, N.
pub const UNLIMITED_N: f64 = 1e9;

/// The shaker that is assumed where none is given: a laboratory shaker of 200 N. The chapter does not describe its own.
pub const ASSUMED_SHAKER: LoopParams = LoopParams {
    frequency_hz: 50.0,
    damping_ratio: 0.7,
    feed_forward: 1.0,
    max_force_n: 200.0,
};

/// A loop with the cart it holds, ready to be stepped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cart<R> {
    mass: R,
    stiffness: R,
    damping: R,
    forward: R,
}

/// What happens at a point of the motion of both bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Both<R> {
    /// q̈ of the hammer.
    pub acceleration: R,
    /// ë of the cart, m/s².
    pub deviation: R,
    /// The inertial acceleration of the hammer, −ÿ, m/s².
    pub drive: R,
}

impl<R: Real> Cart<R> {
    /// The cart of `params`, if it recoils.
    pub fn of(params: &RigParams) -> Option<Self> {
        let CartDrive::Loop(held) = params.cart else {
            return None;
        };
        let mass = params.cart_mass_kg;
        let omega = TAU * held.frequency_hz;
        Some(Self {
            mass: R::from_f64(mass),
            stiffness: R::from_f64(mass * omega * omega),
            damping: R::from_f64(2.0 * held.damping_ratio * mass * omega),
            forward: R::from_f64(held.feed_forward * mass),
        })
    }

    /// This cart with each of its numbers converted by `number`.
    pub fn map<S: Real>(&self, number: impl Fn(R) -> S) -> Cart<S> {
        Cart {
            mass: number(self.mass),
            stiffness: number(self.stiffness),
            damping: number(self.damping),
            forward: number(self.forward),
        }
    }

    /// The accelerations of both bodies: the hammer at `at` with rate `v` under the contact force `force` (N), the cart
    /// `deviation` = (e, ė) off a course whose inertial acceleration −ÿ* is `course` (m/s²).
    #[inline]
    pub fn both(
        &self,
        rig: &Rig<R>,
        at: &Kinematics<R>,
        v: R,
        force: R,
        course: R,
        deviation: [R; 2],
    ) -> Both<R> {
        self.both_beside(rig, at, v, [force, R::ZERO], course, deviation)
    }

    /// As [`Self::both`], with a third body that the cart carries, on which hammer, feed and ground press with a force
    /// `pressed` (N, [`super::bit`]): its opposite acts on the cart.
    #[inline]
    pub fn both_beside(
        &self,
        rig: &Rig<R>,
        at: &Kinematics<R>,
        v: R,
        [force, pressed]: [R; 2],
        course: R,
        deviation: [R; 2],
    ) -> Both<R> {
        let still = rig.acceleration(at, v, R::ZERO, force);
        let per_drive = rig.acceleration_per_drive(at);
        let pull = rig.mass() * rig.penetration_acceleration(at, v, still);
        let moved = self.mass + rig.mass() * (R::ONE - at.slope * per_drive);
        let push = self.stiffness * deviation[0] + self.damping * deviation[1];
        let off = ((moved - self.forward) * course - push - pull - pressed) / moved;
        let drive = course - off;
        Both {
            acceleration: still + per_drive * drive,
            deviation: off,
            drive,
        }
    }

    /// Natural frequency of the loop with the cart alone, rad/s. Host side only.
    pub fn omega(&self) -> f64 {
        libm::sqrt((self.stiffness / self.mass).to_f64())
    }

    /// The loop's force on the cart, N.
    #[inline]
    pub fn force(&self, course: R, deviation: [R; 2]) -> R {
        let push = self.stiffness * deviation[0] + self.damping * deviation[1];
        -(push + self.forward * course)
    }
}
