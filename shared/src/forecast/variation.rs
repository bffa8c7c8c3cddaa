//! The linearisation of the motion, carried beside the march: the same steps in [`Tangent`] numbers, and
//! at each switch the jump of the derivative (the saltation), exact.
//!
//! At a switch the indicator h falls through zero at an instant that depends on where the hammer
//! started: t_e′ = −h′/ḣ. Up to t_e the old field acts, after it the new one, so that at a fixed time just
//! after the switch the rate has v′ + (a⁻ − a⁺) t_e′; the coordinate, whose rate does not jump, keeps q′. The same holds for
//! a cart that recoils.
//!
//! With such a cart the section has four directions, and a [`Tangent`] two: each step is then made twice, which costs
//! hardly more than numbers with four derivatives would, in half the memory.

use super::march::{ForecastSection, MarchStep, Setup};
use super::monodromy::ForecastMonodromy;
use crate::model::drive::Drive;
use crate::model::rig::{Rig, SwitchMode};
use crate::model::scalar::Real;
use crate::model::step::{Corrected, HammerState, Span};
use crate::model::tangent::Tangent;

/// A hammer with its derivatives by the section it started on.
#[derive(Clone, Copy, Debug)]
pub struct Variation {
    drive: Drive<Tangent>,
    units: ForecastSection,
    /// The motion with its derivatives by the hammer's part of the section.
    state: HammerState<Tangent>,
    /// The motion with its derivatives by the cart's part of the section; not followed with a prescribed cart.
    by_cart: HammerState<Tangent>,
}

impl Variation {
    /// Starts at `section`, with derivatives in units of A0 and A0 Ω.
    pub fn new(rig: &Rig<Tangent>, setup: &Setup, section: ForecastSection) -> Self {
        let mut variation = Self {
            drive: setup.drive.map(Tangent::constant),
            units: setup.units,
            state: HammerState::default(),
            by_cart: HammerState::default(),
        };
        variation.restart(rig, section);
        variation
    }

    /// Starts anew from another `section` at phase 0.
    pub fn restart(&mut self, rig: &Rig<Tangent>, section: ForecastSection) {
        let ([q, v, e, w], [a, b, c, d]) = (section, self.units);
        let (first, second) = (|unit| [unit, 0.0], |unit| [0.0, unit]);
        self.state = HammerState {
            cart: [Tangent::constant(e), Tangent::constant(w)],
            ..HammerState::new(rig, Tangent::new(q, first(a)), Tangent::new(v, second(b)))
        };
        self.by_cart = HammerState {
            cart: [Tangent::new(e, first(c)), Tangent::new(w, second(d))],
            ..HammerState::new(rig, Tangent::constant(q), Tangent::constant(v))
        };
        self.drive.restart();
    }

    /// Follows a step of the march of `setup`.
    pub fn follow(&mut self, rig: &Rig<Tangent>, setup: &Setup, stretch: &MarchStep) {
        let cart = setup.cart.map(|cart| cart.map(Tangent::constant));
        let (from, to) = stretch.part;
        let part = (Tangent::constant(from), Tangent::constant(to));
        let span = Span {
            drive: &self.drive,
            drive_acceleration: Tangent::constant(setup.drive_acceleration),
            cart: cart.as_ref(),
            from: part.0,
            to: part.1,
        };
        let follow = |state: &mut HammerState<Tangent>| {
            *state = Corrected::step(rig, &span, state, part).state;
            if stretch.switched {
                cross(rig, &span, state);
            }
        };
        follow(&mut self.state);
        if cart.is_some() {
            follow(&mut self.by_cart);
        }
        if stretch.tick_ended {
            self.drive.advance();
        }
    }

    /// The value now, the very numbers of the march.
    pub fn section(&self) -> ForecastSection {
        let [e, w] = self.state.cart;
        [
            self.state.q.hi.value,
            self.state.v.hi.value,
            e.value,
            w.value,
        ]
    }

