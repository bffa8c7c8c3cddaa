//! Whether off is off: the cart's motion while the drive is not enabled.
//!
//! The mean of each [`GROUPS`]th of a window of two natural periods is nearly free of noise. The mean distance of these from
//! their own mean shows a motion at any frequency the drive can have, wherever the cart stands; spoilt samples now and then
//! do not show. A hammer that swings shakes a cart that is free, by m/M of its own motion and some more near the resonance
//! of the suspension ([`SHAKEN`]); that is no motion of the drive's.

use crate::settings::{DriveKind, Settings, TICK_RATE_HZ};

/// Groups in a window.
const GROUPS: usize = 64;
/// Parts of the first window at whose end it is looked at, too.
const EARLY: [usize; 3] = [GROUPS / 4, 3 * GROUPS / 8, GROUPS / 2];
/// What is left then of a cart that still coasts on the slowest and least damped of suspensions, in units of A0, per Hz of natural frequency
/// and 1 Hz more: thrown at twice the natural frequency, aside by A0, 0.75 s ago. (0.037 at once, less on average.)
const COASTS: f32 = 0.03;
/// A motion that passes its middle more often than twice this frequency, Hz, is faster than any that still coasts.
const FASTEST_COAST_HZ: f32 = 3.0;
/// Time after the drive has been on in which the cart may come to rest, s: on a shaker's suspension (of a natural frequency
/// from 2 Hz with a damping ratio from 0.35), and with a motor that runs out.
const GRACE_S: (f32, f32) = (0.75, 5.5);
/// Amplitude of the cart that counts as motion, in units of A0.
const MOVES: f32 = 0.125;
/// How often a motion passes its middle in a window at least: a cart that creeps to its rest on a stiff damper passes it once.
const TO_AND_FRO: usize = 2;
/// How far a free cart may move for a swinging hammer, in units of m/M times the hammer's motion.
const SHAKEN: f32 = 2.5;
/// The same of a motion faster than that of a hammer that swings free, which is no longer near the resonance of the suspension.
const SHAKEN_FAST: f32 = 1.25;
/// How often a hammer that swings free passes its middle, over twice in a natural period, at most. One more for where the window begins.
const FREE: f32 = 1.2;
/// Amplitude of a sine over its mean distance from the middle.
const AMPLITUDE: f32 = core::f32::consts::FRAC_PI_2;

/// Watches a drive that is off.
#[derive(Clone, Copy, Debug)]
pub(super) struct OffWatch {
    /// Ticks in a group.
    group: u32,
    largest_m: f32,
    /// What may be left of a cart that coasts, m, and how often one passes its middle in a group, at most.
    coasts_m: f32,
    coast_passages: f32,
    /// No reading counts for more than this, m: it is beyond the rails.
    reach_m: f32,
    /// Ticks of grace, and those of it that are left.
    full_grace: u32,
    grace: u32,
    /// m/M.
    mass_share: f32,
    /// How often a hammer that swings free passes its middle in a group, at most.
    free_passages: f32,
    /// Ticks of the group under way.
    grouped: u32,
    /// Groups of the window under way.
    groups: usize,
    cart: Spread,
    relative: Spread,
    found: Found,
}

/// What is known of the cart since the drive went off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Found {
    /// No whole window has passed.
    Nothing,
    /// It stood still in the last window.
    Still,
    /// It moved in the last whole window, or early in the first: off is not off.
    Moving,
}

impl OffWatch {
    /// For the rig of `settings`.
    pub fn new(settings: &Settings) -> Self {
        let natural_hz = settings.rig.natural_frequency_hz() as f32;
        let window_s = 2.0 / natural_hz.clamp(0.1, 4.0);
        let grace_s = match settings.drive.kind {
            DriveKind::Shaker => GRACE_S.0,
            DriveKind::Motor => GRACE_S.1,
        };
        let rate_hz = TICK_RATE_HZ as f32;
        let grace = (grace_s * rate_hz) as u32;
        let group_s = window_s / GROUPS as f32;
        let a0_m = settings.rig.amplitude_m as f32;
        Self {
            group: (group_s * rate_hz) as u32,
            largest_m: MOVES * a0_m,
            coasts_m: COASTS * (natural_hz + 1.0) * a0_m,
            coast_passages: 2.0 * FASTEST_COAST_HZ * group_s,
            reach_m: 2.0 * settings.trips.cart_m,
            full_grace: grace,
            grace,
            mass_share: (settings.rig.mass_kg / settings.rig.cart_mass_kg) as f32,
            free_passages: 2.0 * FREE * natural_hz * group_s,
            grouped: 0,
            groups: 0,
            cart: Spread::NEW,
            relative: Spread::NEW,
            found: Found::Nothing,
        }
    }

