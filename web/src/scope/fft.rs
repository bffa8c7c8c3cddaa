//! The spectrum of a signal.

use std::f64::consts::TAU;

/// Amplitudes at 0, 1, 2 … periods in `values` (a power of two of them), without their mean, under a Hann window: a sine of
/// amplitude a in the middle of a step reads a.
pub fn amplitudes(values: &[f64]) -> impl Iterator<Item = f64> + use<> {
    let count = values.len();
    let mean = values.iter().sum::<f64>() / count as f64;
    let window = |k: usize| 0.5 - 0.5 * (TAU * k as f64 / count as f64).cos();
    let mut points: Vec<[f64; 2]> = values
        .iter()
        .enumerate()
        .map(|(k, value)| [(value - mean) * window(k), 0.0])
        .collect();
    transform(&mut points);
    // Half of the amplitude lies at the negative frequency, and half of it under the window.
    let scale = 4.0 / count as f64;
    points
        .into_iter()
        .take(count / 2)
        .map(move |[re, im]| scale * re.hypot(im))
}

/// The discrete Fourier transform in place, by halves (Cooley and Tukey).
fn transform(points: &mut [[f64; 2]]) {
    let count = points.len();
    let bits = count.trailing_zeros();
    for k in 0..count {
        let other = k.reverse_bits() >> (usize::BITS - bits);
        if other > k {
            points.swap(k, other);
        }
    }
    let mut half = 1;
    while half < count {
        let turn = |k: usize| {
            let (sin, cos) = (-TAU * k as f64 / (2 * half) as f64).sin_cos();
            [cos, sin]
        };
        let turns: Vec<[f64; 2]> = (0..half).map(turn).collect();
        for block in points.chunks_exact_mut(2 * half) {
            let (low, high) = block.split_at_mut(half);
            for ((a, b), [cos, sin]) in low.iter_mut().zip(high).zip(&turns) {
                let turned = [b[0] * cos - b[1] * sin, b[0] * sin + b[1] * cos];
                *b = [a[0] - turned[0], a[1] - turned[1]];
                *a = [a[0] + turned[0], a[1] + turned[1]];
            }
        }
        half *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_transform_is_the_sum_by_its_definition() {
        let mut points: Vec<[f64; 2]> = (0..16)
            .map(|k| [(k as f64 * 0.7).sin(), (k as f64).cos()])
            .collect();
        let plain = points.clone();
        transform(&mut points);
        for (n, found) in points.iter().enumerate() {
            let mut sum = [0.0; 2];
            for (k, [re, im]) in plain.iter().enumerate() {
                let (sin, cos) = (-TAU * (n * k) as f64 / 16.0).sin_cos();
                sum[0] += re * cos - im * sin;
                sum[1] += re * sin + im * cos;
            }
            assert!((sum[0] - found[0]).abs() < 1e-12 && (sum[1] - found[1]).abs() < 1e-12);
        }
    }

    #[test]
    fn a_sine_reads_its_amplitude_and_a_constant_nothing() {
        let values: Vec<f64> = (0..1024)
            .map(|k| 5.0 + 0.3 * (TAU * 32.0 * k as f64 / 1024.0).sin())
            .collect();
        let found: Vec<f64> = amplitudes(&values).collect();
        assert!((found[32] - 0.3).abs() < 1e-12, "{}", found[32]);
        assert!(found[0] < 1e-12 && found[100] < 1e-12);
    }
}
