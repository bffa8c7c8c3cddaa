//! The fit of the whole force: law and sensor together, then how far the noise alone explains what is left.

use nalgebra::DMatrix;
use shared::model::params::RigParams;

use super::SearchSettings;
use super::by_force::REFUSED_SHARE;
use super::contacts::MeasuredImpacts;
use super::least_squares::{self, Solved};
use super::quiet::correlated;
use super::ring::{self, Ring};
use super::sensor::FilterKind;
use super::shape::{ForceShape, RingingGuess};
use super::unknowns::Unknowns;

/// Rounds of a search from afar, and of the last one.
pub const ROUNDS: (usize, usize) = (14, 40);

/// What is left is more than noise when its square is this many of its standard deviations above the noise's.
const SIGNIFICANT: f64 = 4.0;

/// Where more than this many times the noise is left, what makes it is not known, and there are no intervals.
const MOST_TIMES: f64 = 2.0;

/// A digital filter of a spring-dashpot's force has a least for each space between samples that the onsets may lie in: all
/// of them are moved by so many.
const SHIFTS: [f64; 4] = [-1.0, 1.0, -2.0, 2.0];

/// Samples over which what is left may hang together.
const LAGS: usize = 60;

/// The best fit of law and sensor to the whole force, and how far noise explains what is left.
pub struct Whole<'a> {
    /// The problem, its deviation widened by [`Whole::widened`].
    pub shape: ForceShape<'a>,
    /// Where the least is.
    pub best: Solved,
    /// Searches begun, each from another start.
    pub starts: usize,
    /// How many of them ended at about the best cost.
    pub agreeing: usize,
    /// Residuals and derivatives computed in all searches.
    pub evaluations: u64,
    /// What deviations were multiplied by, because what is left is more than the noise, or hangs together.
    pub widened: f64,
    /// Root mean square of what is left, N.
    pub rms_n: f64,
    /// What is left over the noise, both as root mean squares.
    pub times_noise: f64,
    /// Whether intervals mean something: the law fits, and no more than [`MOST_TIMES`] the noise is left.
    pub intervals: bool,
    /// What is left beyond noise over the force, both as root mean squares.
    pub beyond_noise: f64,
    /// The surface's ringing; none where what is left shows none.
    pub ring: Option<Ring>,
}

/// Fits the whole force; `None` if no start leads to a model.
pub fn fit<'a>(
    measured: &'a MeasuredImpacts,
    params: &RigParams,
    unknowns: &'a Unknowns,
    settings: &SearchSettings,
) -> Option<Whole<'a>> {
    let with =
        |model, ringing| ForceShape::new(measured, params, unknowns, settings, model, ringing);
    let mut best = ringing(measured, unknowns, &with, FilterKind::Analog, None)?;
    let law = best.0.best.x[..unknowns.list().len()].to_vec();
    for model in FilterKind::OTHERS {
        if best.0.ratio()? < best.0.likely(measured, 1.0) {
            break;
        }
        let Some(other) = ringing(measured, unknowns, &with, model, Some(&law)) else {
            continue;
        };
        let evaluations = best.0.evaluations + other.0.evaluations;
        if other.0.best.cost < best.0.best.cost {
            best = other;
        }
        best.0.evaluations = evaluations;
    }
    best.0.judged(measured, best.1)
}

/// The best with a kind of filter, first without ringing and, if what is left shows some, with it; from `law` only if that
/// is given.
fn ringing<'a>(
    measured: &'a MeasuredImpacts,
    unknowns: &'a Unknowns,
    with: &impl Fn(FilterKind, Option<RingingGuess>) -> ForceShape<'a>,
    model: FilterKind,
    law: Option<&[f64]>,
) -> Option<(Found<'a>, Option<Ring>)> {
    let mut found = search(with(model, None), unknowns, law)?;
    let mut ring = ring::of(measured, &found.shape.tails(&found.best.x)?);
    if let Some(seen) = &mut ring {
        let guess = RingingGuess {
            hz: seen.frequency_hz,
            decay_s: seen.decay_ms * 1e-3,
        };
        let nearby = &found.best.x[..unknowns.list().len()];
        let again = search(with(model, Some(guess)), unknowns, Some(nearby))?;
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
    Some((found, ring))
}

struct Found<'a> {
    shape: ForceShape<'a>,
    best: Solved,
    starts: usize,
    agreeing: usize,
    evaluations: u64,
}

