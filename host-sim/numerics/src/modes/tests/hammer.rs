//! The hammer with its modes, run a drive period at a time, both switches located.

use std::f64::consts::TAU;

use shared::model::contacts::{Contact as Finished, ContactPiece, Period};

use super::contact::{ContactFlow, SHORTEST_S, TIME_TOLERANCE_S};
use super::flight::Flight;
use super::{ModalRig, ModalState};
use crate::flow::dormand_prince::next;
use crate::flow::{FlowStep, Pace, StepEnded};
use crate::modes::log::Log;
use crate::reference::flow::FlowTotals;

/// First step after an onset, s.
const FIRST_STEP_S: f64 = 1e-6;

/// Steps after which a period is given up.
const MAX_STEPS_PER_PERIOD: u64 = 1_000_000;

/// Is told of every flight and of every step in contact while a [`Hammer`] runs.
pub trait ModesWatch {
    /// The flight was followed from `from` to `to` (s after drive phase 0).
    fn flight(&mut self, _flight: &Flight, _from: f64, _to: f64) {}
    /// A step in contact ended, with what it integrated.
    fn contact(&mut self, _end: &ModalState, _totals: &FlowTotals) {}
}

/// For runs that nobody watches.
impl ModesWatch for () {}

/// A hammer on beam springs with modes, from drive phase 0 to drive phase 0.
#[derive(Clone, Debug)]
pub struct Hammer {
    rig: ModalRig,
    omega: f64,
    period_s: f64,
    state: ModalState,
    touching: bool,
    pace: Pace,
    log: Log,
}

impl Hammer {
    /// At rest relative to the cart at drive phase 0.
    ///
    /// # Panics
    /// If `frequency_hz` is not a positive number.
    pub fn at_rest(rig: ModalRig, frequency_hz: f64) -> Self {
        assert!(frequency_hz > 0.0 && frequency_hz.is_finite());
        Self {
            rig,
            omega: TAU * frequency_hz,
            period_s: 1.0 / frequency_hz,
            state: ModalState::default(),
            touching: false,
            pace: Pace::new(FIRST_STEP_S),
            log: Log::default(),
        }
    }

    /// Where the hammer is now.
    pub fn state(&self) -> &ModalState {
        &self.state
    }

    /// The contact with the largest force since this was last asked.
    pub fn take_strongest(&mut self) -> Option<Finished<f64>> {
        self.log.take_strongest()
    }

    /// Runs to the next drive phase 0 and returns what happened on the way. If the motion cannot be followed, the state
    /// becomes NaN.
    pub fn run_period(&mut self, watch: &mut impl ModesWatch) -> Period<f64> {
        let most = self.pace.tried + MAX_STEPS_PER_PERIOD;
        loop {
            let ended = if self.touching {
                self.press(watch, most)
            } else {
                self.fly(watch, most)
            };
            match ended {
                Some(StepEnded::AtStop) => break,
                Some(_) => {}
                None => {
                    self.state.q = [f64::NAN; super::MAX_MODES];
                    break;
                }
            }
        }
        self.state.t = 0.0;
        self.log.close_period()
    }

    /// Flies to the next onset or drive phase 0.
    ///
    /// Contact begins where δ and F are both positive. Below the surface δ is watched, above it (just after a release) F.
    /// Either grows from g at most as g + ġ h + ½ G h², G a bound on its second derivative for the rest of the flight:
    /// up to the root of that parabola there is no onset, grazing ones included. Steps from root to root run into the
    /// onset from below, as quadratically as Newton's.
    fn fly(&mut self, watch: &mut impl ModesWatch, most: u64) -> Option<StepEnded<()>> {
        let flight = Flight::new(&self.rig, self.omega, &self.state);
        let from = self.state.t;
        let mut state = self.state;
        let ended = loop {
            if self.pace.tried >= most {
                break None;
            }
            self.pace.tried += 1;
            let tip = flight.tip(&state);
            let [delta, rate, acceleration] = tip.delta;
            let watched = if delta < 0.0 {
                [delta, rate, tip.bounds[0]]
            } else {
                let (k, c) = self.rig.law.gradient(delta, rate, 0.0);
                let (force, slope) = (self.rig.force(&state), k * rate + c * acceleration);
                [force, slope, k * tip.bounds[0] + c * tip.bounds[1]]
            };
            let safe = safe_step(watched);
            if watched[0] > 0.0 || (safe < TIME_TOLERANCE_S && watched[1] > 0.0) {
                break Some(StepEnded::Switched(()));
            }
            let to_go = self.period_s - state.t;
            if to_go <= 0.0 {
                break Some(StepEnded::AtStop);
            }
            let on = safe.max(if watched[1] > 0.0 { 0.0 } else { SHORTEST_S });
            state = flight.at(if on >= to_go {
                self.period_s
            } else {
                state.t + on
            });
        };
        watch.flight(&flight, from, state.t);
        self.state = state;
        if ended == Some(StepEnded::Switched(())) {
            self.switch();
        }
        ended
    }

    /// Runs in contact to the release or drive phase 0.
    fn press(&mut self, watch: &mut impl ModesWatch, most: u64) -> Option<StepEnded<()>> {
        if self.state.t >= self.period_s {
            return Some(StepEnded::AtStop);
        }
        loop {
            let (state, stop) = (self.state, self.period_s);
            let flow = ContactFlow {
                rig: &self.rig,
                omega: self.omega,
            };
            let (step, ended) = self
                .pace
                .advance(&flow, &state, stop, f64::INFINITY, most)?;
            self.log.add(&piece(&flow, &state, &step));
            self.state = step.end;
            watch.contact(&step.end, &step.totals);
            match ended {
                StepEnded::Within => continue,
                StepEnded::Switched(()) => self.switch(),
                StepEnded::AtStop => self.pace.next = next(step.length, step.error),
            }
            return Some(ended);
        }
    }

    fn switch(&mut self) {
        self.touching = !self.touching;
        let turns = self.state.t / self.period_s;
        self.log.switch(self.touching, turns, self.state.tip_rate());
    }
}

/// What the ledger needs of a step in contact.
fn piece(
    flow: &ContactFlow,
    from: &ModalState,
    step: &FlowStep<f64, ModalState, FlowTotals>,
) -> ContactPiece<f64> {
    let (start, end) = (flow.force(from), flow.force(&step.end));
    ContactPiece {
        span_s: step.end.t - from.t,
        force: (start.0, end.0),
        force_rate: (start.1, end.1),
        impulse: step.totals.impulse,
        work: step.totals.contact_work,
    }
}

/// The first h > 0 at which g + ġ h + ½ G h² is 0, for g ≤ 0; 0 if g > 0.
fn safe_step([g, slope, bound]: [f64; 3]) -> f64 {
    if g > 0.0 {
        return 0.0;
    }
    let root = (slope * slope - 2.0 * bound * g).sqrt();
    if slope > 0.0 {
        -2.0 * g / (slope + root)
    } else if bound > 0.0 {
        (root - slope) / bound
    } else {
        f64::INFINITY
    }
}
