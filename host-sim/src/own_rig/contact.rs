//! Stiffness and damping of a spring-dashpot from what a person can measure of a contact.

use numerics::pick::sensitivity::{contact_time_s, damping_ratio_of_restitution};

use super::reading::Reading;

/// Stiffness and damping, with their half-widths as `[uncertainty]` has them.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// ki, N/m.
    pub stiffness: f64,
    /// ci, N s/m.
    pub damping: f64,
    /// Key and value of the half-widths of stiffness and damping.
    pub widths: [(&'static str, f64); 2],
}

impl Contact {
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

/// The damping ratios that a restitution may mean, the lower first. `None` if it reaches a contact damped critically, or one
/// that loses nothing.
fn ratios(restitution: &Reading) -> Option<[f64; 2]> {
    let at = |side: f64| {
        let there = restitution.value + side * restitution.half_width;
        damping_ratio_of_restitution(there)
    };
    Some([at(1.0)?, at(-1.0)?])
}

/// ki of a mass that touches a fixed surface for `time_s`, nothing else acting.
fn stiffness(mass_kg: f64, ratio: f64, time_s: f64) -> Option<f64> {
    let omega = contact_time_s(ratio, 1.0) / time_s;
    (time_s > 0.0).then_some(mass_kg * omega * omega)
}

/// Where the stiffest contact is more than so many times as stiff as the softest, the stiffness is known to a factor.
const WIDE: f64 = 3.0;

/// The contact with this restitution and contact time (s), known as well as the worst corner. `None` if there is no such contact
/// at a corner.
pub fn of_restitution_and_time(
    mass_kg: f64,
    restitution: &Reading,
    time_s: &Reading,
) -> Option<Contact> {
    let ratios = ratios(restitution)?;
    let middle = stiffness(mass_kg, 0.5 * (ratios[0] + ratios[1]), time_s.value)?;
    let (mut low, mut high) = (middle, middle);
    for ratio in ratios {
        for side in [-1.0, 1.0] {
            let there = stiffness(mass_kg, ratio, time_s.value + side * time_s.half_width)?;
            (low, high) = (low.min(there), high.max(there));
        }
    }
    if high > WIDE * low {
        return of_restitution_and_surface(mass_kg, restitution, [low, high]);
    }
    let percent = 100.0 * (high / middle - 1.0).max(1.0 - low / middle);
    let width = ("contact_stiffness_percent", percent);
    Some(Contact::with_ratio(mass_kg, middle, width, ratios))
}

/// The contact with this restitution and a stiffness from `low` to `high`, in N/m. `None` if there is no such contact.
pub fn of_restitution_and_surface(
    mass_kg: f64,
    restitution: &Reading,
    [low, high]: [f64; 2],
) -> Option<Contact> {
    let width = ("contact_stiffness_factor", (high / low).sqrt());
    let middle = (low * high).sqrt();
    Some(Contact::with_ratio(
        mass_kg,
        middle,
        width,
        ratios(restitution)?,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table 3.1: 5.5e6 N/m and 1.2e3 N s/m at 0.298 kg make 0.570751 ms and restitution 0.316902.
    #[test]
    fn the_known_contact_comes_back() {
        let time = Reading::assumed(0.570_751e-3, 1e-9);
        let restitution = Reading::assumed(0.316_902, 1e-6);
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
        let time = Reading::assumed(0.57e-3, 0.57e-5);
        let contact = of_restitution_and_time(0.298, &Reading::assumed(0.317, 0.0), &time).unwrap();
        let [(_, stiffness), (key, ratio)] = contact.widths;
        assert!((stiffness - 2.03).abs() < 0.02, "{contact:?}");
        assert_eq!((key, ratio), ("contact_damping_ratio_percent", 0.0));
        // Known to half, four corners from 1/2.25 to 4 times: no percentage says that.
        let time = Reading::assumed(0.57e-3, 0.285e-3);
        let contact = of_restitution_and_time(0.298, &Reading::assumed(0.317, 0.0), &time).unwrap();
        let (key, factor) = contact.widths[0];
        assert_eq!(key, "contact_stiffness_factor");
        assert!((factor - 3.0).abs() < 1e-9, "{factor}");
    }

    #[test]
    fn what_is_no_restitution_gives_no_contact() {
        for value in [0.0, 1.0, 1.2, -0.3] {
            let restitution = Reading::assumed(value, 0.0);
            let contact = of_restitution_and_surface(0.298, &restitution, [1e6, 1e7]);
            assert_eq!(contact, None, "{value}");
        }
    }
}
