//! Whether off is off: the cart's motion while the drive is not enabled.
//!
//! The mean of each [`GROUP`] samples is nearly free of noise. Over a window of two natural periods, the mean distance of
//! these from the mean of the window before shows a motion at any frequency the drive can have; spoilt samples
//! now and then do not show. A hammer that swings shakes a cart that is free, by m/M of its own motion and some more
//! near the resonance of the suspension ([`SHAKEN`]); that is no motion of the drive's.

use crate::settings::{DriveKind, Settings, TICK_RATE_HZ};

/// Samples averaged, 3.2 ms.
const GROUP: u8 = 64;
/// Windows after the drive has been on in which the cart may come to rest: on a shaker's suspension, and with a motor
/// that runs out.
const GRACE: (u8, u8) = (1, 5);
/// Amplitude of the cart that counts as motion, in units of A0.
const MOVES: f32 = 0.125;
/// How far a free cart may move for a swinging hammer, in units of m/M times the hammer's motion.
const SHAKEN: f32 = 2.5;
/// Amplitude of a sine over its mean distance from the middle.
const AMPLITUDE: f32 = core::f32::consts::FRAC_PI_2;

/// Watches a drive that is off.
#[derive(Clone, Copy, Debug)]
pub(super) struct OffWatch {
    /// Groups in a window of two natural periods.
    window: u32,
    largest_m: f32,
    /// No reading counts for more than this, m: it is beyond the rails.
    reach_m: f32,
    /// Windows of grace, and those of it that are left.
    full_grace: u8,
    grace: u8,
    /// SHAKEN m/M.
    shaken: f32,
    grouped: u8,
    /// Groups in the window under way.
    groups: u32,
    cart: Spread,
    relative: Spread,
    moving: bool,
}

impl OffWatch {
    /// For the rig of `settings`.
    pub fn new(settings: &Settings) -> Self {
        let natural_hz = (settings.rig.natural_frequency_hz() as f32).clamp(0.1, 4.0);
        let grace = match settings.drive.kind {
            DriveKind::Shaker => GRACE.0,
            DriveKind::Motor => GRACE.1,
        };
        let window_s = 2.0 / natural_hz;
        Self {
            window: (window_s * TICK_RATE_HZ as f32 / f32::from(GROUP)) as u32,
            largest_m: MOVES * settings.rig.amplitude_m as f32,
            reach_m: 2.0 * settings.trips.cart_m,
            full_grace: grace,
            grace,
            shaken: SHAKEN * (settings.rig.mass_kg / settings.rig.cart_mass_kg) as f32,
            grouped: 0,
            groups: 0,
            cart: Spread::default(),
            relative: Spread::default(),
            moving: false,
        }
    }

    /// The drive is on.
    #[inline]
    pub fn driving(&mut self) {
        self.grace = self.full_grace;
        self.moving = false;
        self.grouped = 0;
        self.groups = 0;
        self.cart = Spread::default();
        self.relative = Spread::default();
    }

    /// The drive is off, the cart at `cart_m` and the hammer `relative_m` from it. The amplitude of the cart's
    /// motion, m, when that trips.
    #[inline]
    pub fn tick(&mut self, cart_m: f32, relative_m: f32) -> Option<f32> {
        self.cart.sum_m += cart_m.max(-self.reach_m).min(self.reach_m);
        self.relative.sum_m += relative_m;
        self.grouped += 1;
        if self.grouped < GROUP {
            return None;
        }
        self.grouped = 0;
        self.cart.group();
        self.relative.group();
        self.groups += 1;
        if self.groups < self.window {
            return None;
        }
        let share = 1.0 / self.groups as f32;
        self.groups = 0;
        let amplitude_m = self.cart.window(share);
        let swing_m = self.relative.window(share);
        let free_m = self.largest_m + self.shaken * swing_m;
        self.moving = amplitude_m > free_m && self.grace == 0;
        self.grace = self.grace.saturating_sub(1);
        self.moving.then_some(amplitude_m)
    }

    /// Whether the cart moves with the drive off.
    pub fn is_moving(&self) -> bool {
        self.moving
    }
}

