//! The 1/1 orbit at a frequency, stable or not: Newton's iteration on the section's return map, with the
//! monodromy matrix that the [`Variation`] carries along.

use super::ForecastOrbit;
use super::march::{ForecastModel, ForecastSection, March, MarchStep, Setup};
use super::monodromy::ForecastMonodromy;
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

/// Steps in a period after which the iteration gives up, with a prescribed cart.
const MOST_STEPS: u16 = 600;

/// A section point farther out than this (in A0 and A0 Ω), or deeper inside the surface (in A0), belongs to
/// no orbit.
const FAR: f32 = 60.0;
const DEEP: f32 = 0.2;

/// A fixed point of the return map over one period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// Where it lies on the section.
    pub section: ForecastSection,
    /// Onsets in the period.
    pub onsets: u16,
    /// The orbit through it.
    pub orbit: ForecastOrbit,
}

impl Solution {
    /// The orbit, if it is a 1/1: one contact in the period and no other touch.
    pub fn one_one(&self) -> Option<ForecastOrbit> {
        (self.onsets == 1).then_some(self.orbit)
    }

    /// Whether it is a 1/1 that attracts.
    pub fn is_stable_one_one(&self) -> bool {
        self.onsets == 1 && self.orbit.is_stable()
    }
}

/// How the iteration stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shooting {
    /// Not done: another step is due.
    Working,
    /// A fixed point of the return map was found.
    Found(Solution),
    /// None from this guess.
    Lost,
}

/// The iteration, a Runge–Kutta step at a time.
#[derive(Clone, Copy, Debug)]
pub struct Shoot {
    march: March,
    variation: Variation,
    start: ForecastSection,
    iteration: u8,
    steps: u16,
    /// A step of the march that the derivative has not followed yet.
    ahead: Option<MarchStep>,
}

impl Shoot {
    /// Starts at `guess`. `None` if no drive can run at that frequency.
    pub fn new(model: &ForecastModel, frequency_hz: f32, guess: ForecastSection) -> Option<Self> {
        let setup = Setup::new(model, frequency_hz)?;
        Some(Self {
            march: March::with_lead(&setup, guess),
            variation: Variation::new(&model.tangent, &setup, guess),
            start: guess,
            iteration: 0,
            steps: 0,
            ahead: None,
        })
    }

    /// One step of the march, or of the derivative that follows it. `model` is that of the start.
    pub fn step(&mut self, model: &ForecastModel) -> Shooting {
        let Some(stretch) = self.ahead.take() else {
            if self.steps == 0 && !self.plausible() {
                return Shooting::Lost;
            }
            self.ahead = Some(self.march.step());
            self.steps = self.steps.saturating_add(1);
            return Shooting::Working;
        };
        self.variation
            .follow(&model.tangent, self.march.setup(), &stretch);
        if stretch.period_ended {
            self.close(model)
        } else if self.steps >= MOST_STEPS.saturating_add(self.march.setup().ringing_steps) {
            Shooting::Lost
        } else {
            Shooting::Working
        }
    }

    fn plausible(&self) -> bool {
        let [q, v, ..] = self.start;
        let rig = &self.march.setup().rig;
        largest(in_units(self.start, self.march.setup().units)) < FAR
            && rig.kinematics(q, v).delta < DEEP * rig.amplitude()
    }

    /// A period has ended: the next guess, or the end.
    fn close(&mut self, model: &ForecastModel) -> Shooting {
        let period = self.march.close_period();
        let units = self.march.setup().units;
        let miss = in_units(along(self.start, -1.0, self.march.section()), units).map(|x| -x);
        let monodromy = self.variation.monodromy(self.march.setup());
        if !monodromy.is_finite() || period.onsets > MOST_ONSETS {
            return Shooting::Lost;
        }
        if largest(miss) < CLOSURE {
            return self.found(&period, &monodromy);
        }
        self.iteration += 1;
        let step = monodromy.newton_step(miss);
        let length = largest(step);
        if !length.is_finite() || self.iteration >= ITERATIONS {
            return Shooting::Lost;
        }
        let damping = if length > LONGEST_STEP {
            LONGEST_STEP / length
        } else {
            1.0
        };
        let ([s, t, x, y], [a, b, c, d]) = (step, units);
        self.start = along(self.start, damping, [s * a, t * b, x * c, y * d]);
        self.steps = 0;
        let setup = *self.march.setup();
        self.march = March::with_lead(&setup, self.start);
        self.variation.restart(&model.tangent, self.start);
        Shooting::Working
    }

    fn found(&self, period: &Period<f32>, monodromy: &ForecastMonodromy) -> Shooting {
        let latest = self.march.latest_contact();
        let Some((onset, approach)) = latest.onset else {
            // A fixed point without contact.
            return Shooting::Lost;
        };
        let orbit = ForecastOrbit {
            force_n: period.peak_force,
            impulse_n_s: latest.impulse_n_s,
            approach_m_per_s: approach,
            onset_turns: onset.phase as f32 * (1.0 / TURN) as f32 + self.march.lead_turns(),
            multiplier: monodromy.multiplier(),
            doubling_test: monodromy.doubling_test(),
        };
        let numbers = [orbit.force_n, orbit.impulse_n_s, orbit.onset_turns];
        if !numbers.into_iter().all(f32::is_finite) {
            return Shooting::Lost;
        }
        Shooting::Found(Solution {
            section: self.start,
            onsets: period.onsets,
            orbit,
        })
    }
}

/// The largest magnitude; NaN if a number is none.
fn largest(x: ForecastSection) -> f32 {
    let sizes = x.map(libm::fabsf).into_iter();
    // No comparison with NaN holds: once it is the largest, it stays so.
    sizes.fold(0.0, |most, x| if x > most || x.is_nan() { x } else { most })
}

/// `from` + `by` · `step`.
fn along(
    [q, v, e, w]: ForecastSection,
    by: f32,
    [dq, dv, de, dw]: ForecastSection,
) -> ForecastSection {
    [q + by * dq, v + by * dv, e + by * de, w + by * dw]
}

fn in_units([q, v, e, w]: ForecastSection, [a, b, c, d]: ForecastSection) -> ForecastSection {
    [q / a, v / b, e / c, w / d]
}
