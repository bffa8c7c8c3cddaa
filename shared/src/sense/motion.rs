//! How much the hammer itself moves in a drive period: a sensor that measures nothing shows no motion, whatever the cart does.

/// Samples to a mean, of which the motion is taken: noise is a sixth of what it is in one sample.
const SAMPLES: u32 = 32;

/// Sums of the means of a drive period.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PeriodMotion {
    part: f32,
    samples: u32,
    sum: f32,
    squares: f32,
    means: u32,
}

impl PeriodMotion {
    /// A sample of the hammer's displacement, m.
    #[inline]
    pub fn tick(&mut self, hammer_m: f32) {
        self.part += hammer_m;
        self.samples += 1;
        if self.samples == SAMPLES {
            let mean = self.part * (1.0 / SAMPLES as f32);
            self.part = 0.0;
            self.samples = 0;
            self.sum += mean;
            self.squares += mean * mean;
            self.means += 1;
        }
    }

    /// Root mean square of the motion about its middle since the last call, m.
    pub fn take_rms_m(&mut self) -> f32 {
        let Self {
            sum,
            squares,
            means,
            ..
        } = core::mem::take(self);
        let per = 1.0 / means.max(1) as f32;
        libm::sqrtf((squares * per - (sum * per) * (sum * per)).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_has_its_own_wherever_its_middle_is_and_noise_a_sixth() {
        let mut motion = PeriodMotion::default();
        for middle_m in [0.0, -3e-3] {
            for k in 0..3_200 {
                let turns = f64::from(k) / 3_200.0;
                let sine = (core::f64::consts::TAU * turns).sin();
                motion.tick(middle_m + (1e-3 * sine) as f32);
            }
            let rms = motion.take_rms_m() / 0.7071e-3;
            assert!((rms - 1.0).abs() < 2e-3, "{rms}");
        }
        let mut random = 1_u32;
        for _ in 0..3_200 {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            // An even spread over ±√3 has the root mean square 1.
            let even = (f64::from(random) / 4_294_967_296.0 - 0.5) * 12.0_f64.sqrt();
            motion.tick((1e-4 * even) as f32);
        }
        let share = motion.take_rms_m() / 1e-4;
        assert!((0.1..0.25).contains(&share), "{share}");
        assert_eq!(motion.take_rms_m(), 0.0);
    }
}
