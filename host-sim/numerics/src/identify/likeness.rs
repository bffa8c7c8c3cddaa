//! How similar the model's impacts are to the measured ones.
//!
//! Impacts are compared one by one, the n-th with the n-th, each shifted in time to where it fits best: the flight
//! in between is not what is sought, and the surface's flexibility makes it differ (section 3.3.2).

use shared::model::contact::Law;
use shared::model::params::RigParams;
use shared::model::rig::Rig;

use super::Misfit;
use super::contacts::{Impact, Measured};
use crate::contact_law::undriven::Course;
use crate::drop_test::impacts;

/// Where no noise is seen, squares are counted in this share of the largest peak, so that the search has a scale.
const SCALE_SHARE: f64 = 1e-5;

/// Compares a model with a record.
pub struct Likeness<'a> {
    measured: &'a Measured,
    params: RigParams,
    misfit: Misfit,
    unit_n: f64,
}

/// One impact of the model, laid over the measured one.
#[derive(Clone, Debug)]
pub struct Aligned {
    /// The model's contact; `None` if the model has fewer contacts.
    pub course: Option<Course>,
    /// Where its onset was put in the record, s.
    pub onset_s: f64,
    /// Sum of squared differences of the samples in the window, N².
    pub squares: f64,
    /// Mean of the largest sample that the model and the noise would show, N.
    pub peak_n: f64,
    /// Variance of that, N².
    pub peak_variance: f64,
}

impl<'a> Likeness<'a> {
    /// Of `measured` with the rig of `params`.
    pub fn new(measured: &'a Measured, params: &RigParams, misfit: Misfit) -> Self {
        let largest = measured.impacts.iter().map(|i| i.peak_n);
        let largest = largest.fold(0.0, f64::max);
        Self {
            measured,
            params: *params,
            misfit,
            unit_n: measured.noise_n.max(SCALE_SHARE * largest),
        }
    }

    /// How many numbers are compared, less the time shifts that are chosen by them.
    pub fn data(&self) -> usize {
        let impacts = &self.measured.impacts;
        match self.misfit {
            Misfit::Peaks => impacts.len(),
            Misfit::Force => impacts.iter().map(|i| i.window.len() - 1).sum(),
        }
    }

    /// The misfit over the square of [`Self::unit_n`].
    pub fn cost(&self, law: Law<f64>, release_m: f64) -> f64 {
        self.sum_of_squares(&self.aligned(law, release_m)) / self.unit_n.powi(2)
    }

    /// What squares are counted in, N: the noise, or a hundred thousandth of the largest peak.
    pub fn unit_n(&self) -> f64 {
        self.unit_n
    }

    /// The misfit, N².
    pub fn sum_of_squares(&self, seen: &[Aligned]) -> f64 {
        match self.misfit {
            Misfit::Force => seen.iter().map(|a| a.squares).sum(),
            Misfit::Peaks => {
                let pairs = self.measured.impacts.iter().zip(seen);
                pairs.map(|(i, a)| (i.peak_n - a.peak_n).powi(2)).sum()
            }
        }
    }

    /// The standard deviation of what is compared, N. Of peaks: the mean over the measured impacts, so that none
    /// counts more than another.
    pub fn deviation_n(&self, seen: &[Aligned]) -> f64 {
        match self.misfit {
            Misfit::Force => self.unit_n,
            Misfit::Peaks => {
                let variance = seen.iter().map(|a| a.peak_variance).sum::<f64>();
                (variance / seen.len() as f64).sqrt().max(0.1 * self.unit_n)
            }
        }
    }

    /// The model's impacts laid over the measured ones.
    pub fn aligned(&self, law: Law<f64>, release_m: f64) -> Vec<Aligned> {
        let params = RigParams {
            contact: law,
            ..self.params
        };
        let count = self.measured.impacts.len();
        let Ok(rig) = Rig::<f64>::new(&params) else {
            return self
                .measured
                .impacts
                .iter()
                .map(|i| self.alone(i))
                .collect();
        };
        let courses = impacts(&params, &rig, release_m, count).unwrap_or_default();
        let pairs = self.measured.impacts.iter().enumerate();
        pairs
            .map(|(i, impact)| match courses.get(i) {
                Some(course) => self.align(&rig, impact, course.clone()),
                None => self.alone(impact),
            })
            .collect()
    }

    /// A measured impact that the model does not have.
    fn alone(&self, impact: &Impact) -> Aligned {
        let forces = &self.measured.force_n[impact.window.clone()];
        Aligned {
            course: None,
            onset_s: impact.at_s,
            squares: forces.iter().map(|f| f * f).sum(),
            peak_n: 0.0,
            peak_variance: self.unit_n.powi(2),
        }
    }

