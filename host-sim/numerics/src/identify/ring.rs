//! The surface's ringing: what the force record shows after the release and the model, whose surface is rigid (section
//! 3.3.2), does not. Here it is looked for; the shape of the force fits it together with the contact.

use std::f64::consts::TAU;

use nalgebra::DVector;
use serde::Serialize;

use super::contacts::MeasuredImpacts;
use super::least_squares::{self, Problem};
use super::sensor::damped;

/// The square that a swing must take from the tails, in variances of a sample: of the frequencies tried, noise gives one
/// some 20.
const SIGNIFICANT: f64 = 40.0;

/// The damped swing must take at least this share of what the tails hold beyond noise to be called one.
const LEAST_SHARE: f64 = 0.25;

/// Frequencies tried, Hz, and time constants, s.
const LOWEST_HZ: f64 = 300.0;
const HIGHEST_HZ: f64 = 20_000.0;
const DECAYS_S: [f64; 4] = [0.4e-3, 1e-3, 2.5e-3, 6e-3];

/// Time constants that are sought, s.
const SHORTEST_S: f64 = 1e-4;
const LONGEST_S: f64 = 0.1;

/// How far a logarithm is moved for its derivative.
const NUDGE: f64 = 1e-6;

/// A damped swing a exp(−t/τ) sin(2πft + φ) after each release.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ring {
    /// Frequency f, Hz.
    pub frequency_hz: f64,
    /// Time constant τ of its decay, ms.
    pub decay_ms: f64,
    /// Share of critical damping.
    pub damping_ratio: f64,
    /// Amplitude at the first release over the first peak.
    pub share_at_release: f64,
    /// How much of the square after release it explains, 0 to 1.
    pub explained: f64,
}

/// One impact's tail: times since release and what is left of the force when the model is taken off.
pub struct Tail {
    /// Since the release, s.
    pub time_s: Vec<f64>,
    /// Measured force less what model and sensor show at these times, N.
    pub force_n: Vec<f64>,
}

/// Time after release that is analysed, s.
pub const SPAN_S: f64 = 8e-3;

/// The ringing in `tails`; none if what is there is noise.
pub fn of(measured: &MeasuredImpacts, tails: &[Tail]) -> Option<Ring> {
    let all: f64 = tails.iter().flat_map(|t| &t.force_n).map(|f| f * f).sum();
    let samples = tails.iter().map(|t| t.force_n.len()).sum::<usize>() as f64;
    let noise = measured.noise_n.powi(2);
    let largest = measured.impacts.first()?.peak_n;
    let least = (SIGNIFICANT * noise * measured.colour).max(samples * (1e-4 * largest).powi(2));
    // Less than noise makes of it at most.
    let likely = noise * measured.colour * (samples + 2.0 * (2.0 * samples).sqrt());
    if samples < 30.0 || all < least.max(likely) {
        return None;
    }
    let fastest = HIGHEST_HZ.min(0.4 / measured.sample_s);
    let problem = Swings {
        tails,
        fastest,
        // The search ends where a round gains less than a thousandth of a residual's square, or of their sum.
        unit_n: (1e-6 * all).sqrt(),
    };
    // A tail of 8 ms distinguishes frequencies 60 Hz apart; so many are tried.
    let count = ((fastest - LOWEST_HZ) / 40.0) as usize;
    let tried = (0..count).flat_map(|i| {
        let hz = LOWEST_HZ + 40.0 * (i as f64 + 0.5);
        DECAYS_S.map(|decay| vec![hz.ln(), decay.ln()])
    });
    let scored = tried.map(|x| (problem.left(&x).norm_squared(), x));
    let start = scored.min_by(|a, b| a.0.total_cmp(&b.0))?.1;
    let found = least_squares::solve(&problem, &start, &[], 40)?;
    let (hz, decay_s) = (found.x[0].exp(), found.x[1].exp());
    let explained_here = all * (1.0 - 1e-6 * found.cost);
    let beyond_noise = (all - noise * samples).max(1e-12 * all);
    if explained_here < least || explained_here < LEAST_SHARE * beyond_noise {
        return None;
    }
    Some(Ring {
        frequency_hz: hz,
        decay_ms: decay_s * 1e3,
        damping_ratio: damping_ratio(hz, decay_s),
        share_at_release: {
            let [cos_n, sin_n] = swing(tails.first()?, hz, decay_s);
            cos_n.hypot(sin_n) / largest
        },
        explained: explained_here / all,
    })
}

/// The share of critical damping of a swing of this frequency and time constant.
pub fn damping_ratio(hz: f64, decay_s: f64) -> f64 {
    let rate = TAU * hz * decay_s;
    1.0 / (1.0 + rate * rate).sqrt()
}

/// The tails over the logarithms of frequency and time constant: residuals are what the best damped swing leaves.
struct Swings<'a> {
    tails: &'a [Tail],
    /// Highest frequency searched, Hz.
    fastest: f64,
    /// What residuals are counted in, N.
    unit_n: f64,
}

impl Swings<'_> {
    fn left(&self, x: &[f64]) -> DVector<f64> {
        let (hz, decay_s) = (x[0].exp(), x[1].exp());
        let of = |tail: &Tail| {
            let [cos_n, sin_n] = swing(tail, hz, decay_s);
            let pairs = tail.time_s.iter().zip(&tail.force_n);
            let left = pairs.map(|(t, force_n)| {
                let [cos, sin] = damped(*t, hz, decay_s);
                (force_n - cos_n * cos - sin_n * sin) / self.unit_n
            });
            left.collect::<Vec<_>>()
        };
        DVector::from_vec(self.tails.iter().flat_map(of).collect())
    }
}

impl Problem for Swings<'_> {
    type Seen = ();

    fn residuals(&self, x: &[f64]) -> Option<(DVector<f64>, ())> {
        Some((self.left(x), ()))
    }

    fn column(&self, x: &[f64], at: &(DVector<f64>, ()), k: usize) -> Option<DVector<f64>> {
        let mut moved = x.to_vec();
        moved[k] += NUDGE;
        Some((self.left(&moved) - &at.0) / NUDGE)
    }

    fn range(&self, _: &[f64], k: usize) -> (f64, f64) {
        match k {
            0 => (LOWEST_HZ.ln(), self.fastest.ln()),
            _ => (SHORTEST_S.ln(), LONGEST_S.ln()),
        }
    }
}

/// How much of a damped cosine and sine of this pitch and decay fits a tail best, N; none of it where it has hardly a sample.
fn swing(tail: &Tail, hz: f64, decay_s: f64) -> [f64; 2] {
    let (mut cc, mut cs, mut ss, mut cf, mut sf) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (t, f) in tail.time_s.iter().zip(&tail.force_n) {
        let [c, s] = damped(*t, hz, decay_s);
        cc += c * c;
        cs += c * s;
        ss += s * s;
        cf += c * f;
        sf += s * f;
    }
    let determinant = cc * ss - cs * cs;
    if determinant <= 1e-12 * cc * ss {
        return [0.0; 2];
    }
    [
        (cf * ss - sf * cs) / determinant,
        (sf * cc - cf * cs) / determinant,
    ]
}
