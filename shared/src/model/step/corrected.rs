//! The switch model with the step split where the switch falls.

use super::{HammerState, Span, Stepper, fine, piece, recoil, runge_kutta};
use crate::model::contact::Law;
use crate::model::contacts::Ledger;
use crate::model::rig::{Kinematics, Rig, SwitchMode};
use crate::model::scalar::Real;

/// Switches located in one part of a tick; a third waits for the next part.
pub const MAX_SWITCHES: usize = 2;

/// Secant iterations per switch.
pub const MAX_ITERATIONS: usize = 4;

/// Halvings that look for a start of the secant, in a part that begins on a switch.
pub const MAX_PROBES: usize = 3;

/// An iterate that moves by less than this share of the tick is the last: the secant's error is then the
/// product of this and an earlier one, far below what f32 resolves.
const SETTLED: f64 = 1e-4;

pub(super) const LOCATION: Location = Location {
    iterations: MAX_ITERATIONS,
    settled: SETTLED,
};

/// Locates each switch within the step and splits the step there.
///
/// The switch is found by at most [`MAX_ITERATIONS`] secant iterations, each a Runge–Kutta step of the
/// trial length from the same start, and the last iterate is used (not an end of the bracket: that would
/// bias every contact the same way). At most [`MAX_SWITCHES`] per part of a tick, so the work is bounded:
/// for each switch a trial, a look at an extremum, three probes and four iterations, and a last step:
/// 9 · 2 + 1 = 19 Runge–Kutta steps, twice that in a tick that a strobe parts, whatever the hammer does. A
/// touch and return inside one step is found by testing the extremum of δ.
///
/// Under the nonlinear laws a tick is cut into pieces while in contact: at most
/// [`super::MAX_PIECES`] of them, with as many steps for a switch as above.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Corrected;

/// How closely a switch is located.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Location {
    /// Secant iterations at most.
    pub iterations: usize,
    /// An iterate that moves by less than this share of the tick is the last.
    pub settled: f64,
}

/// The motion up to the next switch, or to the end of a span.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SwitchLeg<R> {
    /// The fraction of the tick at which it ends.
    pub at: R,
    /// The step that ends there, still in the mode it began in.
    pub moved: super::Moved<R>,
    /// Whether it ends on a switch.
    pub switched: bool,
}

impl Corrected {
    /// Moves on from `state` at `span.from` to the first switch, at most to `span.to`. `fresh` says that
    /// the span begins on a switch.
    #[inline]
    pub(crate) fn leg<R: Real>(
        rig: &Rig<R>,
        span: &Span<R>,
        state: &HammerState<R>,
        fresh: bool,
        location: Location,
    ) -> SwitchLeg<R> {
        let part = (span.from, span.to);
        let moved = Self::step(rig, span, state, part);
        match Self::bracket(rig, span, state, part, &moved.state) {
            None => SwitchLeg {
                at: span.to,
                moved,
                switched: false,
            },
            Some(far) => {
                let start = (span.from, fresh);
                let (at, moved) = Self::locate(rig, span, state, start, far, location);
                SwitchLeg {
                    at,
                    moved,
                    switched: true,
                }
            }
        }
    }

    /// A step in the field of `state.mode`.
    #[inline]
    pub(crate) fn step<R: Real>(
        rig: &Rig<R>,
        span: &Span<R>,
        state: &HammerState<R>,
        part: (R, R),
    ) -> super::Moved<R> {
        let approach = state.approach;
        let force = |at: &Kinematics<R>| match state.mode {
            SwitchMode::Flight => R::ZERO,
            SwitchMode::Contact => rig.force(at, approach),
        };
        match span.cart {
            None => runge_kutta(rig, span, state, part, force),
            Some(cart) => recoil::runge_kutta(rig, cart, span, state, part, force),
        }
    }

    /// The indicator and δ̇ at a state.
    #[inline]
    pub(crate) fn indicator_and_rate<R: Real>(rig: &Rig<R>, state: &HammerState<R>) -> (R, R) {
        let at = rig.kinematics(state.q.hi, state.v.hi);
        let (law, approach) = (rig.law(), state.approach);
        let indicator = match state.mode {
            // Coming in, every law pushes as soon as δ > 0; this is straight over a long step too.
            SwitchMode::Flight if at.rate > R::ZERO => law.stiffness() * at.delta,
            SwitchMode::Flight => law.indicator(at.delta, at.rate, at.rate.max(R::ZERO)),
            SwitchMode::Contact => law.release_indicator(at.delta, at.rate, approach),
        };
        (indicator, at.rate)
    }

    /// Whether the indicator has left the mode's side.
    #[inline]
    fn switched<R: Real>(mode: SwitchMode, indicator: R) -> bool {
        match mode {
            SwitchMode::Flight => indicator > R::ZERO,
            SwitchMode::Contact => indicator < R::ZERO,
        }
    }

