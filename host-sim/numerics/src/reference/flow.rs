//! The hammer's flow on one side of the switch, in a cart that is prescribed or recoils.

use shared::model::cart::Cart;
use shared::model::rig::{Kinematics, Rig, SwitchMode};
use shared::model::step::Smoothed;

use super::switching;
use crate::flow::dormand_prince::{combined, length};
use crate::flow::{Flow, FlowStep, Scalar, reached};

/// Integrated beside the motion: where energy and momentum went since the last reset.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlowTotals {
    /// Impulse of the contact force, ∫F dt, N·s.
    pub impulse: f64,
    /// Energy taken by the contact, J.
    pub contact_work: f64,
    /// Work of the inertial force, J.
    pub inertial_work: f64,
    /// Energy taken by the support's damping, J.
    pub damping_work: f64,
}

impl FlowTotals {
    /// Adds `weight` times `other`.
    pub fn add(&mut self, other: &Self, weight: f64) {
        self.impulse += weight * other.impulse;
        self.contact_work += weight * other.contact_work;
        self.inertial_work += weight * other.inertial_work;
        self.damping_work += weight * other.damping_work;
    }
}

/// A point of the flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowPoint<R> {
    /// Time since drive phase 0, s.
    pub t: R,
    /// The hammer's coordinate ([`shared::model::rig`]): rad on wires, m on beams.
    pub q: R,
    /// Rate of the coordinate, rad/s or m/s.
    pub v: R,
    /// Deviation of the cart from its course (m) and its rate (m/s): 0 where the cart is prescribed.
    pub cart: [R; 2],
}

impl<R: Scalar> FlowPoint<R> {
    /// At coordinate `q` and rate `v`, `t` s after phase 0, with the cart on its course.
    pub fn on_course(t: R, q: R, v: R) -> Self {
        Self {
            t,
            q,
            v,
            cart: [R::ZERO; 2],
        }
    }

    /// This point in plain numbers, its derivatives dropped.
    pub fn in_values(&self) -> FlowPoint<f64> {
        FlowPoint {
            t: self.t.to_f64(),
            q: self.q.to_f64(),
            v: self.v.to_f64(),
            cart: self.cart.map(R::to_f64),
        }
    }
}

/// The hammer under a rig and a drive on one side of the switch.
#[derive(Clone, Copy, Debug)]
pub struct HammerFlow<'a, R> {
    /// The rig, in numbers that may carry derivatives.
    pub rig: &'a Rig<R>,
    /// Rig and cart in plain numbers.
    pub plain: (&'a Rig<f64>, Option<&'a Cart<f64>>),
    /// Drive frequency Ω, rad/s.
    pub omega: f64,
    /// Peak acceleration of the cart's course, A0 Ω², m/s².
    pub drive_acceleration: f64,
    /// Side of the switch.
    pub mode: SwitchMode,
    /// δ̇⁻, m/s: approach speed at the onset of the contact, which some laws need.
    pub approach: R,
    /// Arctangents in place of the switch; then the side counts for nothing.
    pub smoothed: Option<Smoothed<R>>,
    /// A cart that recoils, and by what the errors of its deviation and rate are weighed.
    pub recoil: Option<(&'a Cart<R>, (f64, f64))>,
    /// The errors of coordinate and rate are weighed by these.
    pub units: (f64, f64),
}

/// Accelerations at a point, and what acts there.
struct Acting<R> {
    /// q̈: acceleration of the hammer's coordinate.
    acceleration: R,
    /// ë of the cart, m/s².
    deviation: R,
    /// Contact force, N.
    force: R,
    /// Inertial acceleration of the hammer, m/s².
    drive: R,
}

/// A step of the hammer.
pub type HammerStep<R> = FlowStep<R, FlowPoint<R>, FlowTotals>;

