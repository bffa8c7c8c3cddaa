//! Lyapunov exponents of a trajectory, through its contacts.
//!
//! The derivative of one drive period comes from the reference in [`Dual`] numbers: where a switch falls, the instant
//! carries derivatives too, which is the saltation at contacts (P. C. Müller, "Calculation of Lyapunov exponents for
//! dynamic systems with discontinuities", Chaos, Solitons & Fractals 5, 1671–1681, 1995,
//! doi:10.1016/0960-0779(94)00170-U). After every period the two directions are made orthonormal again and their growth
//! is booked (G. Benettin et al., "Lyapunov characteristic exponents for smooth dynamical systems", Meccanica 15, 9–20
//! and 21–30, 1980, doi:10.1007/BF02128236).

use serde::Serialize;
use shared::model::params::RigParams;

use crate::dual::Dual;
use crate::engine::check_frequency;
use crate::error::{Error, MotionError};
use crate::reference::Reference;

/// How long to follow a trajectory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LyapunovSpan {
    /// Drive periods before the first that counts; the directions turn with the flow meanwhile.
    pub transient: u32,
    /// Drive periods that count, at least [`BLOCKS`].
    pub periods: u32,
}

/// The standard error is computed from the spread of this many equal stretches of the trajectory.
pub const BLOCKS: u32 = 20;

/// The two largest exponents of a trajectory: with a prescribed cart there are no more, with one that recoils there are two
/// more, of its deviation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Exponents {
    /// The largest exponent, 1/s: positive in chaos, 0 on a quasi-periodic motion, negative on a periodic one.
    pub largest_per_s: f64,
    /// Its standard error, 1/s, from the means of [`BLOCKS`] stretches.
    pub standard_error_per_s: f64,
    /// The second, 1/s. None where it is lost in rounding beside the largest, as in a sustained contact.
    pub other_per_s: Option<f64>,
    /// Largest exponent in nats per drive period.
    pub largest_per_period: f64,
    /// Drive periods that counted.
    pub periods: u32,
}

impl Exponents {
    /// What the sign says, at three standard errors: "chaotic", "contracting", or "undecided" (as on a quasi-periodic
    /// motion, or too near 0 for the periods run).
    pub fn meaning(&self) -> &'static str {
        // A periodic orbit's blocks differ by rounding alone; so small an exponent is 0.
        const ZERO_PER_PERIOD: f64 = 1e-4;
        let margin = 3.0 * self.standard_error_per_s;
        if self.largest_per_period.abs() < ZERO_PER_PERIOD {
            "undecided"
        } else if self.largest_per_s > margin {
            "chaotic"
        } else if self.largest_per_s < -margin {
            "contracting"
        } else {
            "undecided"
        }
    }
}

/// The exponents of the trajectory of `params` at `frequency_hz` (Hz) that begins on `section` (coordinate and rate
/// at drive phase 0), with the cart on its course.
///
/// # Errors
/// If a parameter, the frequency or the number of periods is out of range, if the hammer leaves what the model
/// describes, or if the derivative of a drive period underflows, as in sustained contact over whole periods.
pub fn exponents(
    params: &RigParams,
    frequency_hz: f64,
    section: [f64; 2],
    plan: LyapunovSpan,
) -> Result<Exponents, Error> {
    check_frequency(frequency_hz, params)?;
    let (q, v) = seeds(section);
    let carrier = Reference::<Dual<2>>::new(params, frequency_hz, q, v)?;
    grow(carrier, params, frequency_hz, plan)
}

/// [`exponents`] for the smoothing method of width `epsilon_m` (m), where no direction jumps.
///
/// # Errors
/// As [`exponents`] and [`Reference::smoothed`].
pub fn of_smoothed(
    params: &RigParams,
    frequency_hz: f64,
    epsilon_m: f64,
    section: [f64; 2],
    plan: LyapunovSpan,
) -> Result<Exponents, Error> {
    check_frequency(frequency_hz, params)?;
    let carrier = Reference::smoothed(params, frequency_hz, epsilon_m, seeds(section))?;
    grow(carrier, params, frequency_hz, plan)
}

fn seeds([q, v]: [f64; 2]) -> (Dual<2>, Dual<2>) {
    (Dual::variable(q, 0), Dual::variable(v, 1))
}

