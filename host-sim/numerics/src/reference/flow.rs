//! The smooth flow on one side of the switch: adaptive steps of Dormand–Prince 8(5,3).

use shared::Real;
use shared::model::cart::Cart;
use shared::model::rig::{Kinematics, Mode, Rig};
use shared::model::step::Smoothed;

use super::tableau::{A, B, C, E3, E5, STAGES, error, length};
use crate::dual::Dual;

/// A scalar the reference integrates in.
pub trait Scalar: Real {
    /// sin x for any angle, rad.
    fn sin(self) -> Self;

    /// eˣ.
    fn exp(self) -> Self;

    /// A time found as the root of `g`, given dg/dt there: for a dual number, the root's derivatives.
    #[must_use]
    fn as_root_of(self, g: Self, slope: f64) -> Self;
}

impl Scalar for f64 {
    #[inline]
    fn sin(self) -> Self {
        self.sin()
    }
    #[inline]
    fn exp(self) -> Self {
        self.exp()
    }
    #[inline]
    fn as_root_of(self, _: Self, _: f64) -> Self {
        self
    }
}

impl<const N: usize> Scalar for Dual<N> {
    #[inline]
    fn sin(self) -> Self {
        let (sin, cos) = self.re.sin_cos();
        self.chain(sin, cos)
    }
    #[inline]
    fn exp(self) -> Self {
        let exp = self.re.exp();
        self.chain(exp, exp)
    }
    fn as_root_of(self, g: Self, slope: f64) -> Self {
        // g(t, x) = 0 along the family: dt/dx = −(∂g/∂x)/(dg/dt).
        Self {
            re: self.re,
            eps: g.eps.map(|e| -e / slope),
        }
    }
}

/// Integrated beside the motion: where energy and momentum went since the last reset.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// ∫F dt, N·s.
    pub impulse: f64,
    /// Energy taken by the contact, J.
    pub contact_work: f64,
    /// Work of the inertial force, J.
    pub inertial_work: f64,
    /// Energy taken by the support's damping, J.
    pub damping_work: f64,
}

impl Totals {
    /// Sum of two.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            impulse: self.impulse + other.impulse,
            contact_work: self.contact_work + other.contact_work,
            inertial_work: self.inertial_work + other.inertial_work,
            damping_work: self.damping_work + other.damping_work,
        }
    }
}

/// A point of the flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point<R> {
    /// Time since drive phase 0, s.
    pub t: R,
    /// Coordinate.
    pub q: R,
    /// Its rate.
    pub v: R,
    /// Deviation of the cart from its course (m) and its rate (m/s): 0 where the cart is prescribed.
    pub cart: [R; 2],
}

impl<R: Scalar> Point<R> {
    /// At coordinate `q` and rate `v`, `t` s after phase 0, with the cart on its course.
    pub fn on_course(t: R, q: R, v: R) -> Self {
        Self {
            t,
            q,
            v,
            cart: [R::ZERO; 2],
        }
    }
}

/// What the flow is under: rig, drive, side of the switch.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a, R> {
    /// The rig.
    pub rig: &'a Rig<R>,
    /// Ω, rad/s.
    pub omega: f64,
    /// A0 Ω², m/s².
    pub drive_acceleration: f64,
    /// Side of the switch.
    pub mode: Mode,
    /// δ̇⁻, m/s.
    pub approach: R,
    /// Arctangents in place of the switch; then the side counts for nothing.
    pub smoothed: Option<Smoothed<R>>,
    /// A cart that recoils, and by what the errors of its deviation and rate are weighed.
    pub recoil: Option<(&'a Cart<R>, (f64, f64))>,
}

/// Rates at a point, and what acts there.
struct Rates<R> {
    /// q̈.
    acceleration: R,
    /// ë of the cart, m/s².
    deviation: R,
    /// Contact force, N.
    force: R,
    /// Inertial acceleration of the hammer, m/s².
    drive: R,
}

/// A step taken.
#[derive(Clone, Copy, Debug)]
pub struct Step<R> {
    /// Where it ended.
    pub end: Point<R>,
    /// Error estimate relative to the tolerance (≤ 1: accept).
    pub error: f64,
    /// What was integrated beside it.
    pub totals: Totals,
}