/// From all starts, and from `law` if it is given.
fn search<'a>(
    shape: ForceShape<'a>,
    unknowns: &Unknowns,
    law: Option<&[f64]>,
) -> Option<Found<'a>> {
    let guesses = unknowns.starts();
    let filters = shape.model.starts();
    let mut starts: Vec<Vec<f64>> = filters
        .iter()
        .map(|filter| shape.start(law.unwrap_or(&guesses[0]), filter))
        .collect();
    if shape.model == FilterKind::Analog {
        let usual = starts.len() - 1;
        starts.truncate(usual);
        let others = guesses[1..].iter();
        starts.extend(others.map(|guess| shape.start(guess, filters[usual])));
    }
    let mut searched = least_squares::from_all(
        &starts,
        |x| shape.solve_from(x, ROUNDS.0),
        |x| shape.solve(x, &[], ROUNDS.1),
    )?;
    if shape.model != FilterKind::Analog && shape.jumps(&searched.best.x) {
        for by in SHIFTS {
            let moved = shape.solve(&shape.shifted(&searched.best.x, by), &[], ROUNDS.0)?;
            searched.evaluations += moved.evaluations;
            searched.best = searched.best.or_better(moved);
        }
    }
    Some(Found {
        agreeing: searched.agreeing(),
        starts: starts.len(),
        best: searched.best,
        evaluations: searched.evaluations,
        shape,
    })
}

impl<'a> Found<'a> {
    /// What is left over what noise leaves, as squares.
    fn ratio(&self) -> Option<f64> {
        let left = self.shape.left(&self.best.x)?;
        let square: f64 = left.iter().flatten().map(|r| r * r).sum();
        Some(square / self.degrees() / self.shape.deviation_n.powi(2))
    }

    fn degrees(&self) -> f64 {
        (self.shape.data() as f64 - self.best.x.len() as f64).max(1.0)
    }

    /// Noise makes that ratio no larger, but for chance of so many standard deviations.
    fn likely(&self, measured: &MeasuredImpacts, deviations: f64) -> f64 {
        1.0 + deviations * (2.0 * measured.colour / self.degrees()).sqrt()
    }

    /// How much of what is left is noise; if not all of it is, deviations are widened and the search goes on.
    fn judged(mut self, measured: &MeasuredImpacts, ring: Option<Ring>) -> Option<Whole<'a>> {
        let left = self.shape.left(&self.best.x)?;
        let data = self.shape.data() as f64;
        let degrees = self.degrees();
        let square: f64 = left.iter().flatten().map(|r| r * r).sum();
        let variance = self.shape.deviation_n.powi(2);
        let ratio = square / degrees / variance;
        let more = ratio > self.likely(measured, SIGNIFICANT);
        let colour = colour(&left).max(measured.colour);
        let widened = (if more { ratio } else { 1.0 } * colour).sqrt();
        let windows = self.shape.windows.iter();
        let forces = windows.flat_map(|w| &measured.force_n[w.clone()]);
        let forces: f64 = forces.map(|f| f * f).sum();
        let beyond = (square - degrees * variance).max(0.0);
        if widened > 1.0 {
            self.shape.deviation_n *= widened;
            let again = self.shape.solve(&self.best.x, &[], ROUNDS.1)?;
            self.evaluations += again.evaluations;
            self.best = again;
        }
        let beyond_noise = if more { (beyond / forces).sqrt() } else { 0.0 };
        // Without noise there is nothing to compare with.
        let explained = measured.noise_n == 0.0 || ratio <= MOST_TIMES * MOST_TIMES;
        Some(Whole {
            shape: self.shape,
            best: self.best,
            starts: self.starts,
            agreeing: self.agreeing,
            evaluations: self.evaluations,
            widened,
            rms_n: (square / data).sqrt(),
            times_noise: ratio.sqrt(),
            intervals: explained && beyond_noise <= REFUSED_SHARE,
            beyond_noise,
            ring,
        })
    }
}

impl Whole<'_> {
    /// The covariance of the sensor's coordinates, gain and release apart.
    pub fn sensor_covariance(&self) -> Option<DMatrix<f64>> {
        let all = least_squares::covariance(&self.shape, &self.best.x)?;
        let own = self.shape.sensor_coordinates();
        Some(
            all.view((own.start, own.start), (own.len(), own.len()))
                .into_owned(),
        )
    }
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
    if whole > 0.0 {
        correlated(LAGS, count as f64, whole, square)
    } else {
        1.0
    }
}