    /// Where the trial step may be cut, if a switch falls in it: the far end of a bracket, and the
    /// indicator there.
    #[inline]
    fn bracket<R: Real>(
        rig: &Rig<R>,
        span: &Span<R>,
        state: &HammerState<R>,
        (from, to): (R, R),
        end: &HammerState<R>,
    ) -> Option<(R, R)> {
        let (indicator, rate) = Self::indicator_and_rate(rig, end);
        if Self::switched(state.mode, indicator) {
            return Some((to, indicator));
        }
        let (_, rate_before) = Self::indicator_and_rate(rig, state);
        if state.mode == SwitchMode::Flight && rate_before > R::ZERO && rate < R::ZERO {
            let top = from + (to - from) * (rate_before / (rate_before - rate));
            let there = Self::step(rig, span, state, (from, top)).state;
            let (indicator, _) = Self::indicator_and_rate(rig, &there);
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
        state: &HammerState<R>,
        (from, fresh): (R, bool),
        (far, at_far): (R, R),
        location: Location,
    ) -> (R, super::Moved<R>) {
        let (mut x0, mut g0) = (from, Self::indicator_and_rate(rig, state).0);
        let (mut far, mut at_far) = (far, at_far);
        if fresh {
            // The part starts on the switch before it: the indicator is zero here too, and would draw the
            // secant back. Start from a point that has not switched yet.
            for _ in 0..MAX_PROBES {
                x0 = from + R::HALF * (far - from);
                g0 = Self::indicator_and_rate(rig, &Self::step(rig, span, state, (from, x0)).state)
                    .0;
                if !Self::switched(state.mode, g0) {
                    break;
                }
                (far, at_far) = (x0, g0);
            }
        }
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
            let (g, _) = Self::indicator_and_rate(rig, &moved.state);
            let settled = (next - x1).abs() <= R::from_f64(location.settled) || g == R::ZERO;
            if settled || iteration >= location.iterations {
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
    fn advance(
        &self,
        rig: &Rig<R>,
        span: &Span<R>,
        state: &mut HammerState<R>,
        ledger: &mut Ledger<R>,
    ) {
        if !matches!(rig.law(), Law::SpringDashpot { .. }) {
            return fine::advance(rig, span, state, ledger);
        }
        let mut from = span.from;
        for switches in 0..=MAX_SWITCHES {
            let rest = Span { from, ..*span };
            let leg = if switches < MAX_SWITCHES {
                Self::leg(rig, &rest, state, switches > 0, LOCATION)
            } else {
                SwitchLeg {
                    at: span.to,
                    moved: Self::step(rig, span, state, (from, span.to)),
                    switched: false,
                }
            };
            let SwitchLeg { at, moved, .. } = leg;
            if state.mode == SwitchMode::Contact {
                ledger.add(&piece(rig, span, (from, at), state, &moved));
            }
            *state = moved.state;
            if !leg.switched {
                return;
            }
            let rate = rig.kinematics(state.q.hi, state.v.hi).rate;
            match state.mode {
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
            from = at;
        }
    }

    #[inline]
    fn force(&self, rig: &Rig<R>, state: &HammerState<R>) -> R {
        match state.mode {
            SwitchMode::Flight => R::ZERO,
            SwitchMode::Contact => {
                let at = rig.kinematics(state.q.hi, state.v.hi);
                rig.force(&at, state.approach).max(R::ZERO)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::drive::Drive;
    use crate::model::params::{BEAM_170, RigParams};

    #[test]
    fn a_contact_within_one_tick_is_not_folded_into_its_onset() {
        let params = RigParams {
            gap_m: 1e-3,
            ..BEAM_170
        };
        let rig = Rig::<f64>::new(&params).unwrap();
        let tick_s = 50e-6;
        let drive = Drive::<f64>::new(7.0, tick_s).unwrap();
        // Some 20 µs before a touch at 0.7 mm/s, while the cart pulls the surface away ever harder: by
        // 30 m/s² in the middle of the tick.
        let speed = 7e-4;
        let mut state = HammerState::new(&rig, 6e-9 - speed * 2e-5, speed);
        let span = Span {
            drive: &drive,
            drive_acceleration: -30.0 / drive.sin_ahead(0.5),
            cart: None,
            from: 0.0,
            to: 1.0,
        };
        let mut ledger = Ledger::default();
        Corrected.advance(&rig, &span, &mut state, &mut ledger);
        let contact = ledger.take_finished().expect("a touch and a release");
        assert!((5e-6..30e-6).contains(&contact.duration_s), "{contact:?}");
        assert!(
            contact.rebound_speed < contact.approach_speed,
            "{contact:?}"
        );
        assert!(
            contact.impulse > 0.0 && contact.peak_force > 0.0,
            "{contact:?}"
        );
        assert_eq!(state.mode, SwitchMode::Flight);
    }
}
