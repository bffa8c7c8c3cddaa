//! The spectrum of a signal.

use std::f64::consts::TAU;

use rustfft::algorithm::Radix4;
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftDirection};

/// Amplitudes at 0, 1, 2 … periods in `values` (a power of two of them), without their mean, under a Hann window: a sine of
/// amplitude a in the middle of a step reads a.
pub fn amplitudes(values: &[f64]) -> impl Iterator<Item = f64> + use<> {
    let count = values.len();
    let mean = values.iter().sum::<f64>() / count as f64;
    let window = |k: usize| 0.5 - 0.5 * (TAU * k as f64 / count as f64).cos();
    let mut points: Vec<Complex<f64>> = values
        .iter()
        .enumerate()
        .map(|(k, value)| ((value - mean) * window(k)).into())
        .collect();
    // The planner would bring every algorithm into the page.
    Radix4::new(count, FftDirection::Forward).process(&mut points);
    // Half of the amplitude lies at the negative frequency, and half of it under the window.
    let scale = 4.0 / count as f64;
    points
        .into_iter()
        .take(count / 2)
        .map(move |point| scale * point.norm())
}

#[cfg(test)]
mod tests {
    use super::*;

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
