//! The self test before the drive goes on: whether the sensors are alive, and where they read zero.

use crate::fault::{Fault, Origin};
use crate::io::{AdcCode, Frame};
use crate::sense::Sample;
use crate::settings::{Settings, TICK_RATE_HZ};

use super::guard::Trip;

/// Windows waited for a hammer that strikes the surface to come to rest.
const MAX_WINDOWS: u8 = 20;
/// A window is so many half natural periods. A mean over it is that of their means, weighted 1, 3, 3 and 1: a free swing drops
/// out of it (0.3 % of it is left where the natural frequency is 10 % off, 2 % where it is 20 % off).
const HALF_PERIODS: u8 = 4;
/// A hammer whose displacement varies less than this share of A0 (r.m.s.) is at rest.
const AT_REST: f32 = 0.25;
/// Largest rest displacement of the hammer taken for a sensor's offset, m, and what a tilt of 1.5° moves the hammer, m/s² over ω².
const MAX_REST_M: f32 = 1.5e-3;
const TILTED_M_PER_S2: f32 = 0.257;
/// Largest offset of the force sensor, as a share of the force limit.
const MAX_FORCE_OFFSET: f32 = 0.12;

/// Where the sensors read zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Zero {
    /// Force with nothing touching, N.
    pub force_n: f32,
    /// Hammer relative to the cart at rest, m; none if it strikes the surface all the time.
    pub relative_m: Option<f32>,
    /// The cart with the drive off, m.
    pub cart_m: f32,
    /// Amplitude of the hammer's swing relative to the cart, m.
    pub swing_m: f32,
    /// Whether the force sensor's code varied without a contact.
    pub force_is_live: bool,
}

/// What a window has shown so far. Everything is over its first sample, so that sums stay small.
#[derive(Clone, Copy, Debug, Default)]
struct Window {
    first: Sample,
    /// Sums of the present half period.
    sums: Sample,
    /// Weighted means of those before.
    means: Sample,
    half_periods: u8,
    relative_squares: f32,
    largest_n: f32,
    codes: (AdcCode, AdcCode),
}

/// The self test under way: windows of samples until the zeros are known.
#[derive(Clone, Copy, Debug)]
pub struct SelfTest {
    /// Ticks of half a natural period.
    half_period: u32,
    quiet_m2: f32,
    touch_n: f32,
    max_force_n: f32,
    max_rest_m: f32,
    ticks: u32,
    windows: u8,
    window: Window,
}

impl SelfTest {
    /// A test of a rig with `settings`. Two ask for it: one copy is enough.
    #[inline(never)]
    pub fn new(settings: &Settings) -> Self {
        let natural_hz = (settings.rig.natural_frequency_hz() as f32).max(0.1);
        let at_rest_m = AT_REST * settings.rig.amplitude_m as f32;
        let omega = core::f32::consts::TAU * natural_hz;
        Self {
            half_period: (0.5 * TICK_RATE_HZ as f32 / natural_hz) as u32,
            quiet_m2: at_rest_m * at_rest_m,
            touch_n: settings.detection.on_n,
            max_force_n: MAX_FORCE_OFFSET * settings.limits.force_n,
            max_rest_m: MAX_REST_M + TILTED_M_PER_S2 / (omega * omega),
            ticks: 0,
            windows: 0,
            window: Window::default(),
        }
    }

