//! Watches what must never happen, by the plant's truth.

use emulator::record::{BlockRow, RunObserver, TickRow};
use emulator::scenario::Scenario;
use shared::control::State;
use shared::io::{AdcCode, Channel, Frame, Output, Reading};
use shared::settings::Settings;

use super::draw::stop_s;

/// Blocks of ten ticks: the rest of the sample's own, one more; and one in which the controller has just come to
/// drive and its outputs have not yet.
const GRACE: u64 = 30;

/// Longer by what the anti-alias filters take.
const TRUE_GRACE: u64 = GRACE + 10;

/// With a sensor that lies: half as long again as docs/controller.md states for a sensor that is out of its family.
const LYING_GRACE: u64 = 45_000;

/// Beyond this share of a trip level the truth must not stay.
const BEYOND: f64 = 1.1;

/// A condition on consecutive ticks.
#[derive(Default)]
struct Level {
    in_a_row: u64,
    /// First tick beyond it since the drive came on, and the largest share of it then.
    since: Option<u64>,
    largest: f64,
}

impl Level {
    /// Counts a tick at `share` of a level; says whether it is beyond the level in `enough` ticks in a row.
    fn passes(&mut self, on: bool, share: f64, level: f64, enough: u64, tick: u64) -> bool {
        if !on {
            *self = Self::default();
            return false;
        }
        self.in_a_row = if share > level { self.in_a_row + 1 } else { 0 };
        if self.in_a_row > 0 {
            self.largest = self.largest.max(share);
        }
        let passes = self.in_a_row >= enough;
        if passes {
            self.since.get_or_insert(tick);
        }
        passes
    }

    /// Ticks since it was first passed.
    fn ticks(&self, tick: u64) -> u64 {
        self.since.map_or(0, |since| tick - since)
    }
}

/// Watches a run.
pub struct Watch {
    settings: Settings,
    seen: [Level; 2],
    /// Force, cart, and hammer relative to the cart.
    truth: [Level; 3],
    /// Tick by which the drive must be off.
    deadline: Option<u64>,
    /// Last tick at which something of the scenario's was wrong.
    faulty: Option<u64>,
    /// Tick of the stop at the end.
    stop: u64,
    /// Whether the last block before it left the controller in Hold.
    pub held: bool,
    pub wrong: Option<String>,
}

fn value(channel: &Channel, code: AdcCode) -> Option<f32> {
    match channel.read(code) {
        Reading::Value(value) | Reading::Saturated(value) => Some(value),
        Reading::Open => None,
    }
}

impl Watch {
    pub fn new(scenario: &Scenario) -> Self {
        Self {
            settings: scenario.settings,
            seen: Default::default(),
            truth: Default::default(),
            deadline: None,
            faulty: None,
            stop: (stop_s(scenario) / scenario.tick_s()) as u64,
            held: false,
            wrong: None,
        }
    }

    fn wrong(&mut self, text: String) {
        self.wrong.get_or_insert(text);
    }

    /// What the sensors show above a trip level, and an open chain, switch the drive off in time.
    fn shown(&mut self, row: &TickRow) {
        let (settings, frame) = (&self.settings, &row.frame);
        let on = row.output.enable;
        let force = value(&settings.force, frame.force);
        let travel = value(&settings.hammer, frame.hammer)
            .zip(value(&settings.cart, frame.cart))
            .map(|(x, y)| (x - y).abs());
        let of = |value: Option<f32>, level: f32| value.map_or(0.0, |x| f64::from(x / level));
        let force = of(force, settings.trips.force_n);
        let travel = of(travel, settings.trips.travel_m);
        let [strong, far] = &mut self.seen;
        let strong = strong.passes(on, force, 1.0, 2, row.tick);
        let far = far.passes(on, travel, 1.0, 4, row.tick);
        if strong || far || on && frame.emergency {
            self.deadline.get_or_insert(row.tick + GRACE);
        }
        if !on {
            self.deadline = None;
        }
        if self.deadline.is_some_and(|last| row.tick > last) {
            self.wrong(format!(
                "what is shown leaves the drive on at {} s",
                row.time_s
            ));
        }
    }