    /// The drive is on.
    #[inline]
    pub fn driving(&mut self) {
        self.grace = self.full_grace;
        self.found = Found::Nothing;
    }

    /// The drive is off, the cart at `cart_m` and the hammer `relative_m` from it. The amplitude of the cart's
    /// motion, m, when that trips.
    #[inline]
    pub fn tick(&mut self, cart_m: f32, relative_m: f32) -> Option<f32> {
        if self.grace == self.full_grace {
            self.begin_window();
        }
        if self.grace > 0 {
            self.grace -= 1;
            // What came to rest within the grace stands still at the end of its window; what has not is judged from here on.
            if self.grace == 0 {
                let (amplitude_m, shaken_m, _) = self.motion();
                if amplitude_m > self.largest_m + shaken_m {
                    self.begin_window();
                }
            }
        }
        self.cart.sum_m += cart_m.max(-self.reach_m).min(self.reach_m);
        self.relative.sum_m += relative_m;
        self.grouped += 1;
        if self.grouped < self.group {
            return None;
        }
        let share = 1.0 / self.grouped as f32;
        self.grouped = 0;
        self.cart.group(self.groups, share);
        self.relative.group(self.groups, share);
        self.groups += 1;
        self.look()
    }

    fn begin_window(&mut self) {
        self.grouped = 0;
        self.groups = 0;
        self.cart.sum_m = 0.0;
        self.relative.sum_m = 0.0;
    }

    /// A group has ended: judges the window at its end, and the first one early, too.
    #[inline(never)]
    fn look(&mut self) -> Option<f32> {
        let whole = self.groups >= GROUPS;
        let early = self.found == Found::Nothing && EARLY.contains(&self.groups);
        if !whole && !early {
            return None;
        }
        let (amplitude_m, shaken_m, passages) = self.motion();
        let is_fast = passages as f32 > self.coast_passages * self.groups as f32 + 1.0;
        let coasts_m = if whole || is_fast { 0.0 } else { self.coasts_m };
        let far = amplitude_m > self.largest_m + coasts_m + shaken_m;
        let moves = far && passages >= TO_AND_FRO;
        if whole {
            self.begin_window();
        }
        match (moves, whole) {
            // It may still coast.
            (true, _) if self.grace > 0 => return None,
            (true, _) => self.found = Found::Moving,
            (false, true) => self.found = Found::Still,
            (false, false) => {}
        }
        moves.then_some(amplitude_m)
    }

    /// The amplitude of the cart's motion in the groups so far, m, how much of it a swinging hammer may have made, and how often it passed its
    /// middle. Two ask for it: one copy is enough.
    #[inline(never)]
    fn motion(&self) -> (f32, f32, usize) {
        let (amplitude_m, passages) = self.cart.motion(self.groups);
        let (swing_m, _) = self.relative.motion(self.groups);
        let is_free = passages as f32 <= self.free_passages * self.groups as f32 + 1.0;
        let shaken = if is_free { SHAKEN } else { SHAKEN_FAST } * self.mass_share;
        (amplitude_m, shaken * swing_m, passages)
    }

    /// Whether the drive went off so recently that the cart may still coast.
    pub fn may_coast(&self) -> bool {
        self.grace > 0
    }

    /// Whether the cart moves with the drive off.
    pub fn is_moving(&self) -> bool {
        self.found == Found::Moving
    }

    /// Whether the cart is known to stand still.
    pub fn is_still(&self) -> bool {
        self.found == Found::Still
    }
}

/// A signal's means of groups.
#[derive(Clone, Copy, Debug)]
struct Spread {
    /// Sum of the group under way.
    sum_m: f32,
    means_m: [f32; GROUPS],
}

impl Spread {
    const NEW: Self = Self {
        sum_m: 0.0,
        means_m: [0.0; GROUPS],
    };