fn grow(
    mut carrier: Reference<Dual<2>>,
    params: &RigParams,
    frequency_hz: f64,
    plan: LyapunovSpan,
) -> Result<Exponents, Error> {
    let scale = carrier.rig().coordinate_scale();
    let omega = std::f64::consts::TAU * frequency_hz;
    let amplitude = params.amplitude_m;
    let units = [scale, scale * omega, amplitude, amplitude * omega];
    if plan.periods < BLOCKS {
        return Err(Error::LyapunovPeriods {
            periods: plan.periods,
            least: BLOCKS,
        });
    }
    // The seeds are 1 in the rig's own units: turned into A0 and A0 Ω before anything runs.
    carrier.redirect(|x| Dual {
        re: x.re,
        eps: [x.eps[0] * units[0], x.eps[1] * units[1]],
    });
    let mut booked = Vec::with_capacity(plan.periods as usize);
    for k in 0..plan.transient + plan.periods {
        carrier.run_period(&mut ());
        let ((q, v), [e, w]) = (carrier.state(), carrier.cart());
        let state = [q, v, e, w];
        let y = [0, 1, 2, 3].map(|i| state[i].eps.map(|e| e / units[i]));
        let Some((growth, back)) = triangle(&y) else {
            return Err(lost(state[0].re, frequency_hz));
        };
        carrier.redirect(|x| Dual {
            re: x.re,
            eps: [x.eps[0] * back[0], x.eps[0] * back[1] + x.eps[1] * back[2]],
        });
        if k >= plan.transient {
            booked.push(growth);
        }
    }
    Ok(settle(&booked, frequency_hz))
}

fn lost(q: f64, frequency_hz: f64) -> Error {
    if q.is_finite() {
        MotionError::Forgotten { frequency_hz }.into()
    } else {
        MotionError::LostTangent { frequency_hz }.into()
    }
}

/// Below this share of the larger growth the smaller is made of rounding.
const ROUNDING: f64 = 1e-12;

/// ln of the two diagonal entries of R in Y = Q R (the second none where rounding has it), and the entries 11, 12 and
/// 22 of its inverse. `None` if the first is no positive number.
fn triangle(y: &[[f64; 2]; 4]) -> Option<([Option<f64>; 2], [f64; 3])> {
    let length = |k: usize| y.iter().fold(0.0_f64, |sum, row| sum.hypot(row[k]));
    let first = length(0);
    if !(first > f64::MIN_POSITIVE && first.is_finite()) {
        return None;
    }
    let across = y.iter().map(|[a, b]| a * b).sum::<f64>() / first;
    let pairs = (0..4).flat_map(|i| (0..i).map(move |k| (y[k], y[i])));
    let area = pairs.fold(0.0_f64, |sum, ([a, b], [c, d])| sum.hypot(a * d - b * c));
    let second = area / first;
    let size = first.hypot(length(1));
    // The smaller direction is kept alive whatever it is, or it could never grow again.
    let held = second.max(ROUNDING * size);
    let other = (second > ROUNDING * size).then(|| second.ln());
    let back = [1.0 / first, -across / (first * held), 1.0 / held];
    Some(([Some(first.ln()), other], back))
}

/// Means and standard error of what was booked per period.
fn settle(booked: &[[Option<f64>; 2]], frequency_hz: f64) -> Exponents {
    let largest: Vec<f64> = booked.iter().filter_map(|g| g[0]).collect();
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let blocks = largest.chunks_exact(largest.len() / BLOCKS as usize);
    let means: Vec<f64> = blocks.take(BLOCKS as usize).map(mean).collect();
    let centre = mean(&means);
    let spread = means.iter().map(|m| (m - centre).powi(2)).sum::<f64>();
    let count = f64::from(BLOCKS);
    let other: Option<Vec<f64>> = booked.iter().map(|g| g[1]).collect();
    let per_period = mean(&largest);
    Exponents {
        largest_per_s: per_period * frequency_hz,
        standard_error_per_s: (spread / (count * (count - 1.0))).sqrt() * frequency_hz,
        other_per_s: other.map(|o| mean(&o) * frequency_hz),
        largest_per_period: per_period,
        periods: booked.len() as u32,
    }
}
