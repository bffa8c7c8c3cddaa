//! What strikes the ground: the hammer in its cart, or the free mass of the published drifting oscillator.

use shared::model::cart::Cart;
use shared::model::contact::Law;
use shared::model::params::{ParamError, RigParams};
use shared::model::rig::{Kinematics, Rig};
use shared::model::slider::Slider;

use super::flow::Energies;
use crate::flow::Scalar;

/// A free mass under a static and a harmonic force: x'' = (b + a cos Ωt − F)/m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeMass {
    /// m, kg (1 without dimensions).
    pub mass: f64,
    /// b, N: the static force that presses it on.
    pub static_force: f64,
    /// a, N: the amplitude of the harmonic force.
    pub amplitude: f64,
}

/// The body that strikes the ground or the bit.
#[derive(Clone, Copy, Debug)]
pub enum Body<R> {
    /// The hammer in its cart.
    Hammer(Carried<R>),
    /// The free mass of the published drifting oscillator.
    Free(FreeMass),
}

/// The hammer in a cart whose course is y* = A0 sin Ωt.
#[derive(Clone, Copy, Debug)]
pub struct Carried<R> {
    rig: Rig<R>,
    /// A cart that recoils from its course; none where it keeps to it.
    cart: Option<Cart<R>>,
    /// Amplitude of the course's speed, A0 Ω, m/s.
    speed: f64,
    /// Amplitude of the course's acceleration, A0 Ω², m/s².
    acceleration: f64,
}

impl<R: Scalar> Carried<R> {
    /// The hammer of `params` at Ω = `omega`, rad/s.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn new(params: &RigParams, omega: f64) -> Result<Self, ParamError> {
        let speed = params.amplitude_m * omega;
        Ok(Self {
            rig: Rig::new(params)?,
            cart: Cart::of(params),
            speed,
            acceleration: speed * omega,
        })
    }
}

/// Accelerations at a point.
#[derive(Clone, Copy, Debug)]
pub struct BodyAccelerations<R> {
    /// Second derivative q̈ of the body's coordinate, in its unit per s².
    pub acceleration: R,
    /// ë of the cart, m/s²: 0 where it keeps to its course.
    pub deviation: R,
    /// What drives the body: inertial acceleration, m/s², or force, N.
    drive: R,
    /// Inertial acceleration of what the cart carries, m/s².
    pub carried: R,
}

/// How deep the body is, and how fast it goes deeper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyPlace<R> {
    /// Beyond the nominal place of the front, m.
    pub depth: R,
    /// Rate of the depth, m/s.
    pub rate: R,
    hammer: Option<Kinematics<R>>,
}

impl<R: Scalar> Body<R> {
    /// Where it is at coordinate `q` and rate `v`.
    #[inline]
    pub fn place(&self, q: R, v: R) -> BodyPlace<R> {
        match self {
            Self::Hammer(carried) => {
                let at = carried.rig.kinematics(q, v);
                BodyPlace {
                    depth: at.delta,
                    rate: at.rate,
                    hammer: Some(at),
                }
            }
            Self::Free(_) => BodyPlace {
                depth: q,
                rate: v,
                hammer: None,
            },
        }
    }

    /// Mass m of the body, kg (1 without dimensions).
    pub fn mass(&self) -> f64 {
        match self {
            Self::Hammer(carried) => carried.rig.mass().to_f64(),
            Self::Free(free) => free.mass,
        }
    }

    /// A length that matters, in units of the coordinate and in m.
    pub fn scales(&self) -> (f64, f64) {
        match self {
            Self::Hammer(carried) => {
                let rig = &carried.rig;
                (rig.coordinate_scale().to_f64(), rig.amplitude().to_f64())
            }
            Self::Free(_) => (1.0, 1.0),
        }
    }

    /// Whether it rides in a cart that recoils.
    pub fn recoils(&self) -> bool {
        matches!(self, Self::Hammer(carried) if carried.cart.is_some())
    }

    /// Force of the loop on a cart that recoils, N; 0 with a prescribed one.
    pub fn loop_force(&self, angle: R, off: [R; 2]) -> f64 {
        match self {
            Self::Hammer(carried) => carried.loop_force(angle, off).to_f64(),
            Self::Free(_) => 0.0,
        }
    }

