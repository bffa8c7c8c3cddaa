//! The ranges of the settings.

use super::{Calibration, Detection, DriveSettings, Limits, Settings, Trips, strong_force_n};
use crate::io::{DAC_REACH, HIGH_RAIL, LOW_RAIL};
use crate::model::cart::CartDrive;
use crate::model::params::{ParamError, RigParams};

impl Settings {
    /// Whether these settings can be run with.
    ///
    /// # Errors
    /// If a setting is out of range: the first such, named with its unit.
    pub fn check(&self) -> Result<(), ParamError> {
        self.rig.check()?;
        check_shaker(&self.rig)?;
        self.check_sensors()?;
        self.check_calibrations()?;
        self.check_drive()?;
        self.check_limits()?;
        self.check_detection()?;
        self.check_trips()?;
        self.check_aim()
    }

    /// The lowest force that can be wanted, or kept as a limit, N.
    pub fn least_force_n(&self) -> f32 {
        SEEN * self.detection.on_n
    }

    /// Contacts that are hardly detected cannot be drawn to a force: some of them are missed.
    fn check_aim(&self) -> Result<(), ParamError> {
        let wanted_n = self.aim.force_n;
        let least_n = self.least_force_n();
        let must_be =
            "0, or at least twice detection.on_n and at most limits.force_n, so that it is seen";
        if wanted_n == 0.0 || (least_n..=self.limits.force_n).contains(&wanted_n) {
            return Ok(());
        }
        Err(out_of_range("aim.force_n", wanted_n, must_be))
    }

    fn check_sensors(&self) -> Result<(), ParamError> {
        // Coarser than this, a sensor cannot tell a motion from rest.
        let step_m = self.rig.amplitude_m as f32 / CODES_OF_A_MOTION;
        let unit = self.force.unit_per_code;
        if !(FINEST..=COARSEST_N).contains(&unit) {
            let must_be =
                "positive (swap the wires of a sensor that reads blows as pulls), at most 1000 N";
            return Err(out_of_range("force.n_per_code", unit, must_be));
        }
        for (key, channel) in [
            ("hammer.m_per_code", &self.hammer),
            ("cart.m_per_code", &self.cart),
        ] {
            let unit = channel.unit_per_code;
            let size = libm::fabsf(unit);
            if !(size >= FINEST && size <= step_m) {
                let must_be = "at most a sixteenth of the rig's amplitude, either sign, and not 0";
                return Err(out_of_range(key, unit, must_be));
            }
        }
        let codes = (f32::from(LOW_RAIL.0), f32::from(HIGH_RAIL.0));
        all_within(&[
            ("force.zero_code", self.force.zero_code, codes, CODE),
            ("hammer.zero_code", self.hammer.zero_code, codes, CODE),
            ("cart.zero_code", self.cart.zero_code, codes, CODE),
        ])
    }

    fn check_calibrations(&self) -> Result<(), ParamError> {
        for (
            day_key,
            share_key,
            Calibration {
                day,
                uncertainty_percent: share,
            },
        ) in [
            (
                "force.calibrated",
                "force.uncertainty_percent",
                self.calibration.force,
            ),
            (
                "hammer.calibrated",
                "hammer.uncertainty_percent",
                self.calibration.hammer,
            ),
            (
                "cart.calibrated",
                "cart.uncertainty_percent",
                self.calibration.cart,
            ),
        ] {
            let (year, month, date) = (day / 10_000, day / 100 % 100, day % 100);
            let dated = (2000..2100).contains(&year)
                && (1..=12).contains(&month)
                && (1..=31).contains(&date);
            if day != 0 && !dated {
                let must_be = "a day of this century, such as \"2026-11-23\", or \"never\"";
                return Err(ParamError {
                    key: day_key,
                    value: f64::from(day),
                    must_be,
                });
            }
            if !(0.0..=100.0).contains(&share) {
                return Err(out_of_range(share_key, share, "0 (not known) to 100"));
            }
        }
        Ok(())
    }

