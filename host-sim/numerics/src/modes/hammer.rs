//! The hammer with its modes, run a drive period at a time, both switches located.

use std::f64::consts::TAU;

use shared::model::contacts::{Contact as Finished, Ledger, Period, Piece};
use shared::model::drive::{Stamp, TURN};

use super::contact::{ContactFlow, Step};
use super::flight::Flight;
use super::{ModalRig, State};
use crate::reference::flow::Totals;
use crate::reference::tableau;

/// A switch is located when what is left to it is less than this, s.
const TIME_TOLERANCE_S: f64 = 1e-13;

/// Shortest step on where nothing is about to happen, s.
const SHORTEST_S: f64 = 1e-9;

/// First step after an onset, s.
const FIRST_STEP_S: f64 = 1e-6;

/// Steps after which a period is given up.
const MAX_STEPS_PER_PERIOD: usize = 1_000_000;

/// Watches a run.
pub trait Watch {
    /// The flight was followed from `from` to `to` (s after drive phase 0).
    fn flight(&mut self, _flight: &Flight, _from: f64, _to: f64) {}
    /// A step in contact ended, with what it integrated.
    fn contact(&mut self, _end: &State, _totals: &Totals) {}
}

/// Watches nothing.
impl Watch for () {}

/// A hammer on beam springs with modes, from drive phase 0 to drive phase 0.
#[derive(Clone, Debug)]
pub struct Hammer {
    rig: ModalRig,
    omega: f64,
    period_s: f64,
    state: State,
    touching: bool,
    cycle: u32,
    next_step: f64,
    ledger: Ledger<f64>,
    strongest: Option<Finished<f64>>,
}

