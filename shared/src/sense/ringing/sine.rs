//! A decaying sine in samples: its pole from their correlation, its amplitude by least squares.

use nalgebra::{Complex, Matrix2, Vector2};

use crate::model::trig::sin_cos_f32;

/// Samples of the ringing alone that are fitted.
pub(super) const TAIL: usize = 48;
/// First lag of the correlation: noise behind the anti-alias filter is alike over the ones before it.
pub(super) const FIRST_LAG: usize = 3;
/// Lags of the correlation.
pub(super) const LAGS: usize = 16;
/// Share of the correlation's squares that a decaying sine may leave over.
const UNEXPLAINED: f32 = 0.05;
/// Squared decay per tick of what can be ringing: one twelfth of a millisecond and longer.
const LEAST_DECAY: f32 = 0.3;

/// Sum of the products of `count` samples, the first at `from`, with those `lag` later.
#[inline(never)]
pub(super) fn products(samples: &[f32; TAIL], from: usize, lag: usize, count: usize) -> f32 {
    let later = samples.iter().skip(from + lag);
    let pairs = samples.iter().skip(from).zip(later).take(count);
    pairs.map(|(a, b)| a * b).sum()
}

/// The decaying sine that the samples are, by their correlation: the logarithm of what it is multiplied by per tick. None if they are no such
/// sine.
pub(super) fn pole(samples: &[f32; TAIL]) -> Option<Complex<f32>> {
    let mut correlation = [0.0; LAGS];
    for (lag, sum) in (FIRST_LAG..).zip(&mut correlation) {
        *sum = products(samples, 0, lag, TAIL - LAGS - FIRST_LAG + 1);
    }
    // Each is a sum of the two before it, with the same weights.
    let mut rows = correlation.windows(3).filter_map(|three| match *three {
        [oldest, before, now] => Some((Vector2::new(before, oldest), now)),
        _ => None,
    });
    let (weights, left) = least_squares(&mut rows)?;
    let (sum, squared) = (weights.x, -weights.y);
    let decays = squared > LEAST_DECAY && squared < 1.0;
    let real = 0.5 * sum;
    let swings = real * real < squared;
    (decays && swings && left < UNEXPLAINED).then(|| {
        let imaginary = libm::sqrtf(squared - real * real);
        Complex::new(0.5 * libm::logf(squared), libm::atan2f(imaginary, real))
    })
}

/// The complex amplitude A for which the real part of A e^(pole k) fits the samples best, k = 0 at the first.
pub(super) fn fit(samples: &[f32; TAIL], pole: Complex<f32>) -> Option<Complex<f32>> {
    let step = exp(pole);
    let mut turned = Complex::new(1.0, 0.0);
    let mut rows = samples.iter().map(|sample| {
        let row = Vector2::new(turned.re, -turned.im);
        turned *= step;
        (row, *sample)
    });
    let (found, _) = least_squares(&mut rows)?;
    Some(Complex::new(found.x, found.y))
}

/// Takes the real part of `amplitude` e^(`pole` k) out of the samples.
pub(super) fn take_out(samples: &mut [f32; TAIL], pole: Complex<f32>, amplitude: Complex<f32>) {
    let step = exp(pole);
    let mut ringing = amplitude;
    for sample in samples {
        *sample -= ringing.re;
        ringing *= step;
    }
}

/// The two weights with which the rows come closest to their values, and the share of the values' squares that is left.
#[inline(never)]
fn least_squares(
    rows: &mut dyn Iterator<Item = (Vector2<f32>, f32)>,
) -> Option<(Vector2<f32>, f32)> {
    let (mut normal, mut right, mut all) = (Matrix2::zeros(), Vector2::zeros(), 0.0);
    for (row, value) in rows {
        normal += row * row.transpose();
        right += row * value;
        all += value * value;
    }
    let weights = normal.try_inverse()? * right;
    Some((weights, 1.0 - weights.dot(&right) / all))
}

/// e^z, with the same bits on every processor, unlike that of `nalgebra`.
#[inline(never)]
pub(super) fn exp(z: Complex<f32>) -> Complex<f32> {
    let (sin, cos) = sin_cos_f32(z.im);
    Complex::new(cos, sin) * libm::expf(z.re)
}
