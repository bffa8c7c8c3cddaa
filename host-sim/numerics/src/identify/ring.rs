//! The surface's ringing: what the force record shows after the release. Reported, not fitted: the model
//! has a rigid surface (section 3.3.2).

use std::f64::consts::TAU;

use serde::Serialize;
use shared::model::params::RigParams;

use super::contacts::Measured;
use super::search::nelder_mead;
use super::{Aligned, Fit, Likeness, Misfit};

/// Time after release that is analysed, s.
const SPAN_S: f64 = 8e-3;

/// The damped swing must take at least this share of the record's square there to be called one.
const LEAST_SHARE: f64 = 0.25;

/// Frequencies tried, Hz, and time constants, s.
const LOWEST_HZ: f64 = 300.0;
const HIGHEST_HZ: f64 = 20_000.0;
const DECAYS_S: [f64; 4] = [0.4e-3, 1e-3, 2.5e-3, 6e-3];

/// A damped swing a exp(−t/τ) sin(2πft + φ) after each release.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ring {
    /// f, Hz.
    pub frequency_hz: f64,
    /// τ, ms.
    pub decay_ms: f64,
    /// Share of critical damping.
    pub damping_ratio: f64,
    /// Amplitude at the first release over the first peak.
    pub share_at_release: f64,
    /// How much of the square after release it explains, 0 to 1.
    pub explained: f64,
}

/// One impact's tail: times since release and force.
struct Tail {
    time_s: Vec<f64>,
    force_n: Vec<f64>,
}

/// The ringing after the releases that `fit` puts into the record; none if what is there is noise.
pub fn of(measured: &Measured, params: &RigParams, fit: &Fit) -> Option<Ring> {
    let likeness = Likeness::new(measured, params, Misfit::Force);
    let seen = likeness.aligned(fit.found, fit.release_m);
    let tails: Vec<Tail> = measured
        .impacts
        .iter()
        .zip(&seen)
        .filter_map(|(impact, model)| tail(measured, impact.window.start, model))
        .collect();
    let all: f64 = tails.iter().flat_map(|t| &t.force_n).map(|f| f * f).sum();
    let samples: usize = tails.iter().map(|t| t.force_n.len()).sum();
    // Nothing there but noise: the square is what noise makes of it.
    let noise = measured.noise_n.powi(2) * samples as f64;
    let largest = fit.impacts.first()?.measured_peak_n;
    if samples < 30 || all < 2.0 * noise || all < samples as f64 * (1e-4 * largest).powi(2) {
        return None;
    }
    let fastest = HIGHEST_HZ.min(0.4 / measured.sample_s);
    let left = |x: &[f64]| {
        let (hz, decay_s) = (x[0].exp(), x[1].exp());
        if !(hz > LOWEST_HZ && hz < fastest && decay_s > 1e-4 && decay_s < 0.1) {
            return all;
        }
        all - tails
            .iter()
            .map(|t| explained(t, hz, decay_s).0)
            .sum::<f64>()
    };
    // A tail of 8 ms distinguishes frequencies 60 Hz apart; so many are tried.
    let count = ((fastest - LOWEST_HZ) / 40.0) as usize;
    let tried = (0..count).flat_map(|i| {
        let hz = LOWEST_HZ + 40.0 * (i as f64 + 0.5);
        DECAYS_S.map(|decay| vec![hz.ln(), decay.ln()])
    });
    let start = tried.min_by(|a, b| left(a).total_cmp(&left(b)))?;
    let found = nelder_mead(&left, &start, &[0.01, 0.3], 1e-9 * all, 200);
    let (hz, decay_s) = (found.x[0].exp(), found.x[1].exp());
    let share = 1.0 - found.cost / all;
    if share < LEAST_SHARE {
        return None;
    }
    let rate = TAU * hz * decay_s;
    Some(Ring {
        frequency_hz: hz,
        decay_ms: decay_s * 1e3,
        damping_ratio: 1.0 / (1.0 + rate * rate).sqrt(),
        share_at_release: explained(tails.first()?, hz, decay_s).1 / largest,
        explained: share,
    })
}

fn tail(measured: &Measured, from: usize, model: &Aligned) -> Option<Tail> {
    let contact = model.course.as_ref()?.contact;
    let release = model.onset_s + contact.duration_s;
    let times = &measured.time_s[from..];
    // The release of the law may be a little early or late: a tenth of the contact is left out.
    let first = from + times.partition_point(|t| *t < release + 0.1 * contact.duration_s);
    let end = from + times.partition_point(|t| *t < release + SPAN_S);
    if end < first + 10 {
        return None;
    }
    Some(Tail {
        time_s: measured.time_s[first..end]
            .iter()
            .map(|t| t - release)
            .collect(),
        force_n: measured.force_n[first..end].to_vec(),
    })
}

/// The square that the best damped swing of this pitch and decay takes from a tail, N², and its amplitude at the
/// release, N.
fn explained(tail: &Tail, hz: f64, decay_s: f64) -> (f64, f64) {
    let (mut cc, mut cs, mut ss, mut cf, mut sf) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (t, f) in tail.time_s.iter().zip(&tail.force_n) {
        let size = (-t / decay_s).exp();
        let (sin, cos) = (TAU * hz * t).sin_cos();
        let (c, s) = (size * cos, size * sin);
        cc += c * c;
        cs += c * s;
        ss += s * s;
        cf += c * f;
        sf += s * f;
    }
    let determinant = cc * ss - cs * cs;
    if determinant <= 1e-12 * cc * ss {
        return (0.0, 0.0);
    }
    let a = (cf * ss - sf * cs) / determinant;
    let b = (sf * cc - cf * cs) / determinant;
    (a * cf + b * sf, a.hypot(b))
}