    fn check_drive(&self) -> Result<(), ParamError> {
        let DriveSettings {
            m_per_code,
            frequency_slew_hz_per_s: hz_per_s,
            amplitude_slew_m_per_s: m_per_s,
            ..
        } = self.drive;
        let (step, slew) = ((TINY, 1e-3), "drive.frequency_slew_hz_per_s");
        all_within(&[
            ("drive.m_per_code", m_per_code, step, POSITIVE),
            (slew, hz_per_s, (1e-3, 1e3), "0.001 to 1000"),
            (
                "drive.amplitude_slew_m_per_s",
                m_per_s,
                (1e-6, 1.0),
                "1e-6 to 1",
            ),
        ])
    }

    fn check_limits(&self) -> Result<(), ParamError> {
        let Limits {
            force_n,
            travel_m,
            min_frequency_hz: min_hz,
            max_frequency_hz: max_hz,
            amplitude_m,
        } = self.limits;
        let amplitudes = (
            self.rig.amplitude_m as f32,
            f32::from(DAC_REACH) * self.drive.m_per_code,
        );
        let from_min = "from limits.min_frequency_hz to 500";
        let reach = "from the rig's amplitude to what the DAC reaches";
        all_within(&[
            ("limits.force_n", force_n, (TINY, 1e6), POSITIVE),
            ("limits.travel_m", travel_m, (TINY, 1.0), POSITIVE),
            (
                "limits.min_frequency_hz",
                min_hz,
                (0.05, 500.0),
                "0.05 to 500",
            ),
            ("limits.max_frequency_hz", max_hz, (min_hz, 500.0), from_min),
            ("limits.amplitude_m", amplitude_m, amplitudes, reach),
        ])
    }

    fn check_trips(&self) -> Result<(), ParamError> {
        let Trips {
            force_n,
            travel_m,
            cart_m,
            no_contact_s,
            regime_lost_s,
            link_timeout_s,
        } = self.trips;
        let silence = if self.operator.heartbeat {
            (
                (TINY, 3600.0),
                "above 0 with operator.heartbeat, at most 3600",
            )
        } else {
            ((0.0, 3600.0), "0 to 3600")
        };
        let limits = &self.limits;
        let range = |limit: f32, reach: f32| (limit, reach.min(TRIP_OVER_LIMIT * limit));
        let force = range(limits.force_n, REACHED * self.force.reach().1);
        // The hammer's sensor sees x = y + travel: the cart's own motion comes on top, in either direction.
        let far_m = REACHED * either_way(self.hammer.reach()) - limits.amplitude_m;
        let travel = range(limits.travel_m, far_m);
        let cart = range(limits.amplitude_m, REACHED * either_way(self.cart.reach()));
        all_within(&[
            (
                "trips.force_n",
                force_n,
                force,
                "at least limits.force_n, at most 20 times that and 95 % of what the force sensor can measure",
            ),
            (
                "trips.travel_m",
                travel_m,
                travel,
                "at least limits.travel_m, at most 20 times that and, with limits.amplitude_m, 95 % of what the hammer's sensor can measure",
            ),
            (
                "trips.cart_m",
                cart_m,
                cart,
                "at least limits.amplitude_m, at most 20 times that and 95 % of what the cart's sensor can measure",
            ),
            ("trips.no_contact_s", no_contact_s, (1.0, 30.0), "1 to 30"),
            (
                "trips.regime_lost_s",
                regime_lost_s,
                (10.0, 300.0),
                "10 to 300",
            ),
            ("trips.link_timeout_s", link_timeout_s, silence.0, silence.1),
        ])
    }

    fn check_detection(&self) -> Result<(), ParamError> {
        let Detection {
            on_n,
            off_n,
            refractory_s,
        } = self.detection;
        let least_n = (CODES_OF_A_CONTACT * self.force.unit_per_code).max(TINY);
        let strong_n = strong_force_n(&self.rig) as f32;
        let (on, off) = (
            (least_n, self.limits.force_n.min(0.5 * strong_n)),
            (TINY, on_n),
        );
        let key = "detection.refractory_s";
        all_within(&[
            (
                "detection.on_n",
                on_n,
                on,
                "at least 8 codes of the force sensor, at most limits.force_n and half a strong contact's",
            ),
            (
                "detection.off_n",
                off_n,
                off,
                "positive, at most detection.on_n",
            ),
            (key, refractory_s, (2e-4, 2e-2), "0.0002 to 0.02"),
        ])?;
        // Of blows nearer to the threshold so much is cut off that their peak and their momentum contradict each other.
        let limit_n = self.limits.force_n;
        if limit_n < self.least_force_n() {
            let must_be = "at least twice detection.on_n: a lower one cannot be kept";
            return Err(out_of_range("limits.force_n", limit_n, must_be));
        }
        Ok(())
    }
}

