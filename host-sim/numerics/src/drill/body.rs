//! What strikes the ground: the hammer in its cart, or the free mass of the published drifting oscillator.

use shared::model::rig::{Kinematics, Rig};

use crate::reference::Scalar;

/// A free mass under a static and a harmonic force: x'' = (b + a cos Ωt − F)/m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeMass {
    /// m, kg (1 without dimensions).
    pub mass: f64,
    /// b, N: the static force that presses it on.
    pub static_force: f64,
    /// a, N.
    pub amplitude: f64,
}

/// What strikes.
#[derive(Clone, Copy, Debug)]
pub enum Body<R> {
    /// The hammer in a cart that moves as y = A0 sin Ωt; A0 Ω², m/s².
    Hammer(Rig<R>, f64),
    /// The published oscillator.
    Free(FreeMass),
}

/// Where it is.
#[derive(Clone, Copy, Debug)]
pub struct Place<R> {
    /// Beyond the nominal place of the front, m.
    pub depth: R,
    /// Its rate, m/s.
    pub rate: R,
    hammer: Option<Kinematics<R>>,
}

/// Powers, W.
#[derive(Clone, Copy, Debug, Default)]
pub struct Powers {
    /// Of the drive, on the body.
    pub drive: f64,
    /// That the support's damping takes.
    pub damping: f64,
    /// That the contact force takes from the body, as its equation of motion has it.
    pub contact: f64,
}

impl<R: Scalar> Body<R> {
    /// Where it is at coordinate `q` and rate `v`.
    #[inline]
    pub fn place(&self, q: R, v: R) -> Place<R> {
        match self {
            Self::Hammer(rig, _) => {
                let at = rig.kinematics(q, v);
                Place {
                    depth: at.delta,
                    rate: at.rate,
                    hammer: Some(at),
                }
            }
            Self::Free(_) => Place {
                depth: q,
                rate: v,
                hammer: None,
            },
        }
    }

    /// m, kg.
    pub fn mass(&self) -> f64 {
        match self {
            Self::Hammer(rig, _) => rig.mass().to_f64(),
            Self::Free(free) => free.mass,
        }
    }

    /// A length that matters, in units of the coordinate.
    pub fn scale(&self) -> f64 {
        match self {
            Self::Hammer(rig, _) => rig.coordinate_scale().to_f64(),
            Self::Free(_) => 1.0,
        }
    }

    /// The drive at angle Ωt = `angle`: inertial acceleration, m/s², or force, N.
    #[inline]
    fn drive(&self, angle: R) -> R {
        match self {
            Self::Hammer(_, acceleration) => angle.sin() * R::from_f64(*acceleration),
            Self::Free(free) => {
                let quarter = R::from_f64(std::f64::consts::FRAC_PI_2);
                let force = (angle + quarter).sin() * R::from_f64(free.amplitude);
                force + R::from_f64(free.static_force)
            }
        }
    }

    /// q̈ at drive angle `angle` under the contact force `force`.
    #[inline]
    pub fn acceleration(&self, at: &Place<R>, v: R, angle: R, force: R) -> R {
        let drive = self.drive(angle);
        match (self, &at.hammer) {
            (Self::Hammer(rig, _), Some(at)) => rig.acceleration(at, v, drive, force),
            (Self::Hammer(..), None) => R::from_f64(f64::NAN),
            (Self::Free(free), _) => (drive - force) * R::from_f64(1.0 / free.mass),
        }
    }

    /// The second derivative of the depth, from q̈.
    #[inline]
    pub fn depth_acceleration(&self, at: &Place<R>, v: R, acceleration: R) -> R {
        match (self, &at.hammer) {
            (Self::Hammer(rig, _), Some(at)) => rig.penetration_acceleration(at, v, acceleration),
            _ => acceleration,
        }
    }

    /// Where the energy goes.
    pub fn powers(&self, at: &Place<R>, v: R, angle: R, force: R) -> Powers {
        let drive = self.drive(angle);
        match (self, &at.hammer) {
            (Self::Hammer(rig, _), Some(at)) => Powers {
                drive: rig.inertial_power(at, drive).to_f64(),
                damping: rig.damping_power(v).to_f64(),
                contact: rig.contact_power(at, v, force).to_f64(),
            },
            _ => Powers {
                drive: (drive * v).to_f64(),
                damping: 0.0,
                contact: (force * v).to_f64(),
            },
        }
    }

    /// Kinetic and potential energy relative to the cart, J.
    pub fn energy(&self, q: R, v: R) -> f64 {
        match self {
            Self::Hammer(rig, _) => rig.energy(&rig.kinematics(q, v), v).to_f64(),
            Self::Free(free) => 0.5 * free.mass * v.to_f64() * v.to_f64(),
        }
    }

    /// The coordinate of a body that is `by` less deep than at `q`, and its rate, if it moves on as fast in depth.
    pub fn drawn_back(&self, q: R, v: R, by: R) -> (R, R) {
        let Self::Hammer(rig, _) = self else {
            return (q - by, v);
        };
        let at = rig.kinematics(q, v);
        let wanted = at.delta - by;
        // Newton's iteration: `by` is micrometres, the curvature a radius of the wires' length.
        let mut moved = q - by / at.slope;
        for _ in 0..3 {
            let now = rig.kinematics(moved, v);
            moved += (wanted - now.delta) / now.slope;
        }
        (moved, at.rate / rig.kinematics(moved, v).slope)
    }
}
