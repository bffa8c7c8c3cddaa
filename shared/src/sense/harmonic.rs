//! The cart's motion at the drive frequency: amplitude and lag, by correlation with the command.
//!
//! Over every whole drive period the cart's displacement is multiplied by the sine and cosine of the
//! commanded phase and summed (synchronous detection). Offset, noise and the harmonics that a contact
//! leaves in the cart's motion are orthogonal to both and drop out.

use micromath::F32Ext;

/// The cart's motion y = `sine` sin φ + `cosine` cos φ, φ the commanded phase.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fundamental {
    /// In phase with the command, m.
    pub sine: f32,
    /// A quarter turn ahead of it, m.
    pub cosine: f32,
}

impl Fundamental {
    /// Amplitude of the cart's motion at the drive frequency, m.
    pub fn amplitude_m(&self) -> f32 {
        libm::sqrtf(self.sine * self.sine + self.cosine * self.cosine)
    }

    /// Lag behind the command, rad, −π to π. By micromath's arctangent: within 0.005 rad of the exact
    /// one, which is 0.3 degrees; the observer does not use it but the two parts themselves. 0 for a motion
    /// so small that its squares underflow: the arctangent divides by them.
    pub fn lag_rad(&self) -> f32 {
        if self.sine * self.sine + self.cosine * self.cosine == 0.0 {
            return 0.0;
        }
        F32Ext::atan2(-self.cosine, self.sine)
    }
}

/// Correlates the cart's displacement with the command.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Harmonic {
    sine: f32,
    cosine: f32,
    mean: f32,
    ticks: u32,
    /// Whether the sums began at phase 0.
    whole: bool,
    offset_m: f32,
    last: Fundamental,
}

impl Harmonic {
    /// The next sample of the cart, m, with the sine and cosine of the commanded phase.
    #[inline]
    pub fn tick(&mut self, cart_m: f32, sin: f32, cos: f32) {
        let y = cart_m - self.offset_m;
        self.sine += y * sin;
        self.cosine += y * cos;
        self.mean += y;
        self.ticks = self.ticks.saturating_add(1);
    }

    /// A drive period is over: its fundamental; that of the period before, if it was not whole.
    pub fn strobe(&mut self) -> Fundamental {
        if self.whole && self.ticks > 0 {
            let per_tick = 1.0 / self.ticks as f32;
            self.last = Fundamental {
                sine: 2.0 * per_tick * self.sine,
                cosine: 2.0 * per_tick * self.cosine,
            };
            // Taking the mean off leaves less for the ends of the period to leak.
            self.offset_m += self.mean * per_tick;
        }
        self.begin(true);
        self.last
    }

    /// The fundamental of the last whole period.
    #[inline]
    pub fn last(&self) -> Fundamental {
        self.last
    }

    /// Mean of the cart's displacement, m.
    pub fn offset_m(&self) -> f32 {
        self.offset_m
    }

    /// Sets the mean of the cart's displacement, m, and discards the period under way.
    pub fn set_offset(&mut self, offset_m: f32) {
        self.offset_m = offset_m;
        self.restart();
    }

    /// Discards the period under way.
    pub fn restart(&mut self) {
        self.begin(false);
    }

    /// Forgets everything: sums, mean, and the last period's fundamental.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    fn begin(&mut self, whole: bool) {
        self.sine = 0.0;
        self.cosine = 0.0;
        self.mean = 0.0;
        self.ticks = 0;
        self.whole = whole;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::drive::Drive;

    /// The cart over 5 periods at 2.73 Hz with an offset, and a ramp of speed after a contact once per period.
    fn measure(amplitude: f64, lag: f64, kick_m: f64) -> Fundamental {
        let mut drive = Drive::<f32>::new(2.73, 50e-6).unwrap();
        let mut harmonic = Harmonic::default();
        let mut last = Fundamental::default();
        let mut cycle = 0;
        for _ in 0..36_700 {
            let now = drive.now();
            if now.cycle != cycle {
                cycle = now.cycle;
                last = harmonic.strobe();
            }
            let phase = f64::from(now.phase) / crate::model::drive::TURN;
            let angle = core::f64::consts::TAU * phase - lag;
            // A position loop has corrected the kick of a contact at phase 0.3 after a tenth of a period.
            let since = phase - 0.3;
            let kick = if (0.0..0.1).contains(&since) {
                kick_m * (since * 10.0) * (1.0 - since * 10.0)
            } else {
                0.0
            };
            let y = amplitude * angle.sin() + 0.2e-3 + kick;
            harmonic.tick(y as f32, drive.sin(), drive.cos());
            drive.advance();
        }
        last
    }

