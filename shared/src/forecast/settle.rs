//! The regime reached from rest at a frequency: the march until the section repeats, or until its budget of
//! steps is spent.

use super::march::{ForecastModel, ForecastSection, March, MarchStep, Setup};
use crate::model::regime::{Detector, Regime};
use crate::model::scalar::Real;

/// The detector starts anew after these periods: what a transient left in its window would hide a
/// repetition for good.
const WINDOWS: [u16; 3] = [8, 20, 40];

/// Drive periods at most: the last window then sees repetitions up to 16 periods.
const MOST_PERIODS: u16 = 74;

/// Repetitions of n periods are believed after 2n + this many strobes.
const CONFIRMATIONS: u32 = 4;

/// Steps at most, with a prescribed cart; a period of chatter takes some hundreds.
const MOST_STEPS: u32 = 9000;

/// What a run from rest came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settled {
    /// The regime over the last window.
    pub regime: Regime,
    /// Largest force in it, N.
    pub force_n: f32,
    /// The section at the end.
    pub section: ForecastSection,
    /// The section one period before.
    pub before: ForecastSection,
}

/// A run from rest at one frequency, a step of the march at a time.
#[derive(Clone, Copy, Debug)]
pub struct Settle {
    march: March,
    detector: Detector<f32>,
    periods: u16,
    steps: u32,
    force_n: f32,
    before: ForecastSection,
    last: ForecastSection,
}

impl Settle {
    /// From rest. `None` if no drive can run at that frequency.
    pub fn new(model: &ForecastModel, frequency_hz: f32) -> Option<Self> {
        let setup = Setup::new(model, frequency_hz)?;
        let rest = [setup.rig.rest(), 0.0, 0.0, 0.0];
        Some(Self {
            march: March::new(&setup, rest),
            detector: detector(&setup),
            periods: 0,
            steps: 0,
            force_n: 0.0,
            before: rest,
            last: rest,
        })
    }

    /// One step; the finding, once there is one.
    pub fn step(&mut self) -> Option<Settled> {
        let MarchStep { period_ended, .. } = self.march.step();
        self.steps = self.steps.saturating_add(1);
        if period_ended && self.close() {
            return Some(self.finding());
        }
        let most =
            MOST_STEPS + u32::from(MOST_PERIODS) * u32::from(self.march.setup().ringing_steps);
        (self.steps >= most).then(|| self.finding())
    }

    /// A period has ended: whether that was the last one.
    fn close(&mut self) -> bool {
        let period = self.march.close_period();
        (self.before, self.last) = (self.last, self.march.section());
        let [q, v, ..] = self.last;
        if !(q.is_finite() && v.is_finite()) {
            return true;
        }
        self.periods += 1;
        if WINDOWS.contains(&self.periods) {
            self.detector = detector(self.march.setup());
            self.force_n = 0.0;
        } else {
            self.force_n = Real::max(self.force_n, period.peak_force);
        }
        self.detector.push(q, v, &period);
        self.periods >= MOST_PERIODS || (self.periods > WINDOWS[0] && self.repeats())
    }

    fn repeats(&self) -> bool {
        let n = self.detector.regime().periods();
        n.is_some_and(|n| self.detector.periods_seen() >= 2 * u32::from(n) + CONFIRMATIONS)
    }

    fn finding(&self) -> Settled {
        let [q, v, ..] = self.last;
        let finite = q.is_finite() && v.is_finite() && self.force_n.is_finite();
        Settled {
            regime: if finite {
                self.detector.regime()
            } else {
                Regime::Aperiodic { impacts: 0 }
            },
            force_n: if finite { self.force_n } else { 0.0 },
            section: self.last,
            before: self.before,
        }
    }
}

fn detector(setup: &Setup) -> Detector<f32> {
    let [displacement, velocity, ..] = setup.units;
    Detector::new(displacement, velocity)
}
