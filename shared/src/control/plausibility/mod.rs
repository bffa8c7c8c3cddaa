//! Plausibility of the sensors against each other and against mechanics: the one place that judges it.
//!
//! | check | measured against | trips | after | origin |
//! |---|---|---|---|---|
//! | distance | displacement at a contact against the believed gap | more than [`FAR_M`] off | [`FAR_PULSES`] contacts in a row | force |
//! | momentum | ∫F dt against the believed reduced mass times the change of speed, both as leaky sums | outside [`momentum::MOMENTUM_RANGE`] | [`BAD_PULSES`] contacts in a row, from the sixteenth on | force |
//! | gross | the same of a single contact | outside [`momentum::GROSS_RANGE`] | [`momentum::GROSS_PULSES`] contacts in a row | force |
//! | zero | mean force of a drive period outside contacts, against the zero of the self test | more than [`ZERO_SHARE`] of `limits.force_n` | [`ZERO_PERIODS`] drive periods in a row | force |
//! | follow | cart amplitude against the command as it was put out, whatever the amplitude loop has made of it | below [`follow::LEAST_FOLLOW`] | [`BAD_PERIODS`] drive periods in a row | cart |
//! | step | the same against what it was before at this frequency | by more than [`follow::STEP_RANGE`] | the same | cart |
//! | ratio | gain of the hammer's sensor over the cart's, from the flights alone ([`crate::sense::identification`]) | outside [`RATIO_RANGE`] | [`RATIO_PERIODS`] drive periods in a row, from [`RATIO_WINDOWS`] windows on | hammer |
//! | target | frequency held in Hold against the newest forecast's target | more than [`TARGET_SHARE`] off | [`TARGET_PERIODS`] drive periods in a row | cart |
//! | sense | lag of the cart behind the command | more than [`follow::LARGEST_LAG`] | the same | cart |
//!
//! Before any of these, a small motion has proven sign and gain of the cart's and the hammer's sensor ([`super::proof`]).
//!
//! What they cannot tell apart: which of the two sensors of a pair has the wrong gain; all three sensors with the same
//! wrong gain from the start on, within what `follow` allows; a cart's sensor that is late from a rig that is not the one
//! believed.

mod follow;
mod momentum;

use crate::fault::{Fault, Origin};
use crate::sense::{Pulse, Strobe};
use crate::settings::Settings;

use super::guard::Trip;
use follow::Follow;
use momentum::Momentum;

#[cfg(test)]
use momentum::MOMENTUM_RANGE;

pub use follow::{BAD_PERIODS, LEAST_FOLLOW};
pub use momentum::BAD_PULSES;

/// Gain of the hammer's sensor over the cart's.
pub const RATIO_RANGE: (f32, f32) = (0.8, 1.2);
/// Drive periods in a row outside that trip.
pub const RATIO_PERIODS: u8 = 16;
/// Windows in flight at full amplitude before the ratio is judged.
pub const RATIO_WINDOWS: u32 = 48;

/// Largest force outside contacts, as a share of the force limit.
pub const ZERO_SHARE: f32 = 0.05;
/// Drive periods in a row beyond it that trip.
pub const ZERO_PERIODS: u8 = 4;

/// Largest distance of the frequency that is held from the forecast's target, relative. A rig whose natural frequency is
/// 10 % off and not identified yet is up to 18 % off.
pub const TARGET_SHARE: f32 = 0.2;
/// Drive periods in a row beyond it that trip: longer than it takes a changed rig to be identified and forecast.
pub const TARGET_PERIODS: u8 = 48;
/// The forecast is for the amplitude that was set: at one further from it, relative, nothing is judged.
const TARGET_AMPLITUDE: f32 = 0.15;

/// Pulses in a row, with the hammer away from the surface, that trip.
pub const FAR_PULSES: u8 = 3;
/// Distance of the hammer from the surface at a contact, m.
pub const FAR_M: f32 = 1.5e-3;

