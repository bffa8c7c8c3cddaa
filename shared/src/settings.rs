//! Everything the controller must be told: the rig it believes in, how its sensors and its shaker are
//! calibrated, limits and trip levels. Checked as a whole, then swapped as a whole.

use core::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use crate::io::Channel;
use crate::model::params::{ParamError, RigParams};

/// Control ticks per second: one sample and one set-point each.
pub const TICK_RATE_HZ: u32 = 20_000;

/// Length of a control tick, s.
pub const TICK_S: f64 = 1.0 / TICK_RATE_HZ as f64;

/// Whole control ticks in a time, s.
pub(crate) fn ticks_of(seconds: f32) -> u32 {
    (seconds * TICK_RATE_HZ as f32) as u32
}

/// What moves the cart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum DriveKind {
    /// A shaker with a position loop: a set-point per tick through the DAC.
    Shaker,
    /// A motor with an eccentric: a frequency set-point; the amplitude is the mechanism's.
    Motor,
}

/// The drive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DriveSettings {
    /// What moves the cart.
    pub kind: DriveKind,
    /// Cart displacement per DAC code, m.
    pub m_per_code: f32,
    /// Fastest change of frequency, Hz/s.
    pub frequency_slew_hz_per_s: f32,
    /// Fastest change of amplitude, m/s.
    pub amplitude_slew_m_per_s: f32,
}

/// Limits: what would pass them is clamped and reported. They are no faults.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Largest contact force held, N: the amplitude is drawn back until the force is below.
    pub force_n: f32,
    /// Largest hammer displacement relative to the cart held, m: the amplitude is drawn back.
    pub travel_m: f32,
    /// Lowest drive frequency, Hz.
    pub min_frequency_hz: f32,
    /// Highest drive frequency, Hz.
    pub max_frequency_hz: f32,
    /// Largest commanded cart amplitude, m.
    pub amplitude_m: f32,
}

/// Trip levels: what passes them switches the drive off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trips {
    /// Contact force, N.
    pub force_n: f32,
    /// Hammer displacement relative to the cart, m.
    pub travel_m: f32,
    /// Cart displacement, m.
    pub cart_m: f32,
    /// How long no contact may be felt where the forecast has one, s.
    pub no_contact_s: f32,
    /// How long the regime may stay lost while it is sought again, s.
    pub regime_lost_s: f32,
    /// How long the link may be silent while it is in command, s; 0: for ever.
    pub link_timeout_s: f32,
}

/// Contact detection on the force signal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Detection {
    /// A contact begins above this force, N.
    pub on_n: f32,
    /// It may end below this one, N.
    pub off_n: f32,
    /// And ends once the force has stayed below it this long, s: longer than the surface's ringing.
    pub refractory_s: f32,
}

/// Everything the controller must be told.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// The rig as it is believed to be; its `amplitude_m` is the amplitude held.
    pub rig: RigParams,
    /// Force sensor, N.
    pub force: Channel,
    /// Hammer displacement sensor, fixed frame, m.
    pub hammer: Channel,
    /// Cart displacement sensor, fixed frame, m.
    pub cart: Channel,
    /// The drive.
    pub drive: DriveSettings,
    /// Limits.
    pub limits: Limits,
    /// Trip levels.
    pub trips: Trips,
    /// Contact detection.
    pub detection: Detection,
}

/// Peak force of a strong 1/1 at a gap of 0.0 mm in units of A0 ω √(ki m): 96 N on the wires of Tables
/// 3.1 and 3.2 (`host-sim pick`), and the same for the beams, whose force grows with ω.
const STRONG_FORCE: f64 = 7.4;

/// ki of Table 3.1, N/m; the nonlinear laws' presets make the same contact, in other units.
const CONTACT_STIFFNESS: f64 = 5.5e6;

impl Settings {
    /// Settings for a rig with sensors and a shaker that suit it: force to about five times the strongest 1/1,
    /// displacements ±12 mm (hammer) and ±2.5 mm (cart), a shaker of ±2.5 mm.
    pub fn for_rig(rig: &RigParams) -> Self {
        let omega = TAU * rig.natural_frequency_hz();
        let strong =
            STRONG_FORCE * rig.amplitude_m * omega * libm::sqrt(CONTACT_STIFFNESS * rig.mass_kg);
        let strong_n = strong as f32;
        let natural_hz = rig.natural_frequency_hz() as f32;
        let amplitude_m = rig.amplitude_m as f32;
        let displacement = |full_m: f32| Channel {
            zero_code: 2048.0,
            unit_per_code: full_m / 1900.0,
        };
        Self {
            rig: *rig,
            force: Channel {
                zero_code: 600.0,
                unit_per_code: 5.0 * strong_n / 3300.0,
            },
            hammer: displacement(12e-3),
            cart: displacement(2.5e-3),
            drive: DriveSettings {
                kind: DriveKind::Shaker,
                m_per_code: 2.5e-3 / 2047.0,
                frequency_slew_hz_per_s: 0.05 * natural_hz,
                amplitude_slew_m_per_s: amplitude_m,
            },
            limits: Limits {
                force_n: 2.5 * strong_n,
                travel_m: 8e-3,
                min_frequency_hz: 0.75 * natural_hz,
                max_frequency_hz: 4.0 * natural_hz,
                amplitude_m: 1.5 * amplitude_m,
            },
            trips: Trips {
                force_n: 4.0 * strong_n,
                travel_m: 10e-3,
                cart_m: 2.0e-3,
                no_contact_s: 5.0,
                regime_lost_s: 60.0,
                link_timeout_s: 2.0,
            },
            detection: Detection {
                on_n: 0.15 * strong_n,
                off_n: 0.08 * strong_n,
                refractory_s: 1.5e-3,
            },
        }
    }

