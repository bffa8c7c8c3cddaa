//! The self test before the drive goes on: whether the sensors are alive, and where they read zero.

use crate::fault::{Fault, Origin};
use crate::io::{AdcCode, Frame};
use crate::sense::Sample;
use crate::settings::{Settings, TICK_RATE_HZ};

use super::guard::Trip;

/// Windows of one natural period, over which a hammer that still swings averages out, waited for it to come to rest: wires
/// have no damping and may swing for long.
const MAX_WINDOWS: u8 = 40;
/// A hammer whose displacement varies less than this share of A0 (r.m.s.) is at rest.
const AT_REST: f32 = 0.25;
/// Largest rest displacement of the hammer taken for a sensor's offset, m.
const MAX_REST_M: f32 = 1.5e-3;
/// Largest offset of the force sensor, as a share of the force limit.
const MAX_FORCE_OFFSET: f32 = 0.12;

/// Where the sensors read zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Zero {
    /// Force with nothing touching, N.
    pub force_n: f32,
    /// Hammer relative to the cart at rest, m; none if it would not come to rest.
    pub relative_m: Option<f32>,
    /// The cart with the drive off, m.
    pub cart_m: f32,
    /// Amplitude of the hammer's swing relative to the cart, m.
    pub swing_m: f32,
    /// Whether the force sensor's code varied with the hammer at rest.
    pub force_is_live: bool,
}

/// The self test.
#[derive(Clone, Copy, Debug)]
pub struct SelfTest {
    window: u32,
    quiet_m2: f32,
    max_force_n: f32,
    ticks: u32,
    windows: u8,
    first: Sample,
    force_sum: f32,
    relative_sum: f32,
    cart_sum: f32,
    relative_squares: f32,
    codes: (AdcCode, AdcCode),
}

impl SelfTest {
    /// A test of a rig with `settings`.
    pub fn new(settings: &Settings) -> Self {
        let natural_hz = (settings.rig.natural_frequency_hz() as f32).max(0.1);
        let at_rest_m = AT_REST * settings.rig.amplitude_m as f32;
        Self {
            window: (TICK_RATE_HZ as f32 / natural_hz) as u32,
            quiet_m2: at_rest_m * at_rest_m,
            max_force_n: MAX_FORCE_OFFSET * settings.limits.force_n,
            ticks: 0,
            windows: 0,
            first: Sample::default(),
            force_sum: 0.0,
            relative_sum: 0.0,
            cart_sum: 0.0,
            relative_squares: 0.0,
            codes: (AdcCode(u16::MAX), AdcCode(0)),
        }
    }

    /// Takes in a tick with the drive off. At the end, the zeros or the fault.
    pub fn tick(&mut self, frame: &Frame, sample: &Sample) -> Option<Result<Zero, Trip>> {
        if self.ticks == 0 {
            // Sums are of what differs from the first sample, so that they stay small.
            self.first = *sample;
            self.force_sum = 0.0;
            self.relative_sum = 0.0;
            self.cart_sum = 0.0;
            self.relative_squares = 0.0;
            self.codes = (AdcCode(u16::MAX), AdcCode(0));
        }
        let relative =
            (sample.hammer_m - sample.cart_m) - (self.first.hammer_m - self.first.cart_m);
        self.force_sum += sample.force_n - self.first.force_n;
        self.relative_sum += relative;
        self.relative_squares += relative * relative;
        self.cart_sum += sample.cart_m - self.first.cart_m;
        self.codes.0 = self.codes.0.min(frame.force);
        self.codes.1 = self.codes.1.max(frame.force);
        self.ticks += 1;
        if self.ticks < self.window {
            return None;
        }
        let share = 1.0 / self.ticks as f32;
        self.ticks = 0;
        self.windows = self.windows.saturating_add(1);
        let mean = self.relative_sum * share;
        let variance_m2 = self.relative_squares * share - mean * mean;
        let at_rest = variance_m2 <= self.quiet_m2;
        if !at_rest && self.windows < MAX_WINDOWS {
            return None;
        }
        let force_n = self.first.force_n + self.force_sum * share;
        let relative_m = self.first.hammer_m - self.first.cart_m + mean;
        let cart_m = self.first.cart_m + self.cart_sum * share;
        let zero = Zero {
            force_n,
            relative_m: at_rest.then_some(relative_m),
            cart_m,
            swing_m: libm::sqrtf(2.0 * variance_m2.max(0.0)),
            // A swinging hammer may strike; that is not noise.
            force_is_live: at_rest && self.codes.0 != self.codes.1,
        };
        Some(self.judge(zero))
    }