/// The checks and their counts.
#[derive(Clone, Copy, Debug)]
pub struct Plausibility {
    gap_m: f32,
    amplitude_m: f32,
    zero_n: f32,
    bad_zeros: u8,
    bad_targets: u8,
    far_pulses: u8,
    bad_ratios: u8,
    momentum: Momentum,
    follow: Follow,
}

impl Plausibility {
    /// For the rig of `settings`.
    pub fn new(settings: &Settings) -> Self {
        Self {
            gap_m: settings.rig.gap_m as f32,
            amplitude_m: settings.rig.amplitude_m as f32,
            zero_n: ZERO_SHARE * settings.limits.force_n,
            bad_zeros: 0,
            bad_targets: 0,
            far_pulses: 0,
            bad_ratios: 0,
            momentum: Momentum::new(&settings.rig),
            follow: Follow::new(settings.rig.amplitude_m as f32),
        }
    }

    /// The drive starts anew.
    pub fn restart(&mut self) {
        self.far_pulses = 0;
        self.bad_zeros = 0;
        self.bad_targets = 0;
        self.bad_ratios = 0;
        self.momentum.restart();
        self.follow.restart();
    }

    /// The gap as the last contacts have shown it, m: a surface that recedes slowly is followed.
    pub fn believe_gap(&mut self, gap_m: f32) {
        self.gap_m = gap_m;
    }

    /// A contact has ended.
    pub fn pulse(&mut self, pulse: &Pulse) -> Option<Trip> {
        let far_m = libm::fabsf(pulse.relative_m - self.gap_m);
        if run(&mut self.far_pulses, far_m > FAR_M, FAR_PULSES) {
            return trip(Origin::Force, far_m);
        }
        let ratio = self.momentum.pulse(pulse)?;
        // A hammer that bounces the wrong way is the hammer's sensor; which of the two has a wrong gain is not known.
        let origin = if ratio > 0.0 {
            Origin::Force
        } else {
            Origin::Hammer
        };
        trip(origin, ratio)
    }

    /// A drive period at `frequency_hz` has ended, in which the command was `command_m` on average; `rising`: the
    /// amplitude is on its way up.
    pub fn strobe(
        &mut self,
        strobe: &Strobe,
        command_m: f32,
        frequency_hz: f32,
        rising: bool,
    ) -> Option<Trip> {
        let ratio = self
            .follow
            .strobe(strobe, command_m, frequency_hz, rising)?;
        trip(Origin::Cart, ratio)
    }

    /// A drive period has ended with this sum, N, of so many samples of the force outside contacts.
    pub fn free_force(&mut self, (sum_n, samples): (f32, u32)) -> Option<Trip> {
        let mean_n = sum_n / samples.max(1) as f32;
        let off = libm::fabsf(mean_n) > self.zero_n;
        let trips = run(&mut self.bad_zeros, off, ZERO_PERIODS);
        trips.then_some(())?;
        trip(Origin::Force, mean_n)
    }

    /// A drive period has ended with this gain of the hammer's sensor over the cart's, from so many windows.
    pub fn ratio(&mut self, found: Option<(f32, u32)>) -> Option<Trip> {
        let (ratio, windows) = found?;
        let (low, high) = RATIO_RANGE;
        let outside = !(low..=high).contains(&ratio) && windows >= RATIO_WINDOWS;
        let trips = run(&mut self.bad_ratios, outside, RATIO_PERIODS);
        trips.then_some(())?;
        trip(Origin::Hammer, ratio)
    }

