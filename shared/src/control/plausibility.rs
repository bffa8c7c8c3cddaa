//! Plausibility of the sensors, against each other and against mechanics, once per contact or drive period.

use crate::fault::{Fault, Origin};
use crate::sense::{Pulse, Strobe};
use crate::settings::Settings;

use super::guard::Trip;

/// Pulses in a row, with an impulse that no contact of that speed can have, that trip.
pub const BAD_PULSES: u8 = 8;
/// Pulses in a row, with the hammer away from the surface, that trip.
pub const FAR_PULSES: u8 = 3;
/// Drive periods in a row, in which the cart does not follow, that trip.
pub const BAD_PERIODS: u8 = 4;
/// Plausible impulse over m v. It is 1 + e, between 1 and 2 on any surface; the margin is for the sensors.
pub const IMPULSE_RANGE: (f32, f32) = (0.6, 2.8);
/// Measured over commanded cart amplitude.
pub const FOLLOW_RANGE: (f32, f32) = (0.5, 1.6);
/// Distance of the hammer from the surface at a contact, m.
pub const FAR_M: f32 = 1.5e-3;

/// The checks and their counts.
#[derive(Clone, Copy, Debug)]
pub struct Plausibility {
    mass_kg: f32,
    gap_m: f32,
    bad_pulses: u8,
    far_pulses: u8,
    bad_periods: u8,
}

impl Plausibility {
    /// For the rig of `settings`.
    pub fn new(settings: &Settings) -> Self {
        Self {
            mass_kg: settings.rig.mass_kg as f32,
            gap_m: settings.rig.gap_m as f32,
            bad_pulses: 0,
            far_pulses: 0,
            bad_periods: 0,
        }
    }

    /// The drive starts anew.
    pub fn restart(&mut self) {
        self.bad_pulses = 0;
        self.far_pulses = 0;
        self.bad_periods = 0;
    }

    /// A contact has ended.
    pub fn pulse(&mut self, pulse: &Pulse) -> Option<Trip> {
        let far_m = libm::fabsf(pulse.relative_m - self.gap_m);
        let far = run(&mut self.far_pulses, far_m > FAR_M, FAR_PULSES);
        if far {
            return trip(Origin::Force, far_m);
        }
        let momentum = self.mass_kg * pulse.approach_m_per_s;
        // Without an approach speed the impulse cannot be judged.
        if momentum <= 0.0 {
            return None;
        }
        let ratio = pulse.impulse_n_s / momentum;
        let outside = !(IMPULSE_RANGE.0..=IMPULSE_RANGE.1).contains(&ratio);
        let bad = run(&mut self.bad_pulses, outside, BAD_PULSES);
        if bad {
            trip(Origin::Force, ratio)
        } else {
            None
        }
    }

    /// A drive period at a settled command of `command_m`.
    pub fn strobe(&mut self, strobe: &Strobe, command_m: f32) -> Option<Trip> {
        if command_m <= 0.0 {
            return None;
        }
        let ratio = strobe.amplitude_m / command_m;
        let outside = !(FOLLOW_RANGE.0..=FOLLOW_RANGE.1).contains(&ratio);
        let bad = run(&mut self.bad_periods, outside, BAD_PERIODS);
        if bad { trip(Origin::Cart, ratio) } else { None }
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

    #[test]
    fn contacts_no_contact_can_make_trip_and_possible_ones_do_not() {
        let pulse = |ratio: f32| Pulse {
            approach_m_per_s: 0.08,
            impulse_n_s: ratio * 0.298 * 0.08,
            ..Pulse::default()
        };
        let at = |relative_m: f32| Pulse {
            relative_m,
            ..pulse(1.3)
        };
        for (ratio, expected) in [(2.9, Some(8)), (2.7, None), (0.61, None), (0.59, Some(8))] {
            assert_eq!(trips_after(|f| f.pulse(&pulse(ratio))), expected, "{ratio}");
        }
        assert_eq!(trips_after(|f| f.pulse(&at(-1.6e-3))), Some(3));
        assert_eq!(trips_after(|f| f.pulse(&at(-1.4e-3))), None);
    }

    #[test]
    fn a_cart_that_does_not_follow_trips_and_one_that_droops_does_not() {
        let strobe = |ratio: f32| Strobe {
            amplitude_m: ratio * 0.89e-3,
            ..Strobe::default()
        };
        for (ratio, expected) in [(1.65, Some(4)), (1.55, None), (0.55, None), (0.45, Some(4))] {
            let tripped = trips_after(|f| f.strobe(&strobe(ratio), 0.89e-3));
            assert_eq!(tripped, expected, "{ratio}");
        }
    }
}
