//! One contact of a free mass on a wall, under each contact law (equations 3-2 to 3-5, figure 3.3): how long, how
//! hard, how much is lost, and where the law alone would pull.

mod pull;
pub mod undriven;

use serde::Serialize;
use shared::model::contact::{LAWS, Law};
use shared::model::params::{BEAM_170, RigParams, SupportParams};
use shared::model::rig::Rig;

use crate::error::Error;
pub use pull::{Pull, unclamped};
use undriven::{Course, Undriven};

/// The mass of figure 3.3, kg.
pub const FIGURE_3_3_MASS_KG: f64 = 2.0;

/// The law of figure 3.3 (Hunt–Crossley).
pub const FIGURE_3_3: Law<f64> = Law::HuntCrossley {
    stiffness: 2.1e8,
    exponent: 1.6,
    damping_ratio: 0.6,
};

/// A mass that nothing but the surface acts on: springs so soft (1 mHz) that their acceleration stays below 1e-12
/// of a contact's.
pub fn free_mass(mass_kg: f64, contact: Law<f64>) -> RigParams {
    RigParams {
        support: SupportParams::Beams {
            natural_frequency_hz: 1e-3,
            damping_ratio: 0.0,
            cubic_stiffness_n_per_m3: Some(0.0),
        },
        mass_kg,
        gap_m: 0.0,
        contact,
        ..BEAM_170
    }
}

/// One contact at `speed_m_per_s`, of `rig` made by [`free_mass`]. None if it does not end.
pub fn one_contact(rig: &Rig<f64>, speed_m_per_s: f64) -> Option<Course> {
    // A tenth of a millisecond before the onset, whatever the speed.
    let q = -1e-4 * speed_m_per_s;
    let scale = (1e-3 * speed_m_per_s, speed_m_per_s);
    Undriven::new(rig, [q, speed_m_per_s], scale, 1.0).next_contact(1.0)
}

/// The figures of one contact.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactFigures {
    /// Name of the contact law.
    pub law: String,
    /// Speed of the mass into the wall at the onset, m/s.
    pub approach_speed_m_per_s: f64,
    /// Onset to release, ms.
    pub contact_time_ms: f64,
    /// Rebound speed over approach speed.
    pub restitution: f64,
    /// Largest contact force, N.
    pub force_n: f64,
    /// Largest contact force over the mass's weight.
    pub force_ratio: f64,
    /// When the force was largest, ms after the onset.
    pub peak_after_ms: f64,
    /// Impulse of the contact, ∫F dt, N·s.
    pub impulse_n_s: f64,
    /// Largest penetration, µm.
    pub penetration_um: f64,
    /// Kinetic energy at the onset, J.
    pub energy_in_j: f64,
    /// ∫F δ̇ dt, integrated along the contact, J.
    pub energy_lost_j: f64,
    /// That less the kinetic energy that is missing at release, over the energy at the onset.
    pub energy_imbalance: f64,
    /// The law alone, not kept from pulling: the share of its contact in which F < 0.
    pub pull_share: f64,
    /// And how hard it pulls at most, N.
    pub pull_n: f64,
    /// And the restitution it would have.
    pub pulling_restitution: f64,
}

/// One law at each of `speeds` (m/s, positive).
///
/// # Errors
/// If a parameter is out of range, or a contact does not end.
pub fn rows(
    name: &str,
    law: Law<f64>,
    mass_kg: f64,
    speeds: &[f64],
) -> Result<Vec<ContactFigures>, Error> {
    let params = free_mass(mass_kg, law);
    let rig = Rig::<f64>::new(&params)?;
    let row = |speed: &f64| {
        let done = one_contact(&rig, *speed).and_then(|b| unclamped(&rig, &b).map(|p| (b, p)));
        let (course, pull) = done.ok_or_else(|| Error::EndlessContact {
            law: name.to_owned(),
            speed_m_per_s: *speed,
        })?;
        let contact = &course.contact;
        let (v, u) = (
            contact.approach_speed_m_per_s,
            contact.rebound_speed_m_per_s,
        );
        // A force that has died away changes its sign by rounding.
        let pulls = pull.force_n > 1e-9 * contact.peak_force_n;
        let energy = |speed: f64| 0.5 * params.mass_kg * speed * speed;
        let missing = energy(v) - energy(u);
        let deepest = motion(&rig, &course, 400)
            .iter()
            .fold(0.0_f64, |d, p| d.max(p.penetration_m));
        Ok(ContactFigures {
            law: name.to_owned(),
            approach_speed_m_per_s: crate::row::tidy(v),
            contact_time_ms: contact.duration_s * 1e3,
            restitution: u / v,
            force_n: contact.peak_force_n,
            force_ratio: contact.peak_force_n / params.weight_n(),
            peak_after_ms: (contact.peak_at_s - contact.onset_s) * 1e3,
            impulse_n_s: contact.impulse_n_s,
            penetration_um: deepest * 1e6,
            energy_in_j: energy(v),
            energy_lost_j: contact.energy_lost_j,
            energy_imbalance: (contact.energy_lost_j - missing) / energy(v),
            pull_share: if pulls { pull.share } else { 0.0 },
            pull_n: if pulls { pull.force_n } else { 0.0 },
            pulling_restitution: pull.restitution,
        })
    };
    speeds.iter().map(row).collect()
}

/// An instant of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant {
    /// Since the onset, s.
    pub time_s: f64,
    /// Penetration δ, m.
    pub penetration_m: f64,
    /// Rate of penetration δ̇, m/s.
    pub rate_m_per_s: f64,
    /// Contact force F, N.
    pub force_n: f64,
}

/// `count` + 1 instants of a contact, its ends included.
pub fn motion(rig: &Rig<f64>, course: &Course, count: usize) -> Vec<Instant> {
    let (onset, duration) = (course.contact.onset_s, course.contact.duration_s);
    let instant = |i: usize| {
        let since = duration * i as f64 / count as f64;
        let after = course
            .pieces
            .partition_point(|p| p.end_s() < onset + since)
            .min(course.pieces.len() - 1);
        let (q, v) = course.pieces[after].at(onset + since);
        let at = rig.kinematics(q, v);
        Instant {
            time_s: since,
            penetration_m: at.delta,
            rate_m_per_s: at.rate,
            force_n: course.force(rig, since),
        }
    };
    (0..=count).map(instant).collect()
}

/// The laws by name; the one of the same kind as `own` is `own`, the others are the presets made for the
/// contact of Table 3.1 ([`LAWS`]).
pub fn all_laws(own: Law<f64>) -> Vec<(&'static str, Law<f64>)> {
    LAWS.map(|(name, law)| (name, if law.kind() == own.kind() { own } else { law }))
        .to_vec()
}

#[cfg(test)]
mod tests;