    fn judge(&self, zero: Zero) -> Result<Zero, Trip> {
        let out_of_family = |origin, value| Trip {
            fault: Fault::SensorOutOfFamily,
            origin,
            value,
        };
        if libm::fabsf(zero.force_n) > self.max_force_n {
            return Err(out_of_family(Origin::Force, zero.force_n));
        }
        match zero.relative_m {
            Some(rest_m) if libm::fabsf(rest_m) > MAX_REST_M => {
                Err(out_of_family(Origin::Hammer, rest_m))
            }
            _ => Ok(zero),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::params::WIRES;

    fn run(sample: impl Fn(f32) -> Sample) -> (u32, Result<Zero, Trip>) {
        let mut test = SelfTest::new(&Settings::for_rig(&WIRES));
        for tick in 0..2_000_000_u32 {
            let t = tick as f32 / 20_000.0;
            let frame = Frame {
                force: AdcCode(600 + (tick % 2) as u16),
                ..Frame::default()
            };
            if let Some(end) = test.tick(&frame, &sample(t)) {
                return (tick, end);
            }
        }
        panic!("the self test never ends");
    }

    #[test]
    fn offsets_of_a_quiet_rig_are_found() {
        let (ticks, zero) = run(|_| Sample {
            force_n: 2.5,
            hammer_m: 0.4e-3,
            cart_m: -0.1e-3,
        });
        let zero = zero.unwrap();
        assert!(
            (10_500..11_500).contains(&ticks),
            "a natural period: {ticks}"
        );
        assert!((zero.force_n - 2.5).abs() < 1e-5);
        assert!((zero.relative_m.unwrap() - 0.5e-3).abs() < 1e-8);
        assert!(zero.force_is_live);
    }

    #[test]
    fn zeros_are_means_and_a_first_sample_that_is_off_is_nothing_special() {
        let off = |t: f32| if t == 0.0 { 1.0 } else { 0.0 };
        let (ticks, zero) = run(|t| Sample {
            force_n: 2.5 + 8.0 * off(t),
            hammer_m: 0.4e-3 + 3e-3 * off(t),
            cart_m: -0.1e-3 - 0.5e-3 * off(t),
        });
        let zero = zero.unwrap();
        assert!(ticks < 11_500, "a natural period: {ticks}");
        assert!((zero.force_n - 2.5).abs() < 1e-3, "{zero:?}");
        assert!((zero.relative_m.unwrap() - 0.5e-3).abs() < 1e-6, "{zero:?}");
        assert!((zero.cart_m + 0.1e-3).abs() < 1e-6, "{zero:?}");
    }

    #[test]
    fn a_force_is_live_if_its_code_moves_while_the_hammer_rests() {
        let settings = Settings::for_rig(&WIRES);
        let is_live = |noise: u16, swing_m: f32| {
            let mut test = SelfTest::new(&settings);
            let zero = (0..2_000_000_u32).find_map(|tick| {
                let force = AdcCode(600 + (tick % 2) as u16 * noise);
                let frame = Frame {
                    force,
                    ..Frame::default()
                };
                let t = tick as f32 / 20_000.0;
                let hammer_m = swing_m * libm::sinf(11.4 * t);
                test.tick(
                    &frame,
                    &Sample {
                        hammer_m,
                        ..Sample::default()
                    },
                )
            });
            zero.unwrap().unwrap().force_is_live
        };
        assert!(is_live(1, 0.0));
        assert!(!is_live(0, 0.0), "a signal that stands");
        assert!(!is_live(1, 1e-3), "the hammer may strike");
    }

    #[test]
    fn a_hammer_that_swings_is_waited_for_and_then_not_zeroed() {
        let (ticks, zero) = run(|t| Sample {
            hammer_m: 1e-3 * libm::sinf(11.4 * t),
            ..Sample::default()
        });
        // Twenty windows of two natural periods.
        assert!((430_000..450_000).contains(&ticks), "{ticks}");
        let zero = zero.unwrap();
        assert_eq!(zero.relative_m, None);
        assert!((zero.swing_m - 1e-3).abs() < 2e-5, "{zero:?}");
    }

    #[test]
    fn sensors_far_from_zero_are_out_of_family() {
        let origin = |end: (u32, Result<Zero, Trip>)| end.1.unwrap_err().origin;
        let force = run(|_| Sample {
            force_n: 40.0,
            ..Sample::default()
        });
        assert_eq!(origin(force), Origin::Force);
        let hammer = run(|_| Sample {
            hammer_m: 1.6e-3,
            ..Sample::default()
        });
        assert_eq!(origin(hammer), Origin::Hammer);
        let near = run(|_| Sample {
            hammer_m: 1.4e-3,
            ..Sample::default()
        });
        assert!(near.1.is_ok());
    }
}