    /// Group `k`, of 1/`share` ticks, ends.
    fn group(&mut self, k: usize, share: f32) {
        if let Some(mean_m) = self.means_m.get_mut(k) {
            *mean_m = self.sum_m * share;
        }
        self.sum_m = 0.0;
    }

    /// The amplitude of a sine of the spread of the first `count` groups about their mean, and how often they pass it.
    #[inline(never)]
    fn motion(&self, count: usize) -> (f32, usize) {
        let means = || self.means_m.iter().take(count);
        let share = 1.0 / count as f32;
        let middle_m = share * means().sum::<f32>();
        let distances = means().map(|mean_m| libm::fabsf(mean_m - middle_m));
        let above = || means().map(|mean_m| *mean_m > middle_m);
        let passages = above().zip(above().skip(1)).filter(|(a, b)| a != b);
        (AMPLITUDE * share * distances.sum::<f32>(), passages.count())
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
            // What runs on; the slower motion has not come to and fro by then.
            let seconds = trips_after(1.0, hz, 1e9).unwrap();
            assert!(
                seconds < if hz < 2.0 { 1.9 } else { 1.2 },
                "{hz}: {seconds}"
            );
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
        // 3 mm of swing: 0.111 mm and 2.5 m/M of that are 0.526 mm, 1.25 m/M, where it is faster than a free swing, 0.319 mm.
        for (natural, least_m) in [(0.9, 0.526e-3), (1.1, 0.526e-3), (2.0, 0.319e-3)] {
            let hz = natural * WIRES.natural_frequency_hz() as f32;
            let moves = |share: f32| {
                let mut watch = OffWatch::new(&Settings::for_rig(&WIRES));
                (0..200_000_u32).any(|tick| {
                    let sin = libm::sinf(core::f32::consts::TAU * hz * tick as f32 / 20_000.0);
                    watch.tick(share * least_m * sin, 3e-3 * sin).is_some()
                })
            };
            assert!(moves(1.1) && !moves(0.9), "{natural}");
        }
    }

    /// A heavy hammer struck by a drive that runs on: its own large motion hid the cart's for good.
    #[test]
    fn a_drive_that_runs_on_is_found_beside_a_heavy_hammer() {
        let mut rig = WIRES;
        rig.cart_mass_kg = 10.0 * rig.mass_kg;
        let mut watch = OffWatch::new(&Settings::for_rig(&rig));
        let hz = 2.0 * rig.natural_frequency_hz() as f32;
        let a0 = rig.amplitude_m as f32;
        watch.driving();
        let found = (0..400_000_u32).find(|tick| {
            let sin = libm::sinf(core::f32::consts::TAU * hz * *tick as f32 / 20_000.0);
            watch.tick(a0 * sin, 4.0 * a0 * sin).is_some()
        });
        assert!(found.is_some_and(|tick| tick < 38_000), "{found:?}");
    }

    #[test]
    fn a_cart_that_comes_to_rest_trips_nothing() {
        assert_eq!(trips_after(1.5, 3.66, 0.2), None);
    }

    /// Thrown at speed and coasting on its suspension, of whatever frequency, aside of where it comes to rest: on every rig.
    #[test]
    fn a_cart_that_coasts_trips_nothing_whatever_the_rig() {
        for (_, rig) in crate::model::params::PRESETS {
            for (hz, damping) in [
                (2.0_f32, 0.35_f32),
                (2.0, 0.7),
                (5.0, 0.5),
                (5.0, 1.5),
                (0.5, 1.5),
            ] {
                for aside in [-1.0_f32, 0.3, 1.0] {
                    let settings = Settings::for_rig(&rig);
                    let a0 = rig.amplitude_m as f32;
                    let omega = core::f32::consts::TAU * hz;
                    let drive = core::f32::consts::TAU * 2.0 * rig.natural_frequency_hz() as f32;
                    let mut watch = OffWatch::new(&settings);
                    watch.driving();
                    let (mut y, mut v) = (aside * a0, drive * a0);
                    for tick in 0..60_000 {
                        v -= (omega * omega * y + 2.0 * damping * omega * v) / 20_000.0;
                        y += v / 20_000.0;
                        let told = watch.tick(0.4e-3 + y, 0.0);
                        assert_eq!(told, None, "{hz} {damping} {aside} {tick}");
                    }
                    assert!(watch.is_still());
                }
            }
        }
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