    fn align(&self, rig: &Rig<f64>, impact: &Impact, course: Course) -> Aligned {
        let (onset_s, squares) = match self.misfit {
            Misfit::Force => self.best_onset(rig, impact, &course),
            Misfit::Peaks => (impact.at_s, f64::NAN),
        };
        let (peak_n, peak_variance) = match self.misfit {
            // On average the onset falls in the middle between two samples.
            Misfit::Peaks => self.largest_sample(rig, &course),
            Misfit::Force => (course.contact.peak_force_n, self.unit_n.powi(2)),
        };
        Aligned {
            course: Some(course),
            onset_s,
            squares,
            peak_n,
            peak_variance,
        }
    }

    fn squares(&self, rig: &Rig<f64>, impact: &Impact, course: &Course, onset_s: f64) -> f64 {
        let times = &self.measured.time_s[impact.window.clone()];
        let forces = &self.measured.force_n[impact.window.clone()];
        let square = |(t, f): (&f64, &f64)| (course.force(rig, t - onset_s) - f).powi(2);
        times.iter().zip(forces).map(square).sum()
    }

    /// Where the model's onset fits best. The force of a spring-dashpot jumps there: the sum of squares jumps
    /// whenever the onset passes a sample and is smooth in between, so each interval is searched by itself.
    fn best_onset(&self, rig: &Rig<f64>, impact: &Impact, course: &Course) -> (f64, f64) {
        let times = &self.measured.time_s;
        let cost = |onset: f64| self.squares(rig, impact, course, onset);
        let low = impact.window.start;
        let high = (impact.first + 3).min(times.len() - 1);
        let middle = |i: usize| 0.5 * (times[i] + times[i + 1]);
        let mut intervals: Vec<(usize, f64)> = (low..high).map(|i| (i, cost(middle(i)))).collect();
        intervals.sort_by(|a, b| a.1.total_cmp(&b.1));
        let mut best = (impact.at_s, f64::INFINITY);
        for (i, at_middle) in intervals.iter().take(2) {
            let found = vertex(&cost, times[*i], times[i + 1], *at_middle);
            if found.1 < best.1 {
                best = found;
            }
        }
        best
    }

    /// Mean and variance of the largest of the samples this impact would give, each with its noise.
    fn largest_sample(&self, rig: &Rig<f64>, course: &Course) -> (f64, f64) {
        let step = self.measured.sample_s;
        let count = (course.contact.duration_s / step).ceil() as usize + 1;
        let forces: Vec<f64> = (0..count)
            .map(|i| course.force(rig, (i as f64 + 0.5) * step))
            .collect();
        largest_of(&forces, self.measured.noise_n)
            .unwrap_or((course.contact.peak_force_n, self.unit_n.powi(2)))
    }
}

/// The least of `cost` between `a` and `b`, by two parabolas; `at_middle` is its value halfway.
fn vertex(cost: &impl Fn(f64) -> f64, a: f64, b: f64, at_middle: f64) -> (f64, f64) {
    let mut best = (0.5 * (a + b), at_middle);
    let mut half = 0.49 * (b - a);
    for _ in 0..2 {
        let x = best.0;
        let (left, right) = (cost((x - half).max(a)), cost((x + half).min(b)));
        let (dl, dr) = (x - (x - half).max(a), (x + half).min(b) - x);
        if dl <= 0.0 || dr <= 0.0 {
            break;
        }
        // f(x + s) ≈ f + p s + q s².
        let (sl, sr) = ((left - best.1) / dl, (right - best.1) / dr);
        let q = (sl + sr) / (dl + dr);
        let p = sr - q * dr;
        let s = if q > 0.0 {
            -0.5 * p / q
        } else if left < right {
            -dl
        } else {
            dr
        };
        let there = (x + s).clamp(a, b);
        let value = cost(there);
        if value < best.1 {
            best = (there, value);
        }
        half *= 0.1;
    }
    best
}

/// Mean and variance of the largest of independent Gaussians with these means and one deviation: the moments of
/// the density d/dx ∏ Φ((x − fᵢ)/σ). None without noise.
pub(super) fn largest_of(means: &[f64], deviation: f64) -> Option<(f64, f64)> {
    const POINTS: usize = 160;
    const REACH: f64 = 6.0;
    let top = means.iter().fold(f64::NEG_INFINITY, |m, f| m.max(*f));
    if !(deviation > 0.0 && top.is_finite()) {
        return (top.is_finite() && deviation == 0.0).then_some((top, 0.0));
    }
    let near: Vec<f64> = means
        .iter()
        .map(|f| (f - top) / deviation)
        .filter(|f| *f > -2.0 * REACH)
        .collect();
    let normal = |x: f64| 0.5 * libm::erfc(-x / std::f64::consts::SQRT_2);
    let below = |x: f64| near.iter().map(|f| normal(x - f)).product::<f64>();
    let width = 2.0 * REACH / POINTS as f64;
    let (mut before, mut mean, mut square) = (0.0, 0.0, 0.0);
    for i in 0..=POINTS {
        let x = -REACH + width * i as f64;
        let share = below(x + 0.5 * width) - before;
        before += share;
        mean += share * x;
        square += share * x * x;
    }
    // Sheppard's correction for the cells' width.
    let variance = square - mean * mean - width * width / 12.0;
    Some((top + deviation * mean, deviation * deviation * variance))
}