impl<R: Scalar> Field<'_, R> {
    /// A0 Ω² sin Ωt at time `t` after phase 0, m/s².
    #[inline]
    pub fn drive(&self, t: R) -> R {
        (t * R::from_f64(self.omega)).sin() * R::from_f64(self.drive_acceleration)
    }

    /// The contact force that acts, N.
    #[inline]
    fn force(&self, at: &Kinematics<R>) -> R {
        match (self.smoothed, self.mode) {
            (Some(smoothed), _) => smoothed.blended(at.delta, self.rig.force(at, self.approach)),
            (None, Mode::Flight) => R::ZERO,
            (None, Mode::Contact) => self.rig.force(at, self.approach),
        }
    }

    /// Acceleration and contact force at a point.
    #[inline]
    pub fn acceleration(&self, p: &Point<R>) -> (R, R) {
        let rates = self.rates(p, &self.rig.kinematics(p.q, p.v));
        (rates.acceleration, rates.force)
    }

    #[inline]
    fn rates(&self, p: &Point<R>, at: &Kinematics<R>) -> Rates<R> {
        let force = self.force(at);
        let course = self.drive(p.t);
        match self.recoil {
            None => Rates {
                acceleration: self.rig.acceleration(at, p.v, course, force),
                deviation: R::ZERO,
                force,
                drive: course,
            },
            Some((cart, _)) => {
                let both = cart.both(self.rig, at, p.v, force, course, p.cart);
                Rates {
                    acceleration: both.acceleration,
                    deviation: both.deviation,
                    force,
                    drive: both.drive,
                }
            }
        }
    }

    /// One step of length `h` from `from`; errors are weighed by `tolerance` times the scales of
    /// coordinate and rate.
    pub fn step(&self, from: &Point<R>, h: R, (q_unit, v_unit): (f64, f64)) -> Step<R> {
        let mut rates = [(R::ZERO, R::ZERO); STAGES];
        let mut cart_rates = [[R::ZERO; 2]; STAGES];
        let mut powers = [Totals::default(); STAGES];
        for stage in 0..STAGES {
            let (mut dq, mut dv) = (R::ZERO, R::ZERO);
            for &(i, weight) in A[stage] {
                let weight = R::from_f64(weight);
                dq += rates[i].0 * weight;
                dv += rates[i].1 * weight;
            }
            let p = Point {
                t: from.t + h * R::from_f64(C[stage]),
                q: from.q + h * dq,
                v: from.v + h * dv,
                cart: self.cart_after(from, h, &cart_rates, A[stage]),
            };
            let at = self.rig.kinematics(p.q, p.v);
            let now = self.rates(&p, &at);
            rates[stage] = (p.v, now.acceleration);
            cart_rates[stage] = [p.cart[1], now.deviation];
            powers[stage] = Totals {
                impulse: now.force.to_f64(),
                contact_work: self.rig.contact_power(&at, p.v, now.force).to_f64(),
                inertial_work: self.rig.inertial_power(&at, now.drive).to_f64(),
                damping_work: self.rig.damping_power(p.v).to_f64(),
            };
        }
        let (mut dq, mut dv) = (R::ZERO, R::ZERO);
        let mut totals = Totals::default();
        for &(i, weight) in B {
            let share = R::from_f64(weight);
            dq += rates[i].0 * share;
            dv += rates[i].1 * share;
            let (p, w) = (powers[i], weight * h.to_f64());
            totals = totals.plus(Totals {
                impulse: w * p.impulse,
                contact_work: w * p.contact_work,
                inertial_work: w * p.inertial_work,
                damping_work: w * p.damping_work,
            });
        }
        let estimate = |weights: &[(usize, f64)]| {
            let (mut q, mut v) = (0.0, 0.0);
            for &(i, w) in weights {
                q += w * rates[i].0.to_f64();
                v += w * rates[i].1.to_f64();
            }
            let hammer = length(q / q_unit, v / v_unit);
            let Some((_, units)) = self.recoil else {
                return hammer * h.to_f64().abs();
            };
            let (mut e, mut w) = (0.0, 0.0);
            for &(i, weight) in weights {
                e += weight * cart_rates[i][0].to_f64();
                w += weight * cart_rates[i][1].to_f64();
            }
            length(hammer, length(e / units.0, w / units.1)) * h.to_f64().abs()
        };
        Step {
            end: Point {
                t: from.t + h,
                q: from.q + h * dq,
                v: from.v + h * dv,
                cart: self.cart_after(from, h, &cart_rates, B),
            },
            error: error(estimate(E5), estimate(E3)),
            totals,
        }
    }

    /// The cart's deviation and rate after `h` at the weighted rates.
    #[inline]
    fn cart_after(
        &self,
        from: &Point<R>,
        h: R,
        rates: &[[R; 2]; STAGES],
        weights: &[(usize, f64)],
    ) -> [R; 2] {
        if self.recoil.is_none() {
            return from.cart;
        }
        let mut moved = [R::ZERO; 2];
        for &(i, weight) in weights {
            let weight = R::from_f64(weight);
            moved[0] += rates[i][0] * weight;
            moved[1] += rates[i][1] * weight;
        }
        [from.cart[0] + h * moved[0], from.cart[1] + h * moved[1]]
    }

    /// The indicator at a point.
    pub fn indicator(&self, p: &Point<R>) -> R {
        let at = self.rig.kinematics(p.q, p.v);
        self.rig.indicator(&at, self.approach_at(at.rate))
    }

    /// δ̇⁻ for the indicator: in flight, what it would be if contact began here.
    #[inline]
    pub fn approach_at(&self, rate: R) -> R {
        match self.mode {
            Mode::Flight => rate.max(R::ZERO),
            Mode::Contact => self.approach,
        }
    }
}
