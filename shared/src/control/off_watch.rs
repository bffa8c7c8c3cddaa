//! Whether off is off: the cart's motion while the drive is not enabled.
//!
//! The mean of each [`GROUP`] samples is free of noise. Their spread over a natural period shows a motion at any
//! frequency the drive can have. A cart that is let go comes to rest on its suspension within the grace time;
//! the blows of a hammer that still swings move it by less than the threshold.

use crate::settings::{DriveKind, Settings, TICK_RATE_HZ};

/// Samples averaged, 3.2 ms.
const GROUP: u8 = 64;
/// Windows after the drive has been on in which the cart may come to rest: on a shaker's suspension, and with a motor
/// that runs out.
const GRACE: (u8, u8) = (1, 10);
/// Spread of the cart's displacement that counts as motion, in units of A0: an amplitude of an eighth of A0.
const MOVES: f32 = 0.25;
/// Windows in a row with motion that trip.
pub const MOVING_WINDOWS: u8 = 2;

/// Watches a drive that is off.
#[derive(Clone, Copy, Debug)]
pub(super) struct OffWatch {
    /// Ticks of a window: one natural period, at least 0.5 s.
    window: u32,
    spread_m: f32,
    ticks: u32,
    /// Windows of grace, and those of it that are left.
    full_grace: u8,
    grace: u8,
    sum_m: f32,
    grouped: u8,
    lowest_m: f32,
    highest_m: f32,
    moving: u8,
}

impl OffWatch {
    /// For the rig of `settings`.
    pub fn new(settings: &Settings) -> Self {
        let natural_hz = (settings.rig.natural_frequency_hz() as f32).clamp(0.1, 2.0);
        let grace = match settings.drive.kind {
            DriveKind::Shaker => GRACE.0,
            DriveKind::Motor => GRACE.1,
        };
        Self {
            window: (TICK_RATE_HZ as f32 / natural_hz) as u32,
            spread_m: MOVES * settings.rig.amplitude_m as f32,
            ticks: 0,
            full_grace: grace,
            grace,
            sum_m: 0.0,
            grouped: 0,
            lowest_m: f32::MAX,
            highest_m: f32::MIN,
            moving: 0,
        }
    }

    /// The drive is on.
    #[inline]
    pub fn driving(&mut self) {
        self.ticks = 0;
        self.grace = self.full_grace;
        self.moving = 0;
        self.begin();
    }

    /// The drive is off and the cart at `cart_m`. The spread of its motion, m, when that trips.
    #[inline]
    pub fn tick(&mut self, cart_m: f32) -> Option<f32> {
        self.sum_m += cart_m;
        self.grouped += 1;
        self.ticks += 1;
        if self.grouped < GROUP {
            return None;
        }
        let mean_m = self.sum_m * (1.0 / GROUP as f32);
        self.sum_m = 0.0;
        self.grouped = 0;
        self.lowest_m = self.lowest_m.min(mean_m);
        self.highest_m = self.highest_m.max(mean_m);
        if self.ticks < self.window {
            return None;
        }
        self.ticks = 0;
        let spread_m = self.highest_m - self.lowest_m;
        let moves = spread_m > self.spread_m && self.grace == 0;
        self.grace = self.grace.saturating_sub(1);
        self.moving = if moves {
            self.moving.saturating_add(1)
        } else {
            0
        };
        self.begin();
        self.is_moving().then_some(spread_m)
    }

    /// Whether the cart moves with the drive off.
    pub fn is_moving(&self) -> bool {
        self.moving >= MOVING_WINDOWS
    }

    fn begin(&mut self) {
        self.sum_m = 0.0;
        self.grouped = 0;
        self.lowest_m = f32::MAX;
        self.highest_m = f32::MIN;
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
            let moved = watch.tick(0.3e-3 + 0.89e-3 * motion);
            moved.map(|_| t)
        })
    }

    #[test]
    fn a_cart_that_moves_with_the_drive_off_is_found_and_one_below_the_threshold_is_not() {
        for hz in [1.4, 3.66, 7.3] {
            let seconds = trips_after(0.135, hz, 1e9).unwrap();
            assert!(seconds < 1.8, "{hz}: {seconds}");
            assert_eq!(trips_after(0.115, hz, 1e9), None, "{hz}");
        }
    }

    #[test]
    fn a_cart_that_comes_to_rest_trips_nothing() {
        assert_eq!(trips_after(1.5, 3.66, 0.2), None);
    }
}