    /// And so does what is true.
    fn true_levels(&mut self, row: &TickRow) {
        if row.faulty {
            self.faulty = Some(row.tick);
        }
        // What a sensor said just before it came right still counts.
        let lies = self.faulty.is_some_and(|at| row.tick - at < TRUE_GRACE);
        let (on, trips) = (row.output.enable, self.settings.trips);
        let force = row.true_force_n / f64::from(trips.force_n);
        let cart = row.cart_m.abs() / f64::from(trips.cart_m);
        let travel = (row.hammer_m - row.cart_m).abs() / f64::from(trips.travel_m);
        let [strong, far, wide] = &mut self.truth;
        let now = [
            ("force", strong.passes(on, force, BEYOND, 2, row.tick)),
            ("cart", far.passes(on, cart, BEYOND, 4, row.tick)),
            ("travel", wide.passes(on, travel, BEYOND, 4, row.tick)),
        ];
        let mut wrong = None;
        for ((what, passes), level) in now.into_iter().zip(&self.truth) {
            let ticks = level.ticks(row.tick);
            // A single blow under a sensor that lies cannot be known; that it goes on must be.
            let late = if lies {
                passes && ticks > LYING_GRACE
            } else {
                ticks > TRUE_GRACE
            };
            if late {
                wrong = Some(format!(
                    "true {what} was at {:.3} of its trip level, and the drive is on at {:.4} s, {ticks} ticks later",
                    level.largest, row.time_s
                ));
            }
        }
        if let Some(wrong) = wrong {
            self.wrong(wrong);
        }
        // What passed while a sensor lied is judged anew once it does not.
        if self
            .faulty
            .is_some_and(|at| at + TRUE_GRACE == row.tick + 1)
        {
            self.truth = Default::default();
        }
    }
}

impl RunObserver for Watch {
    fn tick(&mut self, row: &TickRow) {
        self.shown(row);
        self.true_levels(row);
        if !row.output.frequency_hz.is_finite() {
            self.wrong(format!("no number put out at {} s", row.time_s));
        }
    }

    fn block(&mut self, row: &BlockRow) {
        let s = row.status;
        let told = [
            s.frequency_hz,
            s.amplitude_m,
            s.measured_amplitude_m,
            s.lag_rad,
            s.peak_n,
            s.impulse_n_s,
            s.target_hz,
            s.target_n,
        ];
        if !told.iter().all(|x| x.is_finite()) {
            self.wrong(format!("no number told at tick {}: {s:?}", row.tick));
        }
        if row.tick < self.stop {
            self.held = s.state == State::Hold;
        }
        let driven = row.outputs.iter().any(|output| output.enable);
        if driven && matches!(s.state, State::Idle | State::SelfTest | State::Fault) {
            self.wrong(format!("driven in {:?} at tick {}", s.state, row.tick));
        }
    }
}

/// A sensor that shows nothing of it does not hide what is true.
#[test]
fn true_force_cart_and_travel_are_judged_by_themselves() {
    let scenario = super::draw::scenario(0, &[super::draw::Kind::Push]);
    let trips = scenario.settings.trips;
    let judged = |force: f64, cart: f64, travel: f64, ticks: u64| {
        let mut watch = Watch::new(&scenario);
        let cart_m = cart * f64::from(trips.cart_m);
        let rest = AdcCode(2048);
        for tick in 0..ticks {
            watch.tick(&TickRow {
                tick,
                time_s: tick as f64 * 5e-5,
                frame: Frame {
                    force: AdcCode(scenario.settings.force.zero_code as u16),
                    hammer: rest,
                    cart: rest,
                    emergency: false,
                },
                output: Output {
                    enable: true,
                    ..Output::SAFE
                },
                true_force_n: force * f64::from(trips.force_n),
                hammer_m: cart_m + travel * f64::from(trips.travel_m),
                cart_m,
                powered: true,
                faulty: false,
            });
        }
        watch.wrong
    };
    let late = TRUE_GRACE + 10;
    for (what, levels) in [
        ("force", [1.0, 0.0, 0.0]),
        ("cart", [0.0, 1.0, 0.0]),
        ("travel", [0.0, 0.0, 1.0]),
    ] {
        let at = |share: f64, ticks| {
            let [force, cart, travel] = levels.map(|level: f64| level * share);
            judged(force, cart, travel, ticks)
        };
        assert_eq!(at(1.09, late), None, "{what}");
        assert_eq!(at(1.11, TRUE_GRACE), None, "{what}");
        let wrong = at(1.11, late).unwrap();
        assert!(wrong.contains(&format!("true {what}")), "{wrong}");
        assert!(at(-1.11, late).is_some() || what == "force");
    }
}
