//! A second-order low-pass filter, exact for an input that is linear between its steps.

use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

/// Output and its rate over the corner's angular frequency.
pub type FilterState = [f64; 2];

/// A step of the filter: `phase` radians of the corner, with its decay over them.
#[derive(Clone, Copy, Debug)]
pub struct FilterStep {
    damping: f64,
    phase: f64,
    /// How the state decays with no input: the matrix exponential, row by row.
    pub decay: [[f64; 2]; 2],
}

impl FilterStep {
    /// `damping` is below 1.
    pub fn new(damping: f64, phase: f64) -> Self {
        let turn = (1.0 - damping * damping).sqrt();
        let (sin, cos) = (turn * phase).sin_cos();
        let size = (-damping * phase).exp();
        let (c, s) = (size * cos, size * sin / turn);
        Self {
            damping,
            phase,
            decay: [[c + damping * s, s], [-s, c - damping * s]],
        }
    }

    /// The state after the step, over which the input goes straight from `from` to `to`.
    #[inline]
    pub fn advance(&self, state: FilterState, from: f64, to: f64) -> FilterState {
        // Along a ramp the output lags by 2ζ radians; what is left of the state decays.
        let slope = (to - from) / self.phase;
        let lag = 2.0 * self.damping * slope;
        let rest = [state[0] - (from - lag), state[1] - slope];
        let left = self.decay.map(|row| row[0] * rest[0] + row[1] * rest[1]);
        [to - lag + left[0], slope + left[1]]
    }
}

/// What a digital filter makes of a single 1: of second order, its −3 dB corner (in cycles a sample, below ½) where that of
/// an analog one of this damping is (the bilinear transformation). Ends when it has died away.
pub fn digital(corner: f64, damping: f64) -> impl Iterator<Item = f64> {
    let warped = (PI * corner.min(0.4999)).tan();
    let under = 1.0 + 2.0 * damping * warped + warped * warped;
    let gain = warped * warped / under;
    let back = [
        2.0 * (warped * warped - 1.0) / under,
        (1.0 - 2.0 * damping * warped + warped * warped) / under,
    ];
    let mut last = [0.0_f64; 2];
    [1.0, 2.0, 1.0]
        .into_iter()
        .chain(std::iter::repeat(0.0))
        .map(move |input| {
            let now = gain * input - back[0] * last[0] - back[1] * last[1];
            last = [now, last[0]];
            last
        })
        .take_while(|last| last[0].abs().max(last[1].abs()) > 1e-9)
        .map(|last| last[0])
}

/// A filter stepped at a fixed time.
#[derive(Clone, Copy, Debug)]
pub struct LowPass {
    step: FilterStep,
    state: FilterState,
    input: f64,
}

impl LowPass {
    /// Butterworth's, with its −3 dB corner at `corner_hz`, stepped by `step_s`, at rest at 0.
    pub fn butterworth(corner_hz: f64, step_s: f64) -> Self {
        Self {
            step: FilterStep::new(FRAC_1_SQRT_2, TAU * corner_hz * step_s),
            state: [0.0; 2],
            input: 0.0,
        }
    }

    /// The output after a step at whose end the input is `input`.
    pub fn next(&mut self, input: f64) -> f64 {
        self.state = self.step.advance(self.state, self.input, input);
        self.input = input;
        self.state[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The textbook's answer of a Butterworth filter to a step, and its gain of 1/√2 at the corner.
    #[test]
    fn a_step_and_the_corner_are_the_textbooks() {
        let (corner, step) = (6000.0, 1e-6);
        let mut filter = LowPass::butterworth(corner, step);
        filter.input = 1.0;
        for i in 1..400 {
            let got = filter.next(1.0);
            let x = TAU * corner * step * f64::from(i) * FRAC_1_SQRT_2;
            let closed = 1.0 - (-x).exp() * (x.cos() + x.sin());
            assert!((got - closed).abs() < 1e-12, "{i}: {got} {closed}");
        }
        let mut filter = LowPass::butterworth(corner, step);
        let mut largest = 0.0_f64;
        for i in 1..20_000 {
            let out = filter.next((TAU * corner * step * f64::from(i)).sin());
            if i > 10_000 {
                largest = largest.max(out);
            }
        }
        assert!((largest - FRAC_1_SQRT_2).abs() < 1e-4, "{largest}");
    }

    /// The digital one passes a constant as it is, and 1/√2 of its corner.
    #[test]
    fn the_digital_corner_is_the_analog_ones() {
        for corner in [0.02, 0.2, 0.45] {
            let weights: Vec<f64> = digital(corner, FRAC_1_SQRT_2).collect();
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-7, "{corner}");
            let turned = |i: usize| TAU * corner * i as f64;
            let (re, im) = weights.iter().enumerate().fold((0.0, 0.0), |sum, (i, w)| {
                (sum.0 + w * turned(i).cos(), sum.1 + w * turned(i).sin())
            });
            assert!(
                (f64::hypot(re, im) - FRAC_1_SQRT_2).abs() < 1e-6,
                "{corner}"
            );
        }
    }
}
