//! Fixed-step integration across the switch, behind one interface.
//!
//! | stepper | the switch |
//! |---|---|
//! | [`Banded`] | the band as the chapter uses it: the field is chosen anew at every Runge–Kutta stage |
//! | [`Corrected`] | the step in which a switch falls is split there: a coarse tick stays accurate |
//! | [`Smoothed`] | arctangent in place of the switch: the chapter's comparison |
//!
//! All three use the classical fourth-order Runge–Kutta method, and add their increments to a
//! [`Compensated`] state.

mod banded;
mod corrected;
mod fine;
mod recoil;
mod smoothed;

pub use banded::Banded;
pub(crate) use corrected::Location;
pub use corrected::{Corrected, MAX_ITERATIONS, MAX_SWITCHES};
pub use fine::MAX_PIECES;
pub use smoothed::Smoothed;

use crate::model::cart::Cart;
use crate::model::contacts::{ContactPiece, Ledger};
use crate::model::drive::{Drive, Stamp};
use crate::model::rig::{Kinematics, Rig, SwitchMode};
use crate::model::scalar::{Compensated, Real};

/// The state of the hammer: plain data.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HammerState<R> {
    /// Generalised coordinate relative to the contact configuration, m or rad ([`crate::model::rig`]).
    pub q: Compensated<R>,
    /// Its rate, m/s or rad/s.
    pub v: Compensated<R>,
    /// Which side of the switch.
    pub mode: SwitchMode,
    /// δ̇⁻, penetration rate at the last onset, m/s.
    pub approach: R,
    /// Deviation of the cart from its course, m, and its rate, m/s; 0 with a prescribed cart.
    pub cart: [R; 2],
}

impl<R: Real> HammerState<R> {
    /// A state at coordinate `q` and rate `v`, in contact if the law pushes there.
    pub fn new(rig: &Rig<R>, q: R, v: R) -> Self {
        let at = rig.kinematics(q, v);
        let approach = at.rate.max(R::ZERO);
        let mode = if rig.indicator(&at, approach) > R::ZERO {
            SwitchMode::Contact
        } else {
            SwitchMode::Flight
        };
        Self {
            q: Compensated::new(q),
            v: Compensated::new(v),
            mode,
            approach,
            cart: [R::ZERO; 2],
        }
    }

    /// At rest relative to the cart.
    pub fn at_rest(rig: &Rig<R>) -> Self {
        Self::new(rig, rig.rest(), R::ZERO)
    }
}

/// A part of a tick, as fractions of it, under the drive.
#[derive(Clone, Copy, Debug)]
pub struct Span<'a, R> {
    /// The drive at the start of the tick.
    pub drive: &'a Drive<R>,
    /// Amplitude A0 Ω² of the cart's acceleration, m/s².
    pub drive_acceleration: R,
    /// The cart, if it recoils ([`Corrected`] alone knows one that does).
    pub cart: Option<&'a Cart<R>>,
    /// Where the part begins, 0 to 1.
    pub from: R,
    /// Where it ends, 0 to 1.
    pub to: R,
}

impl<R: Real> Span<'_, R> {
    /// A0 Ω² sin Ωt at a fraction of the tick, m/s².
    #[inline]
    pub(crate) fn inertial(&self, fraction: R) -> R {
        let sin = if fraction == R::ZERO {
            self.drive.sin()
        } else {
            self.drive.sin_ahead(fraction)
        };
        self.drive_acceleration * sin
    }

    /// q̈ and ë at a state under the contact force `force` (N) and the inertial acceleration `course` (m/s²) of the course.
    #[inline]
    pub(crate) fn accelerations(
        &self,
        rig: &Rig<R>,
        at: &Kinematics<R>,
        state: &HammerState<R>,
        force: R,
        course: R,
    ) -> (R, R) {
        let v = state.v.hi;
        match self.cart {
            None => (rig.acceleration(at, v, course, force), R::ZERO),
            Some(cart) => {
                let both = cart.both(rig, at, v, force, course, state.cart);
                (both.acceleration, both.deviation)
            }
        }
    }

    #[inline]
    pub(crate) fn stamp(&self, fraction: R) -> Stamp {
        self.drive.stamp_ahead(fraction)
    }
}

/// A way to move the hammer through a part of a tick.
pub trait Stepper<R: Real> {
    /// Moves `state` from `span.from` to `span.to` and enters contacts in the `ledger`.
    fn advance(
        &self,
        rig: &Rig<R>,
        span: &Span<R>,
        state: &mut HammerState<R>,
        ledger: &mut Ledger<R>,
    );

    /// The contact force of this stepper's model at a state, N.
    fn force(&self, rig: &Rig<R>, state: &HammerState<R>) -> R;
}

/// What one Runge–Kutta step found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moved<R> {
    pub state: HammerState<R>,
    pub impulse: R,
    work: R,
}