    /// The derivative of the section by the one it started on, in units of A0 and A0 Ω.
    pub fn monodromy(&self, setup: &Setup) -> ForecastMonodromy {
        let [[q0, q1], [v0, v1], cart @ ..] = derivatives(&self.state, self.units);
        if setup.cart.is_none() {
            return ForecastMonodromy::Hammer([[q0, q1], [v0, v1]]);
        }
        let [[e0, e1], [w0, w1]] = cart;
        let [[q2, q3], [v2, v3], [e2, e3], [w2, w3]] = derivatives(&self.by_cart, self.units);
        ForecastMonodromy::Both([
            [q0, q1, q2, q3],
            [v0, v1, v2, v3],
            [e0, e1, e2, e3],
            [w0, w1, w2, w3],
        ])
    }
}

/// The derivatives of a state in both directions, in `units`.
fn derivatives(state: &HammerState<Tangent>, [a, b, c, d]: ForecastSection) -> [[f32; 2]; 4] {
    let ([e, w], zero) = (state.cart, Tangent::ZERO);
    let row = |hi: Tangent, lo: Tangent, unit: f32| {
        let ([a, b], [c, d]) = (hi.partial, lo.partial);
        [(a + c) / unit, (b + d) / unit]
    };
    [
        row(state.q.hi, state.q.lo, a),
        row(state.v.hi, state.v.lo, b),
        row(e, zero, c),
        row(w, zero, d),
    ]
}

/// Crosses the switch that `state` lies on, at the end of `span`.
fn cross(rig: &Rig<Tangent>, span: &Span<Tangent>, state: &mut HammerState<Tangent>) {
    let course = span.inertial(span.to);
    let v = state.v.hi;
    let at = rig.kinematics(state.q.hi, v);
    let entering = state.mode == SwitchMode::Flight;
    let approach_there = if entering { at.rate } else { state.approach };
    let without = span.accelerations(rig, &at, state, Tangent::ZERO, course);
    let pushed = span.accelerations(rig, &at, state, rig.force(&at, approach_there), course);
    let (before, after) = if entering {
        (without, pushed)
    } else {
        (pushed, without)
    };
    let instant = instant(rig, state, before.0.value);
    if entering {
        let rate = rig.penetration_acceleration(&at, v, Tangent::constant(before.0.value));
        state.approach = shifted(at.rate, rate.value, instant);
    }
    state.v.hi = shifted(v, before.0.value - after.0.value, instant);
    let [_, w] = &mut state.cart;
    *w = shifted(*w, before.1.value - after.1.value, instant);
    state.mode = if entering {
        SwitchMode::Contact
    } else {
        SwitchMode::Flight
    };
}

/// t_e′ = −h′/ḣ, where the hammer's rate changes by `acceleration` until the switch.
fn instant(rig: &Rig<Tangent>, state: &HammerState<Tangent>, acceleration: f32) -> [f32; 2] {
    let (h, _) = Corrected::indicator_and_rate(rig, state);
    // The same indicator with time for a direction: its derivative is ḣ.
    let (q, v) = (state.q.hi.value, state.v.hi.value);
    let mut in_time = *state;
    in_time.q.hi = Tangent::new(q, [v, 0.0]);
    in_time.v.hi = Tangent::new(v, [acceleration, 0.0]);
    in_time.approach = Tangent::constant(state.approach.value);
    let (rate, _) = Corrected::indicator_and_rate(rig, &in_time);
    let [rate, _] = rate.partial;
    if rate == 0.0 {
        return [0.0; 2];
    }
    h.partial.map(|partial| -partial / rate)
}

/// `x` with its derivatives moved by `rate` times those of an instant.
fn shifted(x: Tangent, rate: f32, [a, b]: [f32; 2]) -> Tangent {
    let [x0, x1] = x.partial;
    Tangent::new(x.value, [x0 + rate * a, x1 + rate * b])
}
