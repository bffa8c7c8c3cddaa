//! Stiffness and damping of a spring-dashpot from what a person can measure of a contact.

use numerics::pick::sensitivity::{contact_time_s, damping_ratio_of_restitution};

use super::reading::OwnReading;
use files::UserError;
use files::words::digits::significant;

/// Stiffness and damping, with their half-widths as `[uncertainty]` has them.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnContact {
    /// Stiffness ki, N/m.
    pub stiffness: f64,
    /// Damping ci, N·s/m.
    pub damping: f64,
    /// Key and value of the half-widths of stiffness and damping.
    pub widths: [(&'static str, f64); 2],
}

impl OwnContact {
    /// Stiffness and damping known by themselves, each to so many %.
    pub fn apart(stiffness: f64, damping: f64, percent: [f64; 2]) -> Self {
        let [of_stiffness, of_damping] = percent;
        let widths = [
            ("contact_stiffness_percent", of_stiffness),
            ("contact_damping_percent", of_damping),
        ];
        Self {
            stiffness,
            damping,
            widths,
        }
    }

    /// A stiffness, and a damping ratio between these two: the damping follows the stiffness.
    fn with_ratio(
        mass_kg: f64,
        stiffness: f64,
        of_stiffness: (&'static str, f64),
        [low, high]: [f64; 2],
    ) -> Self {
        let ratio = 0.5 * (low + high);
        let percent = 100.0 * (high - low) / (high + low);
        Self {
            stiffness,
            damping: 2.0 * ratio * (stiffness * mass_kg).sqrt(),
            widths: [of_stiffness, ("contact_damping_ratio_percent", percent)],
        }
    }
}

/// The damping ratios that a restitution may mean, the lower first.
///
/// # Errors
/// If it reaches a contact damped critically, or one that loses nothing.
pub fn ratios(restitution: &OwnReading) -> Result<[f64; 2], String> {
    let [low, high] = [-1.0, 1.0].map(|side| restitution.value + side * restitution.half_width);
    let ratios = damping_ratio_of_restitution(high).zip(damping_ratio_of_restitution(low));
    ratios.map(<[f64; 2]>::from).ok_or_else(|| {
        let (text, low, high) = (&restitution.text, significant(low, 4), significant(high, 4));
        format!(
            "{text} reaches from {low} to {high}; it must stay above 0.1354 (a contact damped critically) and below 1 (one that loses nothing)"
        )
    })
}

/// The shortest and the longest contact time, s.
///
/// # Errors
/// If it reaches down to none.
pub fn times(time_s: &OwnReading) -> Result<[f64; 2], String> {
    let [low, high] = [-1.0, 1.0].map(|side| time_s.value + side * time_s.half_width);
    if low > 0.0 {
        return Ok([low, high]);
    }
    let (text, low) = (&time_s.text, significant(1e3 * low, 4));
    Err(format!(
        "{text} reaches down to {low} ms; a contact time must stay above 0"
    ))
}

/// ki of a mass that touches a fixed surface for `time_s`, nothing else acting.
fn stiffness(mass_kg: f64, ratio: f64, time_s: f64) -> f64 {
    let omega = contact_time_s(ratio, 1.0) / time_s;
    mass_kg * omega * omega
}

/// From this factor on, either way, a stiffness is known to a factor: a percentage is the same on both sides, and would reach
/// much farther down than the softest contact.
const WIDE: f64 = 1.3;

/// The contact with this restitution and contact time (s), known as well as the worst corner.
///
/// # Errors
/// If there is no such contact at a corner.
pub fn of_restitution_and_time(
    mass_kg: f64,
    restitution: &OwnReading,
    time_s: &OwnReading,
) -> Result<OwnContact, UserError> {
    let ratios = ratios_given(restitution)?;
    let times = times(time_s).map_err(|why| UserError::new(why).at("--contact-time"))?;
    let middle = stiffness(mass_kg, 0.5 * (ratios[0] + ratios[1]), time_s.value);
    let (mut low, mut high) = (middle, middle);
    for ratio in ratios {
        for time in times {
            let there = stiffness(mass_kg, ratio, time);
            (low, high) = (low.min(there), high.max(there));
        }
    }
    if high >= WIDE * WIDE * low {
        return of_restitution_and_surface(mass_kg, restitution, [low, high]);
    }
    let percent = 100.0 * (high / middle - 1.0).max(1.0 - low / middle);
    let width = ("contact_stiffness_percent", percent);
    Ok(OwnContact::with_ratio(mass_kg, middle, width, ratios))
}

/// The contact with this restitution and a stiffness from `low` to `high`, in N/m.
///
/// # Errors
/// If there is no such contact.
pub fn of_restitution_and_surface(
    mass_kg: f64,
    restitution: &OwnReading,
    [low, high]: [f64; 2],
) -> Result<OwnContact, UserError> {
    let width = ("contact_stiffness_factor", (high / low).sqrt());
    let middle = (low * high).sqrt();
    let ratios = ratios_given(restitution)?;
    Ok(OwnContact::with_ratio(mass_kg, middle, width, ratios))
}

fn ratios_given(restitution: &OwnReading) -> Result<[f64; 2], UserError> {
    ratios(restitution).map_err(|why| UserError::new(why).at("--restitution"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::own_rig::reading::{CONTACT_TIME, RESTITUTION};

    /// Table 3.1: 5.5e6 N/m and 1.2e3 N s/m at 0.298 kg make 0.570751 ms and restitution 0.316902.
    #[test]
    fn the_known_contact_comes_back() {
        let time = OwnReading::assumed(0.570_751e-3, 1e-9);
        let restitution = OwnReading::assumed(0.316_902, 1e-6);
        let contact = of_restitution_and_time(0.298, &restitution, &time).unwrap();
        assert!(
            (contact.stiffness / 5.5e6 - 1.0).abs() < 1e-5,
            "{contact:?}"
        );
        assert!((contact.damping / 1.2e3 - 1.0).abs() < 1e-5, "{contact:?}");
        let same = of_restitution_and_surface(0.298, &restitution, [5.5e5, 5.5e7]).unwrap();
        assert!((same.damping / 1.2e3 - 1.0).abs() < 1e-5, "{same:?}");
        assert_eq!(same.widths[0].0, "contact_stiffness_factor");
        assert!((same.widths[0].1 - 10.0).abs() < 1e-9, "{same:?}");
    }

    /// What one contact time leaves open moves stiffness and damping together: the damping ratio is the restitution's alone.
    #[test]
    fn a_time_known_to_a_percent_gives_the_stiffness_to_two_and_the_damping_ratio_exactly() {
        let time = OwnReading::assumed(0.57e-3, 0.57e-5);
        let contact =
            of_restitution_and_time(0.298, &OwnReading::assumed(0.317, 0.0), &time).unwrap();
        let [(_, stiffness), (key, ratio)] = contact.widths;
        assert!((stiffness - 2.03).abs() < 0.02, "{contact:?}");
        assert_eq!((key, ratio), ("contact_damping_ratio_percent", 0.0));
        // Known to half, four corners from 1/2.25 to 4 times: no percentage says that.
        let time = OwnReading::assumed(0.57e-3, 0.285e-3);
        let contact =
            of_restitution_and_time(0.298, &OwnReading::assumed(0.317, 0.0), &time).unwrap();
        let (key, factor) = contact.widths[0];
        assert_eq!(key, "contact_stiffness_factor");
        assert!((factor - 3.0).abs() < 1e-9, "{factor}");
    }

    /// Low and high stiffness of a contact time of 4 ms known to so many ms, and the key of its width.
    fn known_to(half_width_ms: f64) -> (f64, f64, &'static str) {
        let time = OwnReading::assumed(4e-3, 1e-3 * half_width_ms);
        let restitution = OwnReading::assumed(0.32, 0.02);
        let contact = of_restitution_and_time(0.298, &restitution, &time).unwrap();
        let (key, width) = contact.widths[0];
        let middle = contact.stiffness;
        match key {
            "contact_stiffness_factor" => (middle / width, middle * width, key),
            _ => {
                let share = width / 100.0;
                (middle * (1.0 - share), middle * (1.0 + share), key)
            }
        }
    }

    /// From a factor of 1.3 on; there the percentage is 33, and the step from the one form to the other is small.
    #[test]
    fn a_worse_time_does_not_give_a_narrower_stiffness() {
        for (half_width_ms, form) in [
            (0.3, "contact_stiffness_percent"),
            (0.4, "contact_stiffness_percent"),
            (0.6, "contact_stiffness_factor"),
            (1.0, "contact_stiffness_factor"),
            (1.1, "contact_stiffness_factor"),
            (2.0, "contact_stiffness_factor"),
        ] {
            assert_eq!(known_to(half_width_ms).2, form, "{half_width_ms}");
        }
        let mut before = known_to(0.0);
        for i in 1..=20 {
            let now = known_to(0.1 * f64::from(i));
            let step = if now.2 == before.2 { 1.0 } else { 1.2 };
            assert!(now.0 <= step * before.0 && now.1 >= before.1 / step, "{i}");
            before = now;
        }
    }

    #[test]
    fn what_is_no_restitution_gives_no_contact() {
        for value in [0.0, 1.0, 1.2, -0.3] {
            let restitution = OwnReading::assumed(value, 0.0);
            let contact = of_restitution_and_surface(0.298, &restitution, [1e6, 1e7]);
            assert!(contact.is_err(), "{value}");
        }
    }

    #[test]
    fn what_reaches_too_far_is_named() {
        let restitution = RESTITUTION.read("0.32").unwrap();
        let time = CONTACT_TIME.read("2+-2ms").unwrap();
        let why = of_restitution_and_time(0.298, &restitution, &time).unwrap_err();
        let said = "--contact-time: 2+-2ms reaches down to 0 ms";
        assert!(why.to_string().starts_with(said), "{why}");
        let restitution = RESTITUTION.read("0.14").unwrap();
        let why = of_restitution_and_surface(0.298, &restitution, [1e6, 1e7]).unwrap_err();
        let said = "--restitution: 0.14 reaches from 0.1350 to 0.1450; it must stay above 0.1354 (a contact damped critically)";
        assert!(why.to_string().starts_with(said), "{why}");
    }
}
