//! The corrected step under a nonlinear contact law.
//!
//! F = ki δⁿ is not smooth where the contact begins and ends, and it stiffens as it is pressed: one tick of 50 µs is too
//! long there. In contact the tick is cut into pieces: short against the contact's own time scale where it is now, and
//! never longer than half the time δ took to come. In flight nothing changes, and the linear law does not come here.

use super::corrected::{Corrected, LOCATION, SwitchLeg};
use super::{HammerState, Span, piece};
use crate::model::contacts::Ledger;
use crate::model::rig::{Rig, SwitchMode};
use crate::model::scalar::Real;

/// Pieces of one part of a tick, flight included: what bounds the work. As many of the shortest as a tick has, and some
/// more for the switches between them.
pub const MAX_PIECES: usize = 80;

/// The longest piece, in units of the contact's time scale: 1/√(∂F/∂δ / m) or m/(∂F/∂δ̇), the shorter.
const PIECE: f64 = 0.15;

/// The shortest piece, as a share of the tick.
const SHORTEST: f64 = 1.0 / 64.0;

/// Moves `state` over `span` as [`Corrected`] does, in pieces while in contact.
#[inline(never)]
pub(super) fn advance<R: Real>(
    rig: &Rig<R>,
    span: &Span<R>,
    state: &mut HammerState<R>,
    ledger: &mut Ledger<R>,
) {
    let mut from = span.from;
    let mut fresh = false;
    for _ in 0..MAX_PIECES {
        let rest = Span {
            from,
            to: end_of_piece(rig, span, state, from, ledger),
            ..*span
        };
        let leg = Corrected::leg(rig, &rest, state, fresh, LOCATION);
        take(rig, &rest, state, &leg, ledger);
        if leg.switched {
            switch(rig, span, state, leg.at, ledger);
        }
        (from, fresh) = (leg.at, leg.switched);
        if from >= span.to {
            return;
        }
    }
    // Out of pieces: the rest at once, and a note of the tick that would have done.
    ledger.note_tick_needed((from - span.from) * span.drive.tick_s());
    let leg = SwitchLeg {
        at: span.to,
        moved: Corrected::step(rig, span, state, (from, span.to)),
        switched: false,
    };
    take(rig, &Span { from, ..*span }, state, &leg, ledger);
}

/// Enters a leg in the `ledger`, and moves `state` to its end.
#[inline]
fn take<R: Real>(
    rig: &Rig<R>,
    span: &Span<R>,
    state: &mut HammerState<R>,
    leg: &SwitchLeg<R>,
    ledger: &mut Ledger<R>,
) {
    if state.mode == SwitchMode::Contact {
        ledger.add(&piece(rig, span, (span.from, leg.at), state, &leg.moved));
    }
    *state = leg.moved.state;
}

/// Crosses the switch on which `state` stands.
#[inline]
fn switch<R: Real>(
    rig: &Rig<R>,
    span: &Span<R>,
    state: &mut HammerState<R>,
    at: R,
    ledger: &mut Ledger<R>,
) {
    let rate = rig.kinematics(state.q.hi, state.v.hi).rate;
    match state.mode {
        // Moving away, with F near zero, where rounding decides: still the same contact.
        SwitchMode::Flight if rate < R::ZERO => {
            state.mode = SwitchMode::Contact;
            ledger.resume(span.stamp(at), state.approach);
        }
        SwitchMode::Flight => {
            state.mode = SwitchMode::Contact;
            state.approach = rate;
            ledger.onset(span.stamp(at), rate);
        }
        SwitchMode::Contact => {
            state.mode = SwitchMode::Flight;
            ledger.release(span.stamp(at), rate);
        }
    }
}

/// Where the piece that begins at `from` ends, as a fraction of the tick.
#[inline]
fn end_of_piece<R: Real>(
    rig: &Rig<R>,
    span: &Span<R>,
    state: &HammerState<R>,
    from: R,
    ledger: &mut Ledger<R>,
) -> R {
    if state.mode == SwitchMode::Flight {
        return span.to;
    }
    let at = rig.kinematics(state.q.hi, state.v.hi);
    let (by_delta, by_rate) = rig.law().gradient(at.delta, at.rate, state.approach);
    let spring = (by_delta.max(R::ZERO) / rig.mass()).sqrt();
    let damper = by_rate / rig.mass();
    let (tick_s, shortest) = (span.drive.tick_s(), R::from_f64(SHORTEST));
    // Both are 0 where the contact begins: the quotients are infinite there, and the shortest piece is taken.
    let piece = R::from_f64(PIECE) / spring.max(damper);
    if piece < shortest * tick_s {
        ledger.note_tick_needed(piece * R::from_f64(1.0 / SHORTEST));
    }
    let half_the_depth = R::HALF * at.delta.max(R::ZERO) / at.rate.abs();
    let share = (piece.min(half_the_depth) / tick_s).max(shortest);
    // A remainder of less than half a piece is included in this one.
    let to = from + share;
    if to + R::HALF * share < span.to {
        to
    } else {
        span.to
    }
}
