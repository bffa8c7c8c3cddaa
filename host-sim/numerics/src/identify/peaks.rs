//! The chapter's misfit: the largest sample of each impact against the largest that model and sensor would show.
//!
//! What the sensor does is known from the whole force ([`super::whole`]) and from what is stated beforehand; how
//! uncertain that is adds to the covariance of the peaks, so that peaks that are all too high by the same share are no
//! surprise.

use nalgebra::{DMatrix, DVector};
use shared::model::contact::Law;
use shared::model::params::RigParams;
use shared::model::rig::Rig;

use super::contacts::MeasuredImpacts;
use super::least_squares::Problem as _;
use super::sensor::{FilteredPulse, SensorModel};
use super::shape::{ForceShape, unit_n};
use super::whole::Whole;
use crate::drop_test::impacts;

/// Where the onset lies between two samples is unknown: these shares stand for all.
const PHASES: [f64; 2] = [0.25, 0.75];

/// A peak is known no better than this share of itself: what model and integration leave.
const FLOOR_SHARE: f64 = 1e-3;

/// The measured peaks, beside those that model and sensor would show for a law.
pub struct Peaks<'a> {
    measured: &'a MeasuredImpacts,
    params: RigParams,
    sensor: SensorModel,
    /// The lower triangle L of the peaks' covariance L Lᵀ, and the covariance's diagonal.
    root: DMatrix<f64>,
    variances: Vec<f64>,
}

impl<'a> Peaks<'a> {
    /// With the sensor of `whole`; the covariance is that about `law` and `release_m`.
    pub fn new(
        measured: &'a MeasuredImpacts,
        params: &RigParams,
        whole: &Whole,
        (law, release_m): (Law<f64>, f64),
    ) -> Option<Self> {
        let shape = &whole.shape;
        let sensor = SensorModel {
            gain: 1.0,
            ..shape.sensor(&whole.best.x)
        };
        let mut peaks = Self {
            measured,
            params: *params,
            sensor,
            root: DMatrix::zeros(0, 0),
            variances: Vec::new(),
        };
        let covariance = peaks.covariance(whole, shape, law, release_m)?;
        peaks.variances = covariance.diagonal().iter().copied().collect();
        peaks.root = covariance.cholesky()?.unpack();
        Some(peaks)
    }

    fn covariance(
        &self,
        whole: &Whole,
        shape: &ForceShape,
        law: Law<f64>,
        release_m: f64,
    ) -> Option<DMatrix<f64>> {
        let seen = self.shown(&self.sensor, law, release_m);
        let own: Vec<f64> = seen
            .iter()
            .map(|(mean, variance)| {
                variance + (FLOOR_SHARE * mean).powi(2) + unit_n(self.measured).powi(2) * 1e-2
            })
            .collect();
        let mut covariance = DMatrix::from_diagonal(&DVector::from_vec(own));
        let mean = |sensor: &SensorModel, release_m: f64| {
            let shown = self.shown(sensor, law, release_m);
            DVector::from_iterator(shown.len(), shown.iter().map(|s| s.0))
        };
        let here = mean(&self.sensor, release_m);
        let (gain, release) = (shape.gain_deviation(), shape.release_deviation());
        let higher = SensorModel {
            gain: 1.0 + gain,
            ..self.sensor
        };
        let by_gain = mean(&higher, release_m) - &here;
        let by_release = mean(&self.sensor, release_m * (1.0 + release)) - &here;
        covariance += &by_gain * by_gain.transpose() + &by_release * by_release.transpose();
        // What the whole force leaves of the sensor unknown.
        let unsure = whole.sensor_covariance()?;
        let first = shape.sensor_coordinates().start;
        let mut columns = Vec::new();
        for k in 0..unsure.nrows() {
            let deviation = unsure[(k, k)].max(0.0).sqrt();
            let mut x = whole.best.x.clone();
            let (low, high) = shape.range(&x, first + k);
            // Half a deviation to the side on which there is room.
            let mut by = 0.5 * deviation.min(0.3 * (high - low));
            if x[first + k] + by > high {
                by = -by;
            }
            x[first + k] += by;
            let moved = SensorModel {
                gain: 1.0,
                ..shape.sensor(&x)
            };
            let column = if by == 0.0 {
                &here * 0.0
            } else {
                (mean(&moved, release_m) - &here) / by
            };
            columns.push(column);
        }
        let by_sensor = DMatrix::from_columns(&columns);
        covariance += &by_sensor * unsure * by_sensor.transpose();
        Some(covariance)
    }