    /// Whether these settings can be run with.
    ///
    /// # Errors
    /// The first setting out of range, named with its unit.
    pub fn check(&self) -> Result<(), ParamError> {
        self.rig.check()?;
        let positive = "a positive number";
        let range = |key, value: f32, from: f32, to: f32, must_be| {
            let good = value.is_finite() && value >= from && value <= to;
            (key, value, good, must_be)
        };
        let amplitude_m = self.rig.amplitude_m as f32;
        let Self {
            force,
            hammer,
            cart,
            drive,
            limits,
            trips,
            detection,
            ..
        } = self;
        let channel = |key, unit: f32| {
            let size = unit.abs();
            let good = size.is_finite() && size > 0.0;
            (key, unit, good, "a number other than 0")
        };
        let zero = |key, code: f32| range(key, code, 124.0, 3971.0, "a code from 124 to 3971");
        let tiny = f32::MIN_POSITIVE;
        let checks = [
            channel("force.unit_per_code", force.unit_per_code),
            channel("hammer.unit_per_code", hammer.unit_per_code),
            channel("cart.unit_per_code", cart.unit_per_code),
            zero("force.zero_code", force.zero_code),
            zero("hammer.zero_code", hammer.zero_code),
            zero("cart.zero_code", cart.zero_code),
            range("drive.m_per_code", drive.m_per_code, tiny, 1e-3, positive),
            range(
                "drive.frequency_slew_hz_per_s",
                drive.frequency_slew_hz_per_s,
                1e-3,
                1e3,
                "0.001 to 1000",
            ),
            range(
                "drive.amplitude_slew_m_per_s",
                drive.amplitude_slew_m_per_s,
                1e-6,
                1.0,
                "1e-6 to 1",
            ),
            range("limits.force_n", limits.force_n, tiny, 1e6, positive),
            range("limits.travel_m", limits.travel_m, tiny, 1.0, positive),
            range(
                "limits.min_frequency_hz",
                limits.min_frequency_hz,
                0.05,
                500.0,
                "0.05 to 500",
            ),
            range(
                "limits.max_frequency_hz",
                limits.max_frequency_hz,
                limits.min_frequency_hz,
                500.0,
                "from limits.min_frequency_hz to 500",
            ),
            range(
                "limits.amplitude_m",
                limits.amplitude_m,
                amplitude_m,
                2047.0 * drive.m_per_code,
                "from the rig's amplitude to what the DAC reaches",
            ),
            range(
                "trips.force_n",
                trips.force_n,
                limits.force_n,
                1e6,
                "at least limits.force_n",
            ),
            range(
                "trips.travel_m",
                trips.travel_m,
                limits.travel_m,
                1.0,
                "at least limits.travel_m",
            ),
            range(
                "trips.cart_m",
                trips.cart_m,
                limits.amplitude_m,
                1.0,
                "at least limits.amplitude_m",
            ),
            range(
                "trips.no_contact_s",
                trips.no_contact_s,
                0.1,
                3600.0,
                "0.1 to 3600",
            ),
            range(
                "trips.regime_lost_s",
                trips.regime_lost_s,
                1.0,
                3600.0,
                "1 to 3600",
            ),
            range(
                "trips.link_timeout_s",
                trips.link_timeout_s,
                0.0,
                3600.0,
                "0 to 3600",
            ),
            range(
                "detection.on_n",
                detection.on_n,
                tiny,
                limits.force_n,
                "positive, at most limits.force_n",
            ),
            range(
                "detection.off_n",
                detection.off_n,
                tiny,
                detection.on_n,
                "positive, at most detection.on_n",
            ),
            range(
                "detection.refractory_s",
                detection.refractory_s,
                2e-4,
                2e-2,
                "0.0002 to 0.02",
            ),
        ];
        match checks.iter().find(|(_, _, good, _)| !good) {
            None => Ok(()),
            Some(&(key, value, _, must_be)) => Err(ParamError {
                key,
                value: f64::from(value),
                must_be,
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::params::PRESETS;

    #[test]
    fn defaults_of_every_rig_pass_and_what_is_out_of_range_is_named() {
        for (name, rig) in PRESETS {
            assert_eq!(Settings::for_rig(&rig).check(), Ok(()), "{name}");
        }
        let mut settings = Settings::for_rig(&PRESETS[0].1);
        settings.trips.force_n = f32::NAN;
        assert_eq!(settings.check().unwrap_err().key, "trips.force_n");
        settings.rig.mass_kg = -1.0;
        assert!(settings.check().unwrap_err().key.starts_with("mass"));
    }
}
