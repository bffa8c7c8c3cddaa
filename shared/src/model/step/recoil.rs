//! The Runge–Kutta step of both bodies: hammer, and cart off its course.

use super::{HammerState, Moved, Span};
use crate::model::cart::Cart;
use crate::model::rig::{Kinematics, Rig};
use crate::model::scalar::Real;

/// [`super::runge_kutta`] with a cart that recoils. Never inlined: it is long, and called from many places.
#[inline(never)]
pub(super) fn runge_kutta<R: Real>(
    rig: &Rig<R>,
    cart: &Cart<R>,
    span: &Span<R>,
    state: &HammerState<R>,
    (from, to): (R, R),
    force: impl Fn(&Kinematics<R>) -> R,
) -> Moved<R> {
    let h = (to - from) * span.drive.tick_s();
    let half = R::HALF * h;
    let middle = from + R::HALF * (to - from);
    let (q, v, [e, w]) = (state.q.hi, state.v.hi, state.cart);
    let stage = |dq: R, v: R, cart_now: [R; 2], course: R| {
        let at = rig.kinematics(q + dq, v);
        let f = force(&at);
        let both = cart.both(rig, &at, v, f, course, cart_now);
        let power = rig.contact_power(&at, v, f);
        (both.acceleration, both.deviation, f, power)
    };
    let course = span.inertial(middle);
    let (a1, b1, f1, p1) = stage(R::ZERO, v, [e, w], span.inertial(from));
    let (v2, w2) = (v + half * a1, w + half * b1);
    let (a2, b2, f2, p2) = stage(half * v, v2, [e + half * w, w2], course);
    let (v3, w3) = (v + half * a2, w + half * b2);
    let (a3, b3, f3, p3) = stage(half * v2, v3, [e + half * w2, w3], course);
    let (v4, w4) = (v + h * a3, w + h * b3);
    let (a4, b4, f4, p4) = stage(h * v3, v4, [e + h * w3, w4], span.inertial(to));
    let sixth = h * R::from_f64(1.0 / 6.0);
    let quadrature = |k1: R, k2: R, k3: R, k4: R| sixth * (k1 + R::TWO * (k2 + k3) + k4);
    let drift = sixth * (a1 + a2 + a3);
    Moved {
        state: HammerState {
            q: state.q.plus(h * (v + state.v.lo + drift)),
            v: state.v.plus(quadrature(a1, a2, a3, a4)),
            cart: [
                e + h * (w + sixth * (b1 + b2 + b3)),
                w + quadrature(b1, b2, b3, b4),
            ],
            ..*state
        },
        impulse: quadrature(f1, f2, f3, f4),
        work: quadrature(p1, p2, p3, p4),
    }
}
