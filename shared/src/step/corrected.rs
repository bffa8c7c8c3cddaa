//! The switch model with the step split where the switch falls.

use super::{Span, State, Stepper, piece, runge_kutta};
use crate::contacts::Ledger;
use crate::rig::{Mode, Rig};
use crate::scalar::Real;

/// Switches located in one part of a tick; a third waits for the next part.
pub const MAX_SWITCHES: usize = 2;

/// Secant iterations per switch.
pub const MAX_ITERATIONS: usize = 4;

/// An iterate that moves by less than this share of the tick is the last: the secant's error is then the
/// product of this and an earlier one, far below what f32 resolves.
const SETTLED: f64 = 1e-4;

/// Locates each switch within the step and splits the step there.
///
/// The switch is found by at most [`MAX_ITERATIONS`] secant iterations, each a Runge–Kutta step of the
/// trial length from the same start, and the last iterate is used (not an end of the bracket: that would
/// bias every contact the same way). At most [`MAX_SWITCHES`] per part of a tick, so the work is bounded:
/// (1 + 1 + 4) · 2 + 1 = 13 Runge–Kutta steps, whatever the hammer does. A touch and return inside one
/// step is found by testing the extremum of δ.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Corrected;

impl Corrected {
    /// A step in the field of `state.mode`.
    #[inline]
    fn step<R: Real>(
        rig: &Rig<R>,
        span: &Span<R>,
        state: &State<R>,
        part: (R, R),
    ) -> super::Moved<R> {
        let approach = state.approach;
        runge_kutta(rig, span, state, part, |at| match state.mode {
            Mode::Flight => R::ZERO,
            Mode::Contact => rig.force(at, approach),
        })
    }

    /// The indicator and δ̇ at a state.
    #[inline]
    fn look<R: Real>(rig: &Rig<R>, state: &State<R>) -> (R, R) {
        let at = rig.kinematics(state.q.hi, state.v.hi);
        let approach = match state.mode {
            Mode::Flight => at.rate.max(R::ZERO),
            Mode::Contact => state.approach,
        };
        (rig.indicator(&at, approach), at.rate)
    }

    /// Whether the indicator has left the mode's side.
    #[inline]
    fn switched<R: Real>(mode: Mode, indicator: R) -> bool {
        match mode {
            Mode::Flight => indicator > R::ZERO,
            Mode::Contact => indicator < R::ZERO,
        }
    }

    /// Where the trial step may be cut, if a switch falls in it: the far end of a bracket, and the
    /// indicator there.
    #[inline]
    fn bracket<R: Real>(
        rig: &Rig<R>,
        span: &Span<R>,
        state: &State<R>,
        (from, to): (R, R),
        end: &State<R>,
    ) -> Option<(R, R)> {
        let (indicator, rate) = Self::look(rig, end);
        if Self::switched(state.mode, indicator) {
            return Some((to, indicator));
        }
        let (_, rate_before) = Self::look(rig, state);
        if state.mode == Mode::Flight && rate_before > R::ZERO && rate < R::ZERO {
            let top = from + (to - from) * (rate_before / (rate_before - rate));
            let there = Self::step(rig, span, state, (from, top)).state;
            let (indicator, _) = Self::look(rig, &there);
            if Self::switched(state.mode, indicator) {
                return Some((top, indicator));
            }
        }
        None
    }

    /// The fraction of the tick at which the indicator crosses zero between `from` and `far`, and the
    /// step that ends there.
    #[inline]
    fn locate<R: Real>(
        rig: &Rig<R>,
        span: &Span<R>,
        state: &State<R>,
        from: R,
        (far, at_far): (R, R),
    ) -> (R, super::Moved<R>) {
        let (at_from, _) = Self::look(rig, state);
        let (mut x0, mut g0) = (from, at_from);
        let (mut x1, mut g1) = (far, at_far);
        let mut iteration = 1;
        loop {
            let slope = g1 - g0;
            let next = if slope == R::ZERO {
                x1
            } else {
                x1 - g1 * ((x1 - x0) / slope)
            };
            let next = next.max(from).min(far);
            let moved = Self::step(rig, span, state, (from, next));
            let (g, _) = Self::look(rig, &moved.state);
            let settled = (next - x1).abs() <= R::from_f64(SETTLED) || g == R::ZERO;
            if settled || iteration == MAX_ITERATIONS {
                return (next, moved);
            }
            (x0, g0) = (x1, g1);
            (x1, g1) = (next, g);
            iteration += 1;
        }
    }
}

impl<R: Real> Stepper<R> for Corrected {
    #[inline]
    fn advance(&self, rig: &Rig<R>, span: &Span<R>, state: &mut State<R>, ledger: &mut Ledger<R>) {
        let mut from = span.from;
        for switches in 0..=MAX_SWITCHES {
            let part = (from, span.to);
            let moved = Self::step(rig, span, state, part);
            let bracket = if switches < MAX_SWITCHES {
                Self::bracket(rig, span, state, part, &moved.state)
            } else {
                None
            };
            let Some(far) = bracket else {
                if state.mode == Mode::Contact {
                    ledger.add(&piece(rig, span, part, state, &moved));
                }
                *state = moved.state;
                return;
            };
            let (at, moved) = Self::locate(rig, span, state, from, far);
            if state.mode == Mode::Contact {
                ledger.add(&piece(rig, span, (from, at), state, &moved));
            }
            *state = moved.state;
            let rate = rig.kinematics(state.q.hi, state.v.hi).rate;
            match state.mode {
                Mode::Flight => {
                    state.mode = Mode::Contact;
                    state.approach = rate;
                    ledger.onset(span.stamp(at), rate);
                }
                Mode::Contact => {
                    state.mode = Mode::Flight;
                    ledger.release(span.stamp(at), rate);
                }
            }
            from = at;
        }
    }

    #[inline]
    fn force(&self, rig: &Rig<R>, state: &State<R>) -> R {
        match state.mode {
            Mode::Flight => R::ZERO,
            Mode::Contact => {
                let at = rig.kinematics(state.q.hi, state.v.hi);
                rig.force(&at, state.approach).max(R::ZERO)
            }
        }
    }
}