    /// Accelerations at drive angle `angle` under the contact force `force`, with the cart `off` (m, m/s) its course and a
    /// bit pressed on with `pressed` (N; 0 without a bit).
    #[inline]
    pub fn motion(
        &self,
        at: &BodyPlace<R>,
        v: R,
        angle: R,
        [force, pressed]: [R; 2],
        off: [R; 2],
    ) -> BodyAccelerations<R> {
        match (self, &at.hammer) {
            (Self::Hammer(carried), Some(at)) => {
                let course = angle.sin() * R::from_f64(carried.acceleration);
                let rig = &carried.rig;
                match &carried.cart {
                    None => BodyAccelerations {
                        acceleration: rig.acceleration(at, v, course, force),
                        deviation: R::ZERO,
                        drive: course,
                        carried: course,
                    },
                    Some(cart) => {
                        let both = cart.both_beside(rig, at, v, [force, pressed], course, off);
                        BodyAccelerations {
                            acceleration: both.acceleration,
                            deviation: both.deviation,
                            drive: both.drive,
                            carried: both.drive,
                        }
                    }
                }
            }
            (Self::Hammer(_), None) => BodyAccelerations {
                acceleration: R::from_f64(f64::NAN),
                deviation: R::ZERO,
                drive: R::ZERO,
                carried: R::ZERO,
            },
            (Self::Free(free), _) => {
                let drive = cos(angle) * R::from_f64(free.amplitude);
                let drive = drive + R::from_f64(free.static_force);
                BodyAccelerations {
                    acceleration: (drive - force) * R::from_f64(1.0 / free.mass),
                    deviation: R::ZERO,
                    drive,
                    carried: R::ZERO,
                }
            }
        }
    }

    /// The second derivative of the depth, from q̈.
    #[inline]
    pub fn depth_acceleration(&self, at: &BodyPlace<R>, v: R, acceleration: R) -> R {
        match (self, &at.hammer) {
            (Self::Hammer(carried), Some(at)) => {
                carried.rig.penetration_acceleration(at, v, acceleration)
            }
            _ => acceleration,
        }
    }

    /// Where the energy goes, at the same point as `motion`.
    pub fn powers(
        &self,
        at: &BodyPlace<R>,
        v: R,
        angle: R,
        force: R,
        off: [R; 2],
        motion: &BodyAccelerations<R>,
    ) -> Energies {
        match (self, &at.hammer) {
            (Self::Hammer(carried), Some(at)) => Energies {
                drive: carried.rig.inertial_power(at, motion.drive).to_f64(),
                damping: carried.rig.damping_power(v).to_f64(),
                contact: carried.rig.contact_power(at, v, force).to_f64(),
                shaker: carried.shaker_power(angle, off),
                ..Energies::default()
            },
            _ => Energies {
                drive: (motion.drive * v).to_f64(),
                contact: (force * v).to_f64(),
                ..Energies::default()
            },
        }
    }

    /// Kinetic and potential energy relative to the cart, J.
    pub fn energy(&self, q: R, v: R) -> f64 {
        match self {
            Self::Hammer(carried) => {
                let rig = &carried.rig;
                rig.energy(&rig.kinematics(q, v), v).to_f64()
            }
            Self::Free(free) => 0.5 * free.mass * v.to_f64() * v.to_f64(),
        }
    }

    /// The coordinate of a body that is `by` less deep than at `q`, and its rate, if it moves on as fast in depth.
    pub fn drawn_back(&self, q: R, v: R, by: R) -> (R, R) {
        let Self::Hammer(Carried { rig, .. }) = self else {
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

impl<R: Scalar> Carried<R> {
    /// The loop's force on a cart that recoils, N.
    fn loop_force(&self, angle: R, off: [R; 2]) -> R {
        let Some(cart) = &self.cart else {
            return R::ZERO;
        };
        let course = angle.sin() * R::from_f64(self.acceleration);
        cart.force(course, off)
    }

    /// Power of the loop's force on a cart that recoils, W; 0 with a prescribed one.
    fn shaker_power(&self, angle: R, off: [R; 2]) -> f64 {
        if self.cart.is_none() {
            return 0.0;
        }
        let speed = cos(angle) * R::from_f64(self.speed) + off[1];
        (self.loop_force(angle, off) * speed).to_f64()
    }
}

fn cos<R: Scalar>(angle: R) -> R {
    (angle + R::from_f64(std::f64::consts::FRAC_PI_2)).sin()
}

/// q of a hammer at rest. With a negative gap it rests pressed on, where its support and the ground's spring balance; the
/// ground must bear that.
///
/// # Errors
/// The first parameter out of range.
pub fn resting(params: &RigParams, slider: &Slider<f64>) -> Result<f64, ParamError> {
    let mut on_spring = *params;
    on_spring.contact = Law::SpringDashpot {
        stiffness: slider.stiffness,
        damping: slider.damping,
    };
    Ok(Rig::<f64>::new(&on_spring)?.rest())
}