    /// A drive period of Hold has ended at `hz`, where the newest forecast has its target at `target_hz`. The frequency
    /// follows the phase of the contacts against the measured cart: one that settles elsewhere has followed a cart's
    /// sensor that is late, or the rig is not the one believed.
    pub fn held(&mut self, strobe: &Strobe, hz: f32, target_hz: f32) -> Option<Trip> {
        let share = hz / target_hz;
        let as_set = libm::fabsf(strobe.amplitude_m / self.amplitude_m - 1.0) <= TARGET_AMPLITUDE;
        let off = libm::fabsf(share - 1.0) > TARGET_SHARE && as_set && target_hz > 0.0;
        let trips = run(&mut self.bad_targets, off, TARGET_PERIODS);
        trips.then_some(())?;
        trip(Origin::Cart, share)
    }

    /// Whether the cart is under suspicion: nothing may be made good by its measured amplitude meanwhile.
    pub fn doubts_the_cart(&self) -> bool {
        self.follow.doubts()
    }
}

/// Counts bad ones in a row; whether there are `length`.
fn run(count: &mut u8, bad: bool, length: u8) -> bool {
    *count = if bad { count.saturating_add(1) } else { 0 };
    *count >= length
}

fn trip(origin: Origin, value: f32) -> Option<Trip> {
    Some(Trip {
        fault: Fault::SensorOutOfFamily,
        origin,
        value,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::params::WIRES;

    fn plausibility() -> Plausibility {
        Plausibility::new(&Settings::for_rig(&WIRES))
    }

    fn trips_after(mut one: impl FnMut(&mut Plausibility) -> Option<Trip>) -> Option<usize> {
        let mut plausibility = plausibility();
        (1..100).find(|_| one(&mut plausibility).is_some())
    }

    fn reduced_kg() -> f32 {
        (WIRES.mass_kg / (1.0 + WIRES.mass_kg / WIRES.cart_mass_kg)) as f32
    }

    #[test]
    fn contacts_no_contact_can_make_trip_and_possible_ones_do_not() {
        let pulse = |ratio: f32| Pulse {
            approach_m_per_s: 0.08,
            rebound_m_per_s: 0.025,
            impulse_n_s: ratio * reduced_kg() * 0.105,
            ..Pulse::default()
        };
        let (low, high) = MOMENTUM_RANGE;
        for (ratio, expected) in [
            (1.02 * high, Some(16)),
            (0.98 * high, None),
            (1.0, None),
            (1.02 * low, None),
            (0.98 * low, Some(16)),
        ] {
            assert_eq!(trips_after(|p| p.pulse(&pulse(ratio))), expected, "{ratio}");
        }
        let at = |relative_m: f32| Pulse {
            relative_m,
            ..pulse(1.0)
        };
        assert_eq!(trips_after(|p| p.pulse(&at(-1.6e-3))), Some(3));
        assert_eq!(trips_after(|p| p.pulse(&at(-1.4e-3))), None);
    }

    #[test]
    fn a_zero_of_the_force_that_moves_trips() {
        let limit_n = Settings::for_rig(&WIRES).limits.force_n;
        for (share, expected) in [(0.052, Some(4)), (-0.052, Some(4)), (0.048, None)] {
            let sum = (share * limit_n * 5000.0, 5000);
            assert_eq!(trips_after(|p| p.free_force(sum)), expected, "{share}");
        }
        assert_eq!(trips_after(|p| p.free_force((0.0, 0))), None);
    }

    #[test]
    fn a_hammer_that_reads_more_or_less_than_the_cart_trips() {
        for (ratio, windows, expected) in [
            (0.79, 48, Some(16)),
            (0.81, 48, None),
            (1.19, 48, None),
            (1.21, 48, Some(16)),
            (-1.0, 48, Some(16)),
            (f32::NAN, 48, Some(16)),
            (-1.0, 47, None),
        ] {
            let tripped = trips_after(|p| p.ratio(Some((ratio, windows))));
            assert_eq!(tripped, expected, "{ratio} {windows}");
        }
        assert_eq!(trips_after(|p| p.ratio(None)), None);
    }

    #[test]
    fn a_hammer_that_flies_from_the_surface_into_it_trips() {
        let reversed = Pulse {
            approach_m_per_s: -0.08,
            rebound_m_per_s: -0.025,
            impulse_n_s: reduced_kg() * 0.105,
            ..Pulse::default()
        };
        assert_eq!(trips_after(|p| p.pulse(&reversed)), Some(6));
    }

    #[test]
    fn one_contact_in_three_that_was_misread_trips_nothing() {
        let mut plausibility = plausibility();
        for k in 0..300 {
            let ratio = if k % 3 == 0 { 1.3 } else { 0.95 };
            let pulse = Pulse {
                approach_m_per_s: 0.08,
                rebound_m_per_s: 0.025,
                impulse_n_s: ratio * reduced_kg() * 0.105,
                ..Pulse::default()
            };
            assert_eq!(plausibility.pulse(&pulse), None);
        }
    }

    fn strobe(ratio: f32, lag_rad: f32) -> Strobe {
        Strobe {
            amplitude_m: ratio * 0.89e-3,
            lag_rad,
            ..Strobe::default()
        }
    }

    #[test]
    fn a_cart_that_does_not_follow_or_goes_the_other_way_trips_and_one_that_droops_does_not() {
        for (ratio, lag, expected) in [
            (0.72, 0.3, None),
            (0.68, 0.3, Some(4)),
            (1.0, 2.0, None),
            (1.0, -2.0, None),
            (1.0, 2.2, Some(4)),
            (1.0, -3.1, Some(4)),
            (5.0, 0.1, None),
        ] {
            let tripped = trips_after(|p| p.strobe(&strobe(ratio, lag), 0.89e-3, 3.6, false));
            assert_eq!(tripped, expected, "{ratio} {lag}");
        }
    }

    #[test]
    fn a_cart_that_follows_less_or_more_from_one_period_to_the_next_trips() {
        for (before, after, expected) in [
            (1.0, 0.84, Some(4)),
            (1.0, 0.87, None),
            (0.9, 0.79, None),
            (1.0, 1.31, Some(4)),
            (1.0, 1.25, None),
        ] {
            let mut plausibility = plausibility();
            for _ in 0..30 {
                assert_eq!(
                    plausibility.strobe(&strobe(before, 0.1), 0.89e-3, 3.6, false),
                    None
                );
            }
            let tripped = (1..50).find(|_| {
                let after = strobe(after, 0.1);
                plausibility.strobe(&after, 0.89e-3, 3.6, false).is_some()
            });
            assert_eq!(tripped, expected, "{before} {after}");
        }
    }

    #[test]
    fn a_frequency_held_far_from_the_forecast_trips() {
        for (hz, amplitude, target_hz, expected) in [
            (1.205, 1.0, 1.0, Some(48)),
            (0.795, 1.0, 1.0, Some(48)),
            (1.195, 1.0, 1.0, None),
            (0.805, 1.0, 1.0, None),
            (1.205, 0.86, 1.0, Some(48)),
            (1.205, 0.84, 1.0, None),
            (1.205, 1.0, 0.0, None),
            (1.205, 1.0, f32::NAN, None),
        ] {
            let tripped =
                trips_after(|p| p.held(&strobe(amplitude, 0.1), 3.6 * hz, 3.6 * target_hz));
            assert_eq!(tripped, expected, "{hz} {amplitude} {target_hz}");
        }
    }

    #[test]
    fn a_shaker_with_a_resonance_may_be_passed() {
        // Its response rises and falls four-fold while the frequency moves by a fifth.
        let mut plausibility = plausibility();
        for k in 0..60_u8 {
            let hz = 3.0 + 0.01 * f32::from(k);
            let off = 2.0 * 4.0 * (hz / 3.3 - 1.0);
            let ratio = 4.0 / libm::sqrtf(1.0 + off * off);
            let tripped = plausibility.strobe(&strobe(ratio, 1.5), 0.89e-3, hz, false);
            assert_eq!(tripped, None, "{hz}");
        }
    }
}