impl<'a, R: Scalar> HammerFlow<'a, R> {
    /// This flow in plain numbers: what needs no derivatives is cheaper there.
    pub fn in_values(&self) -> HammerFlow<'a, f64> {
        let (rig, cart) = self.plain;
        HammerFlow {
            rig,
            plain: self.plain,
            omega: self.omega,
            drive_acceleration: self.drive_acceleration,
            mode: self.mode,
            approach: self.approach.to_f64(),
            smoothed: self.smoothed.map(|s| Smoothed {
                epsilon_alpha: s.epsilon_alpha.to_f64(),
                epsilon_beta: s.epsilon_beta.to_f64(),
            }),
            recoil: cart.zip(self.recoil.map(|(_, units)| units)),
            units: self.units,
        }
    }

    /// A0 Ω² sin Ωt at time `t` after phase 0, m/s².
    #[inline]
    pub fn drive(&self, t: R) -> R {
        t.scaled(self.omega).sin().scaled(self.drive_acceleration)
    }

    /// The contact force that acts, N.
    #[inline]
    fn force(&self, at: &Kinematics<R>) -> R {
        match (self.smoothed, self.mode) {
            (Some(smoothed), _) => smoothed.blended(at.delta, self.rig.force(at, self.approach)),
            (None, SwitchMode::Flight) => R::ZERO,
            (None, SwitchMode::Contact) => self.rig.force(at, self.approach),
        }
    }

    /// Acceleration and contact force at a point.
    #[inline]
    pub fn acceleration(&self, p: &FlowPoint<R>) -> (R, R) {
        let acting = self.acting(p, &self.rig.kinematics(p.q, p.v));
        (acting.acceleration, acting.force)
    }

    #[inline(always)]
    fn acting(&self, p: &FlowPoint<R>, at: &Kinematics<R>) -> Acting<R> {
        let force = self.force(at);
        let course = self.drive(p.t);
        match self.recoil {
            None => Acting {
                acceleration: self.rig.acceleration(at, p.v, course, force),
                deviation: R::ZERO,
                force,
                drive: course,
            },
            Some((cart, _)) => {
                let both = cart.both(self.rig, at, p.v, force, course, p.cart);
                Acting {
                    acceleration: both.acceleration,
                    deviation: both.deviation,
                    force,
                    drive: both.drive,
                }
            }
        }
    }

    /// The indicator at a point.
    pub fn indicator(&self, p: &FlowPoint<R>) -> R {
        let at = self.rig.kinematics(p.q, p.v);
        self.rig.indicator(&at, self.approach_at(at.rate))
    }

    /// δ̇⁻ for the indicator: in flight, what it would be if contact began here.
    #[inline]
    pub fn approach_at(&self, rate: R) -> R {
        match self.mode {
            SwitchMode::Flight => rate.max(R::ZERO),
            SwitchMode::Contact => self.approach,
        }
    }
}

impl<R: Scalar> Flow<4> for HammerFlow<'_, R> {
    type Number = R;
    type Point = FlowPoint<R>;
    type Totals = FlowTotals;
    type Exit = ();

    #[inline]
    fn time(&self, point: &FlowPoint<R>) -> R {
        point.t
    }

    #[inline(always)]
    fn numbers(&self, p: &FlowPoint<R>) -> [R; 4] {
        [p.q, p.v, p.cart[0], p.cart[1]]
    }

    #[inline]
    fn moving(&self) -> usize {
        if self.recoil.is_some() { 4 } else { 2 }
    }

    #[inline(always)]
    fn after(&self, from: &FlowPoint<R>, tau: R, [q, v, off, off_rate]: [R; 4]) -> FlowPoint<R> {
        FlowPoint {
            t: from.t + tau,
            q,
            v,
            cart: [off, off_rate],
        }
    }

    #[inline(always)]
    fn rates(&self, p: &FlowPoint<R>, rates: &mut [R; 4], weight: f64, totals: &mut FlowTotals) {
        let at = self.rig.kinematics(p.q, p.v);
        let now = self.acting(p, &at);
        if weight != 0.0 {
            let powers = FlowTotals {
                impulse: now.force.to_f64(),
                contact_work: self.rig.contact_power(&at, p.v, now.force).to_f64(),
                inertial_work: self.rig.inertial_power(&at, now.drive).to_f64(),
                damping_work: self.rig.damping_power(p.v).to_f64(),
            };
            totals.add(&powers, weight);
        }
        *rates = [p.v, now.acceleration, p.cart[1], now.deviation];
    }

    #[inline]
    fn error(&self, fifth: &[f64; 4], third: &[f64; 4], h: f64) -> f64 {
        let size = |[q, v, e, w]: &[f64; 4]| {
            let hammer = length(q / self.units.0, v / self.units.1);
            let both = match self.recoil {
                None => hammer,
                Some((_, units)) => length(hammer, length(e / units.0, w / units.1)),
            };
            both * h.abs()
        };
        combined(size(fifth), size(third))
    }

    fn exit(&self, from: &FlowPoint<R>, h: f64, end: &FlowPoint<R>) -> Option<((), R)> {
        if self.smoothed.is_some() {
            return None;
        }
        let at = switching::locate(&self.in_values(), &from.in_values(), h, &end.in_values())?;
        let reached = |tau| reached(self, from, tau);
        Some(((), switching::instant(self, reached, at)))
    }
}