/// How a stretch of motion ended.
enum Ended {
    Switched,
    AtPhaseZero,
    Lost,
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
            state: State::default(),
            touching: false,
            cycle: 0,
            next_step: FIRST_STEP_S,
            ledger: Ledger::default(),
            strongest: None,
        }
    }

    /// The rig.
    pub fn rig(&self) -> &ModalRig {
        &self.rig
    }

    /// Drive period, s.
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Where the hammer is now.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The contact with the largest force since this was last asked.
    pub fn take_strongest(&mut self) -> Option<Finished<f64>> {
        self.strongest.take()
    }

    /// Runs to the next drive phase 0 and returns what happened on the way. If the motion cannot be followed, the state
    /// becomes NaN.
    pub fn run_period(&mut self, watch: &mut impl Watch) -> Period<f64> {
        let mut left = MAX_STEPS_PER_PERIOD;
        loop {
            let ended = if self.touching {
                self.press(watch, &mut left)
            } else {
                self.fly(watch, &mut left)
            };
            match ended {
                Ended::Switched => {}
                Ended::AtPhaseZero => break,
                Ended::Lost => {
                    self.state.q = [f64::NAN; super::MAX_MODES];
                    break;
                }
            }
        }
        self.cycle = self.cycle.wrapping_add(1);
        self.state.t = 0.0;
        self.ledger.close_period()
    }

    /// Flies to the next onset or drive phase 0.
    ///
    /// Contact begins where δ and F are both positive. Below the surface δ is watched, above it (just after a release) F.
    /// Either grows from g at most as g + ġ h + ½ G h², G a bound on its second derivative for the rest of the flight:
    /// up to the root of that parabola there is no onset, grazing ones included. Steps from root to root run into the
    /// onset from below, as quadratically as Newton's.
    fn fly(&mut self, watch: &mut impl Watch, left: &mut usize) -> Ended {
        let flight = Flight::new(&self.rig, self.omega, &self.state);
        let from = self.state.t;
        let mut state = self.state;
        let ended = loop {
            *left = left.saturating_sub(1);
            if *left == 0 {
                break Ended::Lost;
            }
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
                break Ended::Switched;
            }
            let to_go = self.period_s - state.t;
            if to_go <= 0.0 {
                break Ended::AtPhaseZero;
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
        if matches!(ended, Ended::Switched) {
            self.touching = true;
            self.next_step = FIRST_STEP_S;
            self.ledger.onset(self.stamp(), self.state.tip_rate());
        }
        ended
    }

    /// Runs in contact to the release or drive phase 0.
    fn press(&mut self, watch: &mut impl Watch, left: &mut usize) -> Ended {
        loop {
            *left = left.saturating_sub(1);
            if *left == 0 {
                return Ended::Lost;
            }
            let to_go = self.period_s - self.state.t;
            if to_go <= 0.0 {
                return Ended::AtPhaseZero;
            }
            let field = ContactFlow {
                rig: &self.rig,
                omega: self.omega,
            };
            let h = self.next_step.min(to_go);
            let mut step = field.step(&self.state, h);
            if step.error > 1.0 {
                self.next_step = tableau::shorter(h, step.error);
                continue;
            }
            if h > SHORTEST_S && dips(&field, &self.state, &step.end) {
                self.next_step = 0.5 * h;
                continue;
            }
            let released = field.force(&step.end).0 <= 0.0;
            if released {
                step = release(&field, &self.state, h);
            } else if h == to_go {
                step.end.t = self.period_s;
            }
            self.next_step = tableau::next(h, step.error);
            self.accept(&step, watch);
            if released {
                self.touching = false;
                self.ledger.release(self.stamp(), self.state.tip_rate());
                let finished = self.ledger.take_finished();
                let force = |c: &Option<Finished<f64>>| c.map_or(-1.0, |c| c.peak_force);
                if force(&finished) > force(&self.strongest) {
                    self.strongest = finished;
                }
                return Ended::Switched;
            }
        }
    }

    fn accept(&mut self, step: &Step, watch: &mut impl Watch) {
        let field = ContactFlow {
            rig: &self.rig,
            omega: self.omega,
        };
        let (start, end) = (field.force(&self.state), field.force(&step.end));
        self.ledger.add(&Piece {
            span_s: step.end.t - self.state.t,
            force: (start.0, end.0),
            force_rate: (start.1, end.1),
            impulse: step.totals.impulse,
            work: step.totals.contact_work,
        });
        self.state = step.end;
        watch.contact(&step.end, &step.totals);
    }

    fn stamp(&self) -> Stamp {
        Stamp {
            cycle: self.cycle,
            phase: (self.state.t / self.period_s * TURN) as u32,
        }
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

/// Whether the force falls below 0 between two points at which it pushes, on the cubic through both.
fn dips(field: &ContactFlow, from: &State, end: &State) -> bool {
    let h = end.t - from.t;
    let ((f0, r0), (f1, r1)) = (field.force(from), field.force(end));
    if f1 <= 0.0 || r0 >= 0.0 || r1 <= 0.0 {
        return false;
    }
    let (d0, d1, rise) = (r0 * h, r1 * h, f1 - f0);
    let cubic =
        |s: f64| f0 + s * (d0 + s * ((3.0 * rise - 2.0 * d0 - d1) + s * (d0 + d1 - 2.0 * rise)));
    (1..8).any(|k| cubic(f64::from(k) / 8.0) < 0.0)
}

/// The step that ends where the force has just fallen to 0, shorter than `h`: Newton's iteration, kept in a bracket.
fn release(field: &ContactFlow, from: &State, h: f64) -> Step {
    let (mut low, mut high) = (0.0, h);
    let mut best = field.step(from, h);
    let mut length = h;
    for _ in 0..100 {
        let (force, slope) = field.force(&best.end);
        let newton = length - force / slope;
        length = if newton > low && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
        let step = field.step(from, length);
        let (force, _) = field.force(&step.end);
        if force > 0.0 {
            low = length;
        } else {
            high = length;
        }
        let moved = (step.end.t - best.end.t).abs();
        best = step;
        if high - low < TIME_TOLERANCE_S || (force <= 0.0 && moved < TIME_TOLERANCE_S) {
            break;
        }
    }
    if field.force(&best.end).0 > 0.0 {
        best = field.step(from, high);
    }
    best
}