/// Whether the controller can make forecasts of `rig` with its shaker. Those allowed are narrower than the model's: the steps
/// of a forecast must follow the loop, and its ringing must die away within some drive periods.
///
/// # Errors
/// If a value of the shaker is out of range: the first such.
pub fn check_shaker(rig: &RigParams) -> Result<(), ParamError> {
    let CartDrive::Loop(held) = &rig.cart else {
        return Ok(());
    };
    let (slowest_hz, fastest_hz) = LOOP_HZ;
    let (hz, damping) = (held.frequency_hz, held.damping_ratio);
    let error = |key, value, must_be| {
        Err(ParamError {
            key,
            value,
            must_be,
        })
    };
    if !(LOOP_DAMPING.0..=LOOP_DAMPING.1).contains(&damping) {
        let must_be = "0.05 to 5 for the controller";
        return error("shaker_damping_ratio", damping, must_be);
    }
    if !(hz >= slowest_hz && hz * held.swiftness() <= fastest_hz) {
        let must_be = "1 to 500 for the controller, or \"prescribed\"; with a damping ratio z above 1 at most 500/(z + sqrt(z^2 - 1))";
        return error("shaker_loop_hz", hz, must_be);
    }
    if rig.cart_mass_kg < LIGHTEST_CART * rig.mass_kg {
        let must_be = "at least a fifth of mass_kg where shaker_loop_hz is given";
        return error("cart_mass_kg", rig.cart_mass_kg, must_be);
    }
    Ok(())
}

/// Slowest position loop, and fastest root of one, Hz.
const LOOP_HZ: (f64, f64) = (1.0, 500.0);
/// Lowest and highest damping ratio of a position loop.
const LOOP_DAMPING: (f64, f64) = (0.05, 5.0);
/// Least mass of a cart that recoils, in hammers.
const LIGHTEST_CART: f64 = 0.2;
/// A force wanted, and a limit of the force, is at least this many times the force of detection.
const SEEN: f32 = 2.0;
/// Share of a sensor's range that a trip level may use: the rest is for its offset.
const REACHED: f32 = 0.95;
/// A trip level is at most this many times its limit: one far above guards nothing that the limit does not.
const TRIP_OVER_LIMIT: f32 = 20.0;
/// Fewest codes of the force at which a contact begins.
const CODES_OF_A_CONTACT: f32 = 8.0;
/// Fewest codes of the amplitude held.
const CODES_OF_A_MOTION: f32 = 16.0;
/// Largest size of a code of the force, N.
const COARSEST_N: f32 = 1e3;
/// Least size of a code, N or m.
const FINEST: f32 = 1e-12;

/// What a displacement sensor of this range measures in both directions, m.
fn either_way((lowest, highest): (f32, f32)) -> f32 {
    highest.min(-lowest)
}

/// The least positive number that is not subnormal.
const TINY: f32 = f32::MIN_POSITIVE;
const POSITIVE: &str = "a positive number";
/// The codes from [`LOW_RAIL`] to [`HIGH_RAIL`], in words.
const CODE: &str = "a code from 124 to 3971";

/// A setting: its name, value, lowest and highest value, and these in words.
type Bounded = (&'static str, f32, (f32, f32), &'static str);

fn all_within(settings: &[Bounded]) -> Result<(), ParamError> {
    let good = |value: f32, (low, high)| value.is_finite() && value >= low && value <= high;
    match settings
        .iter()
        .find(|(_, value, range, _)| !good(*value, *range))
    {
        None => Ok(()),
        Some(&(key, value, _, must_be)) => Err(out_of_range(key, value, must_be)),
    }
}

fn out_of_range(key: &'static str, value: f32, must_be: &'static str) -> ParamError {
    ParamError {
        key,
        value: f64::from(value),
        must_be,
    }
}

#[cfg(test)]
mod tests;
