//! The anti-alias filter: second-order Butterworth, exact for an input that is linear between samples.

use std::f64::consts::{SQRT_2, TAU};

/// A second-order Butterworth low-pass sampled at a fixed step.
#[derive(Clone, Debug)]
pub struct Butterworth {
    /// Row by row: next state from (state, input at the start, change of the input over the step).
    rows: [[f64; 4]; 2],
    state: [f64; 2],
    input: f64,
}

impl Butterworth {
    /// With its −3 dB corner at `corner_hz`, stepped by `step_s`; at rest at 0.
    pub fn new(corner_hz: f64, step_s: f64) -> Self {
        // State in units of the corner: (output, output's rate over ωc); time in radians of it.
        let h = TAU * corner_hz * step_s;
        let generator = [
            [0.0, h, 0.0, 0.0],
            [-h, -SQRT_2 * h, h, 0.0],
            // The input and its change over the step, as states that drive.
            [0.0, 0.0, 0.0, 1.0],
            [0.0, 0.0, 0.0, 0.0],
        ];
        let [first, second, ..] = exponential(&generator);
        Self {
            rows: [first, second],
            state: [0.0; 2],
            input: 0.0,
        }
    }

    /// Puts the filter at rest with input and output at `value`.
    pub fn settle(&mut self, value: f64) {
        self.state = [value, 0.0];
        self.input = value;
    }

    /// The output after a step at whose end the input is `input`.
    #[inline]
    pub fn next(&mut self, input: f64) -> f64 {
        let given = [self.state[0], self.state[1], self.input, input - self.input];
        self.state = self
            .rows
            .map(|row| row.iter().zip(given).map(|(a, b)| a * b).sum());
        self.input = input;
        self.state[0]
    }

    /// Whether output, its rate and the input are all smaller than `limit`.
    pub fn is_below(&self, limit: f64) -> bool {
        let [value, rate] = self.state;
        value.abs() < limit && rate.abs() < limit && self.input.abs() < limit
    }
}

/// e to the power of a matrix: Taylor's series of a 2⁻¹⁶ part of it, squared sixteen times.
fn exponential(matrix: &[[f64; 4]; 4]) -> [[f64; 4]; 4] {
    const HALVINGS: i32 = 16;
    let part = matrix.map(|row| row.map(|x| x * 0.5_f64.powi(HALVINGS)));
    let identity: [[f64; 4]; 4] =
        std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    // e^x − 1, which keeps its digits while it is squared: (1 + r)² = 1 + (2 r + r²).
    let mut rest = [[0.0; 4]; 4];
    for k in (1..=6).rev() {
        let scaled = part.map(|row| row.map(|x| x / f64::from(k)));
        let product = times(&scaled, &rest);
        rest = combine(&scaled, &product, 1.0);
    }
    for _ in 0..HALVINGS {
        rest = combine(&times(&rest, &rest), &rest, 2.0);
    }
    combine(&identity, &rest, 1.0)
}

/// a + factor · b.
fn combine(a: &[[f64; 4]; 4], b: &[[f64; 4]; 4], factor: f64) -> [[f64; 4]; 4] {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] + factor * b[i][j]))
}

fn times(a: &[[f64; 4]; 4], b: &[[f64; 4]; 4]) -> [[f64; 4]; 4] {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_answered_by_the_closed_form() {
        let (corner, step) = (6000.0, 5e-6);
        let mut filter = Butterworth::new(corner, step);
        // The step is linear over the first sample; so subtract that ramp by starting settled there.
        filter.input = 1.0;
        for k in 1..200 {
            let got = filter.next(1.0);
            let t = f64::from(k) * step * TAU * corner / SQRT_2;
            let want = 1.0 - (-t).exp() * (t.cos() + t.sin());
            assert!((got - want).abs() < 1e-10, "{k}: {got} against {want}");
        }
    }

    #[test]
    fn the_corner_is_three_decibels_down() {
        let (corner, step) = (1000.0, 50e-6);
        let mut filter = Butterworth::new(corner, step);
        let mut peak = 0.0_f64;
        for k in 0..4000 {
            let out = filter.next((TAU * 100.0 * f64::from(k) * step).sin());
            peak = if k > 2000 { peak.max(out) } else { 0.0 };
        }
        // |H| at a tenth of the corner: 1/√(1 + 1e-4).
        assert!((peak - (1.0_f64 + 1e-4).powf(-0.5)).abs() < 1e-3, "{peak}");
        let mut fine = Butterworth::new(corner, 1e-6);
        let mut peak = 0.0_f64;
        for k in 0..40_000 {
            let out = fine.next((TAU * corner * f64::from(k) * 1e-6).sin());
            peak = if k > 20_000 { peak.max(out) } else { 0.0 };
        }
        assert!((peak - 0.5_f64.sqrt()).abs() < 1e-5, "{peak}");
    }
}