    #[test]
    fn a_motion_of_next_to_nothing_has_a_lag() {
        for exponent in -45..0 {
            let part = 10_f32.powi(exponent);
            for (sine, cosine) in [(part, 0.0), (0.0, part), (-part, part), (part, -0.7 * part)] {
                let lag = Fundamental { sine, cosine }.lag_rad();
                assert!(lag.abs() < 3.15, "{sine} {cosine}: {lag}");
            }
        }
    }

    #[test]
    fn amplitude_and_lag_come_out() {
        for lag in [-1.0, 0.0, 0.4, 2.9] {
            let found = measure(0.89e-3, lag, 0.0);
            assert!(
                (f64::from(found.amplitude_m()) / 0.89e-3 - 1.0).abs() < 5e-4,
                "{found:?}"
            );
            assert!(
                (f64::from(found.lag_rad()) - lag).abs() < 0.005,
                "{lag}: {}",
                found.lag_rad()
            );
        }
    }

    #[test]
    fn the_kick_of_a_contact_hardly_shows() {
        // A transient of 5 % of A0, a tenth of a period long.
        let found = measure(0.89e-3, 0.4, 45e-6);
        assert!(
            (f64::from(found.amplitude_m()) / 0.89e-3 - 1.0).abs() < 0.01,
            "{found:?}"
        );
    }

    #[test]
    fn the_arctangent_is_as_good_as_stated() {
        let worst = (0..6_282).map(|i| {
            let angle = f64::from(i - 3_141) * 1e-3;
            let part = Fundamental {
                sine: angle.cos() as f32,
                cosine: -angle.sin() as f32,
            };
            (f64::from(part.lag_rad()) - angle).abs()
        });
        let worst = worst.fold(0.0, f64::max);
        assert!(worst < 0.005, "{worst}");
        use core::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};
        for (sine, cosine, lag) in [
            (1.0, -1.0, FRAC_PI_4),
            (0.0, -1.0, FRAC_PI_2),
            (0.0, 1.0, -FRAC_PI_2),
            (-1.0, -0.0, PI),
        ] {
            let found = Fundamental { sine, cosine }.lag_rad();
            assert!((found.abs() - lag.abs()).abs() < 0.005, "{found} {lag}");
        }
    }

    #[test]
    fn a_cart_without_motion_has_no_lag_and_its_place_is_its_mean() {
        let still = Fundamental::default();
        assert_eq!((still.amplitude_m(), still.lag_rad()), (0.0, 0.0));
        let mut harmonic = Harmonic::default();
        harmonic.strobe();
        // Four samples per period, twice, about a place of 3 and then of 5.
        for (place, known) in [(3.0, 3.0), (5.0, 5.0)] {
            for (sin, cos) in [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)] {
                harmonic.tick(place + 0.5 * sin + 0.25 * cos, sin, cos);
            }
            let found = harmonic.strobe();
            assert_eq!((found.sine, found.cosine), (0.5, 0.25));
            assert_eq!(found, harmonic.last());
            assert_eq!(harmonic.offset_m(), known);
        }
        // A period cut short does not count, nor does the part of it that is left.
        harmonic.tick(9.0, 1.0, 0.0);
        harmonic.restart();
        harmonic.tick(9.0, 1.0, 0.0);
        let kept = harmonic.strobe();
        assert_eq!((kept.sine, harmonic.offset_m()), (0.5, 5.0));
        assert_eq!(harmonic.strobe(), kept, "a period without a sample");
        harmonic.reset();
        assert_eq!(harmonic, Harmonic::default());
    }

    #[test]
    fn a_period_that_is_not_whole_does_not_count() {
        let mut harmonic = Harmonic::default();
        for _ in 0..100 {
            harmonic.tick(1.0, 1.0, 0.0);
        }
        assert_eq!(harmonic.strobe(), Fundamental::default());
    }
}
