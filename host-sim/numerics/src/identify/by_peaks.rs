//! A fit by the peaks, with the sensor as the whole force shows it.

use shared::model::params::RigParams;

use nalgebra::DVector;

use super::by_force::{PROFILE_ROUNDS, fitted};
use super::contacts::MeasuredImpacts;
use super::least_squares::{self, Problem, Solved};
use super::peaks::Peaks;
use super::profile;
use super::unknowns::Unknowns;
use super::whole::{ROUNDS, Whole};
use super::{IdentifiedFit, ImpactRow, Misfit};

/// The peaks as residuals.
struct ByPeaks<'a> {
    peaks: Peaks<'a>,
    unknowns: &'a Unknowns,
}

impl Problem for ByPeaks<'_> {
    type Seen = ();

    fn residuals(&self, x: &[f64]) -> Option<(DVector<f64>, ())> {
        let (law, release_m) = self.unknowns.read(x)?;
        Some((self.peaks.residuals(law, release_m)?, ()))
    }

    fn column(&self, x: &[f64], at: &(DVector<f64>, ()), k: usize) -> Option<DVector<f64>> {
        let size = 1e-4 * self.unknowns.list()[k].step;
        let (_, high) = self.range(x, k);
        let by = if x[k] + size > high { -size } else { size };
        let mut moved = x.to_vec();
        moved[k] += by;
        Some((self.residuals(&moved)?.0 - &at.0) / by)
    }

    fn range(&self, _: &[f64], k: usize) -> (f64, f64) {
        self.unknowns.list()[k].range
    }
}

/// The law with which the peaks are most like the measured ones, with intervals.
pub fn fit(
    measured: &MeasuredImpacts,
    params: &RigParams,
    unknowns: &Unknowns,
    whole: &Whole,
) -> Option<IdentifiedFit> {
    let laws = unknowns.list().len();
    let about = whole.best.x[..laws].to_vec();
    // The covariance of the peaks is about a point.
    let about_point = |x: &[f64]| {
        let peaks = Peaks::new(measured, params, whole, unknowns.read(x)?)?;
        Some(ByPeaks { peaks, unknowns })
    };
    let first = about_point(&about)?;
    let mut starts = unknowns.starts();
    starts.push(about);
    let searched = least_squares::from_all(
        &starts,
        |x| least_squares::solve(&first, x, &[], ROUNDS.0),
        |x| least_squares::solve(&first, x, &[], ROUNDS.1),
    )?;
    // The covariance anew, about what the peaks say.
    let problem = about_point(&searched.best.x)?;
    let peaks = &problem.peaks;
    let least = |x: &[f64], held: &[usize]| {
        let solved = least_squares::solve(&problem, x, held, PROFILE_ROUNDS);
        solved.unwrap_or_else(|| Solved::nowhere(x))
    };
    let mut best = least(&searched.best.x, &[]);
    let degrees = peaks.data().saturating_sub(laws);
    let widened = widened(best.cost, degrees);
    let per_cost = if whole.intervals {
        widened * widened
    } else {
        f64::INFINITY
    };
    let (profiles, sought) = profile::all(&least, unknowns, &mut best, per_cost);
    let (found, release_m) = unknowns.read(&best.x)?;
    // The whole force with the law that the peaks chose, for the pictures.
    let mut x = whole.best.x.clone();
    x[..laws].copy_from_slice(&best.x);
    let held: Vec<usize> = (0..x.len() - measured.impacts.len()).collect();
    let shape = &whole.shape;
    let x = shape.solve(&x, &held, PROFILE_ROUNDS).map_or(x, |s| s.x);
    let fit = fitted(measured, whole, &x, found, (profiles, sought))?;
    let means = peaks.means(found, release_m);
    let impacts = fit.impacts.into_iter().zip(means);
    let with_its_peak = |(impact, model_peak_n)| ImpactRow {
        model_peak_n,
        residual_n: f64::NAN,
        ..impact
    };
    Some(IdentifiedFit {
        misfit: Misfit::Peaks,
        rms_n: peaks.rms_n(found, release_m),
        noise_n: peaks.deviation_n(),
        degrees_of_freedom: degrees,
        widened,
        starts: starts.len(),
        starts_agreeing: searched.agreeing(),
        simulations: searched.evaluations + fit.simulations,
        release_m,
        impacts: impacts.map(with_its_peak).collect(),
        ..fit
    })
}

/// What deviations are multiplied by when χ² is larger than chance makes it.
fn widened(cost: f64, degrees: usize) -> f64 {
    /// χ² this many of its standard deviations above its mean is not chance.
    const SIGNIFICANT: f64 = 4.0;
    let degrees = degrees as f64;
    if degrees == 0.0 {
        return 1.0;
    }
    let ratio = cost / degrees;
    if ratio > 1.0 + SIGNIFICANT * (2.0 / degrees).sqrt() {
        ratio.sqrt()
    } else {
        1.0
    }
}