    /// Mean and variance of the largest sample of each impact; zero where the model has no impact.
    fn shown(&self, sensor: &SensorModel, law: Law<f64>, release_m: f64) -> Vec<(f64, f64)> {
        let params = RigParams {
            contact: law,
            ..self.params
        };
        let count = self.measured.impacts.len();
        let courses = Rig::<f64>::new(&params).ok().and_then(|rig| {
            let courses = impacts(&params, &rig, release_m, count).ok()?;
            Some((rig, courses))
        });
        let one = |i: usize| {
            let none = (0.0, unit_n(self.measured).powi(2));
            let Some((rig, courses)) = &courses else {
                return none;
            };
            courses.get(i).map_or(none, |course| {
                let step = self.measured.sample_s;
                let pulse = FilteredPulse::new(rig, course, sensor, step);
                let samples = self.measured.impacts[i].window.len();
                self.largest(
                    |share, k| pulse.shown(sensor, (k as f64 + share) * step),
                    samples,
                )
            })
        };
        (0..count).map(one).collect()
    }

    /// Of the largest of so many samples: its mean and variance over noise, rounding and where the samples lie.
    fn largest(&self, at: impl Fn(f64, usize) -> f64, samples: usize) -> (f64, f64) {
        let of = |share: f64| {
            let forces: Vec<f64> = (0..samples).map(|k| at(share, k)).collect();
            largest_of(&forces, self.measured.white_n)
        };
        let each: Vec<(f64, f64)> = PHASES.iter().map(|share| of(*share)).collect();
        let count = each.len() as f64;
        let mean = each.iter().map(|e| e.0).sum::<f64>() / count;
        let spread = each.iter().map(|e| (e.0 - mean).powi(2)).sum::<f64>() / (count - 1.0);
        let variance = each.iter().map(|e| e.1).sum::<f64>() / count;
        (
            mean,
            variance + spread + self.measured.step_n.powi(2) / 12.0,
        )
    }

    /// What the peaks differ by, so that the sum of squares is χ².
    pub fn residuals(&self, law: Law<f64>, release_m: f64) -> Option<DVector<f64>> {
        self.root.solve_lower_triangular(&self.off(law, release_m))
    }

    fn off(&self, law: Law<f64>, release_m: f64) -> DVector<f64> {
        let shown = self.means(law, release_m);
        let pairs = self.measured.impacts.iter().zip(shown);
        DVector::from_iterator(self.data(), pairs.map(|(i, mean)| i.peak_n - mean))
    }

    /// The largest sample of each impact as model and sensor would show it, N.
    pub fn means(&self, law: Law<f64>, release_m: f64) -> Vec<f64> {
        let shown = self.shown(&self.sensor, law, release_m);
        shown.into_iter().map(|s| s.0).collect()
    }

    /// How many peaks there are.
    pub fn data(&self) -> usize {
        self.measured.impacts.len()
    }

    /// Root mean square of what the peaks differ by, N.
    pub fn rms_n(&self, law: Law<f64>, release_m: f64) -> f64 {
        (self.off(law, release_m).norm_squared() / self.data() as f64).sqrt()
    }

    /// Root mean square of what they may differ by, N.
    pub fn deviation_n(&self) -> f64 {
        (self.variances.iter().sum::<f64>() / self.data() as f64).sqrt()
    }
}

/// Mean and variance of the largest of independent Gaussians with these means and one deviation: the moments of
/// the density d/dx ∏ Φ((x − fᵢ)/σ).
pub(super) fn largest_of(means: &[f64], deviation: f64) -> (f64, f64) {
    const POINTS: usize = 60;
    const REACH: (f64, f64) = (-4.0, 6.0);
    let top = means.iter().fold(f64::NEG_INFINITY, |m, f| m.max(*f));
    if deviation <= 0.0 || !top.is_finite() {
        return (top, 0.0);
    }
    let near: Vec<f64> = means
        .iter()
        .map(|f| (f - top) / deviation)
        .filter(|f| *f > REACH.0 - REACH.1)
        .collect();
    let normal = |x: f64| 0.5 * libm::erfc(-x / std::f64::consts::SQRT_2);
    let below = |x: f64| near.iter().map(|f| normal(x - f)).product::<f64>();
    let width = (REACH.1 - REACH.0) / POINTS as f64;
    let (mut before, mut mean, mut square) = (0.0, 0.0, 0.0);
    for i in 0..=POINTS {
        let x = REACH.0 + width * i as f64;
        let share = below(x + 0.5 * width) - before;
        before += share;
        mean += share * x;
        square += share * x * x;
    }
    // Sheppard's correction for the cells' width.
    let variance = (square - mean * mean - width * width / 12.0).max(0.0);
    (top + deviation * mean, deviation * deviation * variance)
}
