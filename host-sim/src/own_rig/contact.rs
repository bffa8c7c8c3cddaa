//! Stiffness and damping of a spring-dashpot from what a person can measure of a contact.

use numerics::pick::sensitivity::{contact_time_s, damping_ratio_of_restitution};

use super::reading::Reading;

/// Stiffness and damping, each with its half-width in %.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// ki, N/m.
    pub stiffness: f64,
    /// Its half-width, %.
    pub stiffness_percent: f64,
    /// ci, N s/m.
    pub damping: f64,
    /// Its half-width, %.
    pub damping_percent: f64,
}

/// ki and ci of a mass that rebounds with `restitution` after `contact_time_s`, against a fixed surface, nothing else acting.
fn closed_form(mass_kg: f64, restitution: f64, time_s: f64) -> Option<(f64, f64)> {
    let zeta = damping_ratio_of_restitution(restitution)?;
    let omega = contact_time_s(zeta, 1.0) / time_s;
    let stiffness = mass_kg * omega * omega;
    (time_s > 0.0).then_some((stiffness, 2.0 * zeta * (stiffness * mass_kg).sqrt()))
}

/// The contact with this restitution and contact time (s). The half-widths are those of the worst corner. `None` if there is
/// no such contact at a corner.
pub fn of_restitution_and_time(
    mass_kg: f64,
    restitution: &Reading,
    time_s: &Reading,
) -> Option<Contact> {
    let (stiffness, damping) = closed_form(mass_kg, restitution.value, time_s.value)?;
    let mut contact = Contact {
        stiffness,
        stiffness_percent: 0.0,
        damping,
        damping_percent: 0.0,
    };
    for side in [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]] {
        let (k, c) = closed_form(
            mass_kg,
            restitution.value + side[0] * restitution.half_width,
            time_s.value + side[1] * time_s.half_width,
        )?;
        contact.widen(k, c);
    }
    Some(contact)
}

/// The contact with this restitution and an assumed stiffness, known to `stiffness_percent`.
pub fn of_restitution(
    mass_kg: f64,
    restitution: &Reading,
    stiffness: f64,
    stiffness_percent: f64,
) -> Option<Contact> {
    let damping = |restitution: f64| {
        let zeta = damping_ratio_of_restitution(restitution)?;
        Some(2.0 * zeta * (stiffness * mass_kg).sqrt())
    };
    let mut contact = Contact {
        stiffness,
        stiffness_percent,
        damping: damping(restitution.value)?,
        damping_percent: 0.0,
    };
    for side in [-1.0, 1.0] {
        let c = damping(restitution.value + side * restitution.half_width)?;
        contact.widen(stiffness, c);
    }
    Some(contact)
}

impl Contact {
    /// Lets the half-widths reach a stiffness and a damping.
    fn widen(&mut self, stiffness: f64, damping: f64) {
        let percent = |there: f64, here: f64| 100.0 * (there / here - 1.0).abs();
        self.stiffness_percent = self
            .stiffness_percent
            .max(percent(stiffness, self.stiffness));
        self.damping_percent = self.damping_percent.max(percent(damping, self.damping));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::own_rig::reading::read;

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
        let same = of_restitution(0.298, &restitution, 5.5e6, 50.0).unwrap();
        assert!((same.damping / 1.2e3 - 1.0).abs() < 1e-5, "{same:?}");
    }

    #[test]
    fn a_time_known_to_a_percent_gives_the_stiffness_to_two() {
        let time = Reading::assumed(0.57e-3, 0.57e-5);
        let contact = of_restitution_and_time(0.298, &Reading::assumed(0.317, 0.0), &time).unwrap();
        assert!(
            (contact.stiffness_percent - 2.03).abs() < 0.02,
            "{contact:?}"
        );
    }

    #[test]
    fn what_is_no_restitution_gives_no_contact() {
        for text in ["0", "1", "1.2", "-0.3"] {
            let restitution = read(text).unwrap();
            assert_eq!(
                of_restitution(0.298, &restitution, 5.5e6, 50.0),
                None,
                "{text}"
            );
        }
    }
}
