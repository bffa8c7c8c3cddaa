//! The fit of the whole force: law and sensor together, then how far the noise alone explains what is left.

use nalgebra::DMatrix;
use rayon::prelude::*;
use shared::model::params::RigParams;

use super::Settings;
use super::contacts::Measured;
use super::least_squares::Solved;
use super::ring::{self, Ring};
use super::shape::{RingingGuess, Shape};
use super::unknowns::Unknowns;

/// Time constants of the filter, in samples, with which the search begins at the first guess of the law.
const FILTERS: [f64; 3] = [0.0, 0.8, 2.5];

/// And at the other starts.
const USUAL_FILTER: f64 = 0.5;

/// Rounds of a search from afar, and of the last one.
const ROUNDS: (usize, usize) = (14, 40);

/// What is left is more than noise when its square is this many of its standard deviations above the noise's.
const SIGNIFICANT: f64 = 4.0;

/// Samples over which what is left may hang together.
const LAGS: usize = 60;

/// What was found.
pub struct Whole<'a> {
    /// The problem, its deviation widened by [`Whole::widened`].
    pub shape: Shape<'a>,
    /// Where the least is.
    pub best: Solved,
    /// Searches begun, and how many ended at the best.
    pub starts: usize,
    /// How many of them ended at about the best cost.
    pub agreeing: usize,
    /// Models computed.
    pub evaluations: u64,
    /// What deviations were multiplied by, because what is left is more than the noise, or hangs together.
    pub widened: f64,
    /// Root mean square of what is left, N.
    pub rms_n: f64,
    /// What is left beyond noise over the force, both as root mean squares.
    pub beyond_noise: f64,
    /// The ringing.
    pub ring: Option<Ring>,
}

/// Fits the whole force; `None` if no start leads to a model.
pub fn fit<'a>(
    measured: &'a Measured,
    params: &RigParams,
    unknowns: &'a Unknowns,
    settings: &Settings,
) -> Option<Whole<'a>> {
    let still = Shape::new(measured, params, unknowns, settings, None);
    let mut found = search(still, unknowns, None)?;
    let mut ring = ring::of(measured, &found.shape.tails(&found.best.x)?);
    if let Some(seen) = &mut ring {
        let guess = RingingGuess {
            hz: seen.frequency_hz,
            decay_s: seen.decay_ms * 1e-3,
        };
        let ringing = Shape::new(measured, params, unknowns, settings, Some(guess));
        let law = &found.best.x[..unknowns.list().len()];
        let again = search(ringing, unknowns, Some(law))?;
        let evaluations = found.evaluations + again.evaluations;
        found = Found {
            evaluations,
            ..again
        };
        if let Some(swing) = found.shape.sensor(&found.best.x).swing {
            seen.frequency_hz = swing.hz;
            seen.decay_ms = swing.decay_s * 1e3;
            seen.damping_ratio = ring::damping_ratio(swing.hz, swing.decay_s);
        }
    }
    found.judged(measured, ring)
}

struct Found<'a> {
    shape: Shape<'a>,
    best: Solved,
    starts: usize,
    agreeing: usize,
    evaluations: u64,
}

/// From all starts, and from `law` if it is given.
fn search<'a>(shape: Shape<'a>, unknowns: &Unknowns, law: Option<&[f64]>) -> Option<Found<'a>> {
    let guesses = unknowns.starts();
    let mut starts: Vec<Vec<f64>> = FILTERS
        .iter()
        .map(|filter| shape.start(law.unwrap_or(&guesses[0]), *filter))
        .collect();
    starts.extend(
        guesses[1..]
            .iter()
            .map(|guess| shape.start(guess, USUAL_FILTER)),
    );
    let ended: Vec<Solved> = starts
        .par_iter()
        .filter_map(|start| shape.solve_from(start, ROUNDS.0))
        .collect();
    let mut evaluations = ended.iter().map(|s| s.evaluations).sum();
    let nearest = ended.iter().min_by(|a, b| a.cost.total_cmp(&b.cost))?;
    let mut best = shape.solve(&nearest.x, &[], ROUNDS.1)?;
    evaluations += best.evaluations;
    if nearest.cost < best.cost {
        best = nearest.clone();
    }
    let near = 1e-2 * best.cost.abs() + 0.5;
    Some(Found {
        agreeing: ended.iter().filter(|s| s.cost < best.cost + near).count(),
        starts: starts.len(),
        best,
        evaluations,
        shape,
    })
}

impl<'a> Found<'a> {
    /// How much of what is left is noise; if not all of it is, deviations are widened and the search goes on.
    fn judged(mut self, measured: &Measured, ring: Option<Ring>) -> Option<Whole<'a>> {
        let left = self.shape.left(&self.best.x)?;
        let data = self.shape.data() as f64;
        let degrees = (data - self.best.x.len() as f64).max(1.0);
        let square: f64 = left.iter().flatten().map(|r| r * r).sum();
        let variance = self.shape.deviation_n.powi(2);
        let ratio = square / degrees / variance;
        let more = ratio > 1.0 + SIGNIFICANT * (2.0 * measured.colour / degrees).sqrt();
        let colour = colour(&left).max(measured.colour);
        let widened = (if more { ratio } else { 1.0 } * colour).sqrt();
        let forces = measured_squares(measured, &self.shape);
        let beyond = (square - degrees * variance).max(0.0);
        if widened > 1.0 {
            self.shape.deviation_n *= widened;
            let again = self.shape.solve(&self.best.x, &[], ROUNDS.1)?;
            self.evaluations += again.evaluations;
            self.best = again;
        }
        Some(Whole {
            shape: self.shape,
            best: self.best,
            starts: self.starts,
            agreeing: self.agreeing,
            evaluations: self.evaluations,
            widened,
            rms_n: (square / data).sqrt(),
            beyond_noise: if more { (beyond / forces).sqrt() } else { 0.0 },
            ring,
        })
    }
}

impl Whole<'_> {
    /// The covariance of the sensor's coordinates, gain and release apart.
    pub fn sensor_covariance(&self) -> Option<DMatrix<f64>> {
        let all = self.shape.covariance(&self.best.x)?;
        let own = self.shape.sensor_coordinates();
        Some(
            all.view((own.start, own.start), (own.len(), own.len()))
                .into_owned(),
        )
    }
}

fn measured_squares(measured: &Measured, shape: &Shape) -> f64 {
    let windows = shape.windows().iter();
    windows
        .flat_map(|w| &measured.force_n[w.clone()])
        .map(|f| f * f)
        .sum()
}

/// How much more sums of these vary than those of independent numbers would.
fn colour(left: &[Vec<f64>]) -> f64 {
    let count: usize = left.iter().map(Vec::len).sum();
    let square = |lag: usize| -> f64 {
        let one =
            |r: &Vec<f64>| -> f64 { r.iter().zip(r.iter().skip(lag)).map(|(a, b)| a * b).sum() };
        left.iter().map(one).sum()
    };
    let whole = square(0);
    let mut colour = 1.0;
    if whole > 0.0 {
        for lag in 1..LAGS {
            let tie = square(lag) / whole;
            if tie < 3.0 / (count as f64).sqrt() {
                break;
            }
            colour += 2.0 * tie;
        }
    }
    colour
}
