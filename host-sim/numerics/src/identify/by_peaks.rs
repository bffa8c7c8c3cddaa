//! A fit by the peaks, with the sensor as the whole force shows it.

use shared::model::contact::LawKind;
use shared::model::params::RigParams;

use super::by_force::{PROFILE_ROUNDS, REFUSED_SHARE, impact_rows};
use super::contacts::MeasuredImpacts;
use super::peaks::Peaks;
use super::profile::{self, Landscape};
use super::search::{self, SearchEnd};
use super::unknowns::Unknowns;
use super::whole::Whole;
use super::{IdentifiedFit, Misfit, SensorFound};

/// The peaks as χ².
struct ByPeaks<'a> {
    peaks: &'a Peaks<'a>,
    unknowns: &'a Unknowns,
}

impl ByPeaks<'_> {
    fn cost(&self, x: &[f64]) -> f64 {
        match self.unknowns.read(x) {
            Some((law, release_m)) => self.peaks.cost(law, release_m),
            None => self.unknowns.beyond(x),
        }
    }
}

impl Landscape for ByPeaks<'_> {
    fn least(&self, x: &[f64], held: &[usize], moved: f64) -> SearchEnd {
        let free: Vec<usize> = (0..x.len()).filter(|k| !held.contains(k)).collect();
        let with = |others: &[f64]| {
            let mut all = x.to_vec();
            free.iter().zip(others).for_each(|(k, o)| all[*k] = *o);
            all
        };
        if free.is_empty() {
            return SearchEnd {
                x: x.to_vec(),
                cost: self.cost(x),
                evaluations: 1,
            };
        }
        let start: Vec<f64> = free.iter().map(|k| x[*k]).collect();
        let small = free.iter().map(|k| 0.1 * self.unknowns.steps()[*k]);
        let steps: Vec<f64> = match held.is_empty() {
            true => small.collect(),
            false => small.map(|s| s.min(moved.max(1e-4 * s))).collect(),
        };
        let inner = |others: &[f64]| self.cost(&with(others));
        let found = search::nelder_mead(&inner, &start, &steps, 1e-3, 60);
        SearchEnd {
            x: with(&found.x),
            ..found
        }
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
    let first = Peaks::new(measured, params, whole, unknowns.read(&about)?)?;
    let cost = |x: &[f64]| {
        ByPeaks {
            peaks: &first,
            unknowns,
        }
        .cost(x)
    };
    let mut starts = unknowns.starts();
    starts.push(about);
    let searched = search::from_all(&cost, &starts, unknowns.steps())?;
    // The covariance anew, about what the peaks say.
    let peaks = Peaks::new(measured, params, whole, unknowns.read(&searched.best.x)?)?;
    let landscape = ByPeaks {
        peaks: &peaks,
        unknowns,
    };
    let mut best = landscape.least(&searched.best.x, &[], 0.0);
    let degrees = peaks.data().saturating_sub(laws);
    let widened = widened(best.cost, degrees);
    let per_cost = if whole.intervals {
        widened * widened
    } else {
        f64::INFINITY
    };
    let (profiles, sought) = profile::all(&landscape, unknowns, &mut best, per_cost);
    let (found, release_m) = unknowns.read(&best.x)?;
    // The whole force with the law that the peaks chose, for the pictures.
    let mut x = whole.best.x.clone();
    x[..laws].copy_from_slice(&best.x);
    let held: Vec<usize> = (0..x.len() - measured.impacts.len()).collect();
    let shape = &whole.shape;
    let x = shape.solve(&x, &held, PROFILE_ROUNDS).map_or(x, |s| s.x);
    Some(IdentifiedFit {
        law: LawKind::SpringDashpot,
        misfit: Misfit::Peaks,
        refused: whole.beyond_noise > REFUSED_SHARE,
        intervals: whole.intervals,
        times_noise: whole.times_noise,
        misses_share: whole.beyond_noise,
        rms_n: peaks.rms_n(found, release_m),
        noise_n: peaks.deviation_n(),
        parameters: profiles.iter().map(|p| p.estimate.clone()).collect(),
        degrees_of_freedom: degrees,
        widened,
        starts: searched.starts,
        starts_agreeing: searched.agreeing,
        simulations: searched.evaluations + whole.evaluations + sought,
        sensor: SensorFound::new(&shape.sensor(&x), measured),
        impacts: impact_rows(measured, shape, &x, Some(&peaks.means(found, release_m)))?,
        warnings: Vec::new(),
        ring: whole.ring,
        found,
        release_m,
        shown: shape.shown(&x, &shape.contacts(&x)?),
        profiles,
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