/// The spread of a signal about its middle.
#[derive(Clone, Copy, Debug, Default)]
struct Spread {
    /// Sum of the group under way.
    sum_m: f32,
    /// Sums over the groups of the window under way: of their means, and of their distances from the middle.
    means_m: f32,
    distances_m: f32,
    /// Mean of the window before.
    middle_m: f32,
}

impl Spread {
    fn group(&mut self) {
        let mean_m = self.sum_m * (1.0 / GROUP as f32);
        self.sum_m = 0.0;
        self.means_m += mean_m;
        self.distances_m += libm::fabsf(mean_m - self.middle_m);
    }

    /// The window of 1/`share` groups ends: the amplitude of a sine of that spread.
    fn window(&mut self, share: f32) -> f32 {
        let amplitude_m = AMPLITUDE * share * self.distances_m;
        self.middle_m = share * self.means_m;
        self.means_m = 0.0;
        self.distances_m = 0.0;
        amplitude_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::params::WIRES;

    /// Seconds until a motion of `share` A0 at `hz`, with noise of 3 % of A0, trips.
    fn trips_after(share: f32, hz: f32, decay_s: f32) -> Option<f32> {
        let mut watch = OffWatch::new(&Settings::for_rig(&WIRES));
        let mut seed = 1_u32;
        (0..400_000_u32).find_map(|tick| {
            let t = tick as f32 / 20_000.0;
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = (seed >> 8) as f32 / 8_388_608.0 - 1.0;
            let size = share * libm::expf(-t / decay_s);
            let motion = size * libm::sinf(core::f32::consts::TAU * hz * t) + 0.05 * noise;
            let moved = watch.tick(0.3e-3 + 0.89e-3 * motion, 1e-3);
            moved.map(|_| t)
        })
    }

    #[test]
    fn a_cart_that_moves_with_the_drive_off_is_found_and_one_below_the_threshold_is_not() {
        for hz in [1.4, 3.66, 7.3] {
            let seconds = trips_after(0.137, hz, 1e9).unwrap();
            assert!(seconds < 2.3, "{hz}: {seconds}");
            assert_eq!(trips_after(0.113, hz, 1e9), None, "{hz}");
        }
    }

    #[test]
    fn spoilt_samples_now_and_then_are_no_motion() {
        let mut watch = OffWatch::new(&Settings::for_rig(&WIRES));
        for tick in 0..200_000_u32 {
            let spoilt = if tick % 4000 < 32 { 2.4e-3 } else { 0.0 };
            assert_eq!(watch.tick(spoilt, 0.0), None);
        }
    }

    #[test]
    fn a_cart_shaken_by_a_swinging_hammer_is_no_drive_and_one_that_moves_more_is() {
        let moves = |share: f32| {
            let mut watch = OffWatch::new(&Settings::for_rig(&WIRES));
            (0..200_000_u32).any(|tick| {
                let sin = libm::sinf(core::f32::consts::TAU * 4.3e-5 * tick as f32 * 5.0);
                // 3 mm of swing: 0.111 mm and 2.5 m/M of that are 0.526 mm.
                watch.tick(share * 0.526e-3 * sin, 3e-3 * sin).is_some()
            })
        };
        assert!(moves(1.1) && !moves(0.9));
    }

    #[test]
    fn a_cart_that_comes_to_rest_trips_nothing() {
        assert_eq!(trips_after(1.5, 3.66, 0.2), None);
    }

    #[test]
    fn after_every_drive_the_cart_has_time_to_come_to_rest() {
        let mut watch = OffWatch::new(&Settings::for_rig(&WIRES));
        for _ in 0..3 {
            assert!((0..200_000).all(|_| watch.tick(0.3e-3, 1e-3).is_none()));
            watch.driving();
            for tick in 0..100_000_u32 {
                let t = tick as f32 / 20_000.0;
                let size = 1.5 * 0.89e-3 * libm::expf(-t / 0.2);
                let motion_m = size * libm::sinf(core::f32::consts::TAU * 3.66 * t);
                assert_eq!(watch.tick(0.3e-3 + motion_m, 1e-3), None, "{t} s");
            }
        }
    }
}
