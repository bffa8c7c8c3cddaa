//! The 1/1 orbit at a frequency, stable or not: Newton's iteration on the section's return map, with the
//! monodromy matrix that the [`Variation`] carries along.

use super::Orbit;
use super::march::{ForecastModel, March, MarchStep, Setup};
use super::variation::Variation;
use crate::model::contacts::Period;
use crate::model::drive::TURN;

/// Newton's steps before giving up.
const ITERATIONS: u8 = 8;

/// A fixed point is found when the return map moves it by less than this share of A0 and A0 Ω: some ten
/// times the grain of `f32` there.
const CLOSURE: f32 = 1e-5;

/// The longest step of Newton's iteration, in A0 and A0 Ω.
const LONGEST_STEP: f32 = 3.0;

/// Onsets in a period after which the iteration gives up.
const MOST_ONSETS: u16 = 6;

/// Steps in a period after which the iteration gives up.
const MOST_STEPS: u16 = 600;

/// A section point farther out than this (in A0 and A0 Ω), or deeper inside the surface (in A0), belongs to
/// no orbit.
const FAR: f32 = 60.0;
const DEEP: f32 = 0.2;

/// A fixed point of the return map over one period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// Coordinate and rate on the section.
    pub section: [f32; 2],
    /// Onsets in the period.
    pub onsets: u16,
    /// The orbit through it.
    pub orbit: Orbit,
}

impl Solution {
    /// The orbit, if it is a 1/1: one contact in the period and no other touch.
    pub fn one_one(&self) -> Option<Orbit> {
        (self.onsets == 1).then_some(self.orbit)
    }

    /// Whether it is a 1/1 that attracts.
    pub fn is_stable_one_one(&self) -> bool {
        self.onsets == 1 && self.orbit.is_stable()
    }
}

/// How the iteration stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress {
    /// Not done.
    Working,
    /// A fixed point.
    Found(Solution),
    /// None from this guess.
    Lost,
}

/// The iteration, a Runge–Kutta step at a time.
#[derive(Clone, Copy, Debug)]
pub struct Shoot {
    setup: Setup,
    march: March,
    variation: Variation,
    start: [f32; 2],
    iteration: u8,
    steps: u16,
    /// A step of the march that the derivative has not followed yet.
    ahead: Option<MarchStep>,
}

impl Shoot {
    /// Starts at `guess`. `None` if no drive can run at that frequency.
    pub fn new(model: &ForecastModel, frequency_hz: f32, guess: [f32; 2]) -> Option<Self> {
        let setup = Setup::new(model, frequency_hz)?;
        Some(Self {
            march: March::new(&setup, guess),
            variation: Variation::new(model, &setup, guess),
            setup,
            start: guess,
            iteration: 0,
            steps: 0,
            ahead: None,
        })
    }

    /// One step of the march, or of the derivative that follows it.
    pub fn step(&mut self) -> Progress {
        let Some(stretch) = self.ahead.take() else {
            if self.steps == 0 && !self.plausible() {
                return Progress::Lost;
            }
            self.ahead = Some(self.march.step());
            self.steps = self.steps.saturating_add(1);
            return Progress::Working;
        };
        self.variation.follow(&stretch);
        if stretch.period_ended {
            self.close()
        } else if self.steps >= MOST_STEPS {
            Progress::Lost
        } else {
            Progress::Working
        }
    }

    fn plausible(&self) -> bool {
        let [q, v] = self.start;
        let rig = &self.setup.rig;
        let [a, b] = self.setup.units;
        // Comparisons with NaN are false.
        libm::fabsf(q / a) < FAR
            && libm::fabsf(v / b) < FAR
            && rig.kinematics(q, v).delta < DEEP * rig.amplitude()
    }

    /// A period has ended: the next guess, or the end.
    fn close(&mut self) -> Progress {
        let period = self.march.close_period();
        let ([q0, v0], [q1, v1]) = (self.start, self.march.section());
        let [a, b] = self.setup.units;
        let miss = [(q1 - q0) / a, (v1 - v0) / b];
        let [[m00, m01], [m10, m11]] = self.variation.monodromy();
        let (trace, determinant) = (m00 + m11, m00 * m11 - m01 * m10);
        if !(trace.is_finite() && determinant.is_finite()) || period.onsets > MOST_ONSETS {
            return Progress::Lost;
        }
        if largest(miss) < CLOSURE {
            return self.found(&period, trace, determinant);
        }
        self.iteration += 1;
        // (I − M) step = miss.
        let (c00, c01, c10, c11) = (1.0 - m00, -m01, -m10, 1.0 - m11);
        let det = c00 * c11 - c01 * c10;
        let step = [
            (c11 * miss[0] - c01 * miss[1]) / det,
            (c00 * miss[1] - c10 * miss[0]) / det,
        ];
        let length = largest(step);
        if !length.is_finite() || self.iteration >= ITERATIONS {
            return Progress::Lost;
        }
        let damping = if length > LONGEST_STEP {
            LONGEST_STEP / length
        } else {
            1.0
        };
        self.start = [q0 + damping * step[0] * a, v0 + damping * step[1] * b];
        self.steps = 0;
        self.march = March::new(&self.setup, self.start);
        self.variation.restart(self.start);
        Progress::Working
    }

    fn found(&self, period: &Period<f32>, trace: f32, determinant: f32) -> Progress {
        let latest = self.march.latest_contact();
        let Some((onset, approach)) = latest.onset else {
            // A fixed point without contact.
            return Progress::Lost;
        };
        let orbit = Orbit {
            force_n: period.peak_force,
            impulse_n_s: latest.impulse_n_s,
            approach_m_per_s: approach,
            onset_turns: onset.phase as f32 * (1.0 / TURN) as f32,
            trace,
            determinant,
        };
        if !(orbit.force_n.is_finite() && orbit.impulse_n_s.is_finite()) {
            return Progress::Lost;
        }
        Progress::Found(Solution {
            section: self.start,
            onsets: period.onsets,
            orbit,
        })
    }
}

fn largest([a, b]: [f32; 2]) -> f32 {
    let (a, b) = (libm::fabsf(a), libm::fabsf(b));
    // NaN must come out as such: neither comparison holds for it.
    if a > b || a.is_nan() { a } else { b }
}