    /// Takes in a tick with the drive off. At the end, the zeros or the fault.
    pub fn tick(&mut self, frame: &Frame, sample: &Sample) -> Option<Result<Zero, Trip>> {
        let window = &mut self.window;
        if self.ticks == 0 && window.half_periods == 0 {
            *window = Window {
                first: *sample,
                codes: (frame.force, frame.force),
                ..Window::default()
            };
        }
        let (first, sums) = (&window.first, &mut window.sums);
        let force_n = sample.force_n - first.force_n;
        let cart_m = sample.cart_m - first.cart_m;
        let relative_m = sample.hammer_m - first.hammer_m - cart_m;
        sums.force_n += force_n;
        sums.hammer_m += relative_m;
        sums.cart_m += cart_m;
        window.relative_squares += relative_m * relative_m;
        window.largest_n = window.largest_n.max(force_n);
        window.codes.0 = window.codes.0.min(frame.force);
        window.codes.1 = window.codes.1.max(frame.force);
        self.ticks += 1;
        if self.ticks < self.half_period {
            return None;
        }
        self.ticks = 0;
        let share = 1.0 / self.half_period as f32;
        let is_outer = matches!(window.half_periods, 0 | 3);
        let weight = if is_outer { 0.125 } else { 0.375 } * share;
        let (means, sums) = (&mut window.means, core::mem::take(&mut window.sums));
        means.force_n += weight * sums.force_n;
        means.hammer_m += weight * sums.hammer_m;
        means.cart_m += weight * sums.cart_m;
        window.half_periods += 1;
        if window.half_periods < HALF_PERIODS {
            return None;
        }
        window.half_periods = 0;
        self.windows = self.windows.saturating_add(1);
        let (first, means) = (&window.first, &window.means);
        let mean_square_m2 = window.relative_squares * share / f32::from(HALF_PERIODS);
        let variance_m2 = mean_square_m2 - means.hammer_m * means.hammer_m;
        let at_rest = variance_m2 <= self.quiet_m2;
        let touches = window.largest_n - means.force_n > self.touch_n;
        // A hammer at rest on the surface is no contact, and what a dead force sensor does not show may be one.
        let force_is_live = window.codes.0 != window.codes.1 && (at_rest || !touches);
        let is_known = at_rest || force_is_live;
        if !is_known && self.windows < MAX_WINDOWS {
            return None;
        }
        let relative_m = first.hammer_m - first.cart_m + means.hammer_m;
        let zero = Zero {
            force_n: first.force_n + means.force_n,
            relative_m: is_known.then_some(relative_m),
            cart_m: first.cart_m + means.cart_m,
            swing_m: libm::sqrtf(2.0 * variance_m2.max(0.0)),
            force_is_live,
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
            Some(rest_m) if libm::fabsf(rest_m) > self.max_rest_m => {
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
            (21_500..22_500).contains(&ticks),
            "two natural periods: {ticks}"
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
        assert!(ticks < 22_500, "two natural periods: {ticks}");
        assert!((zero.force_n - 2.5).abs() < 1e-3, "{zero:?}");
        assert!((zero.relative_m.unwrap() - 0.5e-3).abs() < 1e-6, "{zero:?}");
        assert!((zero.cart_m + 0.1e-3).abs() < 1e-6, "{zero:?}");
    }

    /// A hammer that swings by 1 mm about `rest_m` at `hz`, whose force sensor is alive or not; at every `struck` swing it
    /// strikes.
    fn swing(hz: f32, rest_m: f32, alive: bool, struck: Option<u32>) -> (u32, Zero) {
        let mut test = SelfTest::new(&Settings::for_rig(&WIRES));
        let end = (0..2_000_000_u32).find_map(|tick| {
            let turns = hz * tick as f32 / 20_000.0;
            let strikes = struck.is_some_and(|n| turns as u32 % n == n - 1 && turns.fract() < 0.01);
            let frame = Frame {
                force: AdcCode(600 + (tick % 2) as u16 * u16::from(alive)),
                ..Frame::default()
            };
            let sample = Sample {
                force_n: if strikes { 40.0 } else { 0.0 },
                hammer_m: rest_m + 1e-3 * libm::sinf(core::f32::consts::TAU * turns),
                ..Sample::default()
            };
            test.tick(&frame, &sample).map(|end| (tick, end.unwrap()))
        });
        end.expect("the self test ends")
    }

    #[test]
    fn a_hammer_that_swings_freely_is_zeroed_at_once_wherever_it_swings() {
        let natural_hz = WIRES.natural_frequency_hz() as f32;
        for (off, within_m) in [
            (0.8, 25e-6),
            (0.9, 5e-6),
            (1.0, 1e-6),
            (1.1, 5e-6),
            (1.2, 25e-6),
        ] {
            let (ticks, zero) = swing(off * natural_hz, 0.5e-3, true, None);
            assert!(ticks < 22_500, "two natural periods: {ticks}");
            assert!(zero.force_is_live);
            let error_m = zero.relative_m.unwrap() - 0.5e-3;
            assert!(error_m.abs() < within_m, "{off}: {error_m}");
            assert!((zero.swing_m - 1e-3).abs() < 1e-4, "{off}: {zero:?}");
        }
    }

    #[test]
    fn a_hammer_that_strikes_is_waited_for_and_so_is_one_whose_contacts_would_not_be_seen() {
        let natural_hz = WIRES.natural_frequency_hz() as f32;
        let (_, dead) = swing(natural_hz, 0.0, false, None);
        let (ticks, striking) = swing(natural_hz, 0.0, true, Some(2));
        // Twenty windows of two natural periods.
        assert!((430_000..450_000).contains(&ticks), "{ticks}");
        for zero in [dead, striking] {
            assert_eq!(zero.relative_m, None);
            assert!(!zero.force_is_live);
            assert!((zero.swing_m - 1e-3).abs() < 2e-5, "{zero:?}");
        }
    }

    #[test]
    fn a_force_is_live_if_its_code_moves_while_nothing_touches() {
        let is_live = |noise: u16| {
            let mut test = SelfTest::new(&Settings::for_rig(&WIRES));
            let zero = (0..2_000_000_u32).find_map(|tick| {
                let force = AdcCode(600 + (tick % 2) as u16 * noise);
                let frame = Frame {
                    force,
                    ..Frame::default()
                };
                test.tick(&frame, &Sample::default())
            });
            zero.unwrap().unwrap().force_is_live
        };
        assert!(is_live(1));
        assert!(!is_live(0), "a signal that stands");
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
            hammer_m: 3.6e-3,
            ..Sample::default()
        });
        assert_eq!(origin(hammer), Origin::Hammer);
        let near = run(|_| Sample {
            hammer_m: 3.3e-3,
            ..Sample::default()
        });
        assert!(near.1.is_ok());
    }
}