/// One classical Runge–Kutta step of `state` from fraction `from` to `to` of the tick, with the contact
/// force given by `force` at each stage. Impulse and work are integrated by the same quadrature.
#[inline]
fn runge_kutta<R: Real>(
    rig: &Rig<R>,
    span: &Span<R>,
    state: &HammerState<R>,
    (from, to): (R, R),
    force: impl Fn(&Kinematics<R>) -> R,
) -> Moved<R> {
    let h = (to - from) * span.drive.tick_s();
    let half = R::HALF * h;
    let middle = from + R::HALF * (to - from);
    let (q, v) = (state.q.hi, state.v.hi);
    let stage = |dq: R, v: R, drive: R| {
        let at = rig.kinematics(q + dq, v);
        let f = force(&at);
        let power = rig.contact_power(&at, v, f);
        (rig.acceleration(&at, v, drive, f), f, power)
    };
    let drive = span.inertial(middle);
    let (a1, f1, p1) = stage(R::ZERO, v, span.inertial(from));
    let v2 = v + half * a1;
    let (a2, f2, p2) = stage(half * v, v2, drive);
    let v3 = v + half * a2;
    let (a3, f3, p3) = stage(half * v2, v3, drive);
    let v4 = v + h * a3;
    let (a4, f4, p4) = stage(h * v3, v4, span.inertial(to));
    let sixth = h * R::from_f64(1.0 / 6.0);
    let quadrature = |k1: R, k2: R, k3: R, k4: R| sixth * (k1 + R::TWO * (k2 + k3) + k4);
    // Σ of the stage velocities, written as h v + h²/6 (a1 + a2 + a3): the large part is exact.
    let drift = sixth * (a1 + a2 + a3);
    Moved {
        state: HammerState {
            q: state.q.plus(h * (v + state.v.lo + drift)),
            v: state.v.plus(quadrature(a1, a2, a3, a4)),
            ..*state
        },
        impulse: quadrature(f1, f2, f3, f4),
        work: quadrature(p1, p2, p3, p4),
    }
}

/// Force and its rate at a state, N and N/s.
#[inline]
fn force_and_rate<R: Real>(rig: &Rig<R>, span: &Span<R>, state: &HammerState<R>, at: R) -> (R, R) {
    let course = span.inertial(at);
    let v = state.v.hi;
    let at = rig.kinematics(state.q.hi, v);
    let force = rig.force(&at, state.approach);
    let (acceleration, _) = span.accelerations(rig, &at, state, force, course);
    let (by_delta, by_rate) = rig.law().gradient(at.delta, at.rate, state.approach);
    let rate_of_rate = rig.penetration_acceleration(&at, v, acceleration);
    (force, by_delta * at.rate + by_rate * rate_of_rate)
}

/// The ledger's view of a step spent in contact.
#[inline]
pub(crate) fn piece<R: Real>(
    rig: &Rig<R>,
    span: &Span<R>,
    (from, to): (R, R),
    before: &HammerState<R>,
    moved: &Moved<R>,
) -> ContactPiece<R> {
    let (f0, r0) = force_and_rate(rig, span, before, from);
    let (f1, r1) = force_and_rate(rig, span, &moved.state, to);
    ContactPiece {
        span_s: (to - from) * span.drive.tick_s(),
        force: (f0, f1),
        force_rate: (r0, r1),
        impulse: moved.impulse,
        work: moved.work,
    }
}

/// The contact record for steppers that do not locate the switch: a contact begins and ends only at the end
/// of a step.
#[inline]
fn record_at_end<R: Real>(
    rig: &Rig<R>,
    span: &Span<R>,
    state: &mut HammerState<R>,
    moved: &Moved<R>,
    ledger: &mut Ledger<R>,
) {
    let before = *state;
    *state = moved.state;
    let at = rig.kinematics(state.q.hi, state.v.hi);
    if before.mode == SwitchMode::Flight {
        state.approach = at.rate.max(R::ZERO);
    }
    let touching = rig.indicator(&at, state.approach) > R::ZERO;
    let stamp = span.stamp(span.to);
    match (before.mode, touching) {
        (SwitchMode::Flight, true) => {
            state.mode = SwitchMode::Contact;
            ledger.onset(stamp, at.rate);
            let (force, rate) = force_and_rate(rig, span, state, span.to);
            ledger.add(&ContactPiece {
                span_s: R::ZERO,
                force: (force, force),
                force_rate: (rate, rate),
                impulse: moved.impulse,
                work: moved.work,
            });
        }
        (SwitchMode::Contact, _) => {
            ledger.add(&piece(rig, span, (span.from, span.to), &before, moved));
            if !touching {
                state.mode = SwitchMode::Flight;
                ledger.release(stamp, at.rate);
            }
        }
        (SwitchMode::Flight, false) => {}
    }
}

#[cfg(test)]
mod tests;
