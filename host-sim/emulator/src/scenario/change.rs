//! A change of the rig during a run, or between the true rig and the one its keys describe.

use serde::Deserialize;
use shared::model::contact::Law;
use shared::model::params::RigParams;

use super::complaint::out_of_range;
use files::UserError;
use numerics::pick::sensitivity::{contact_damping_ratio, restitution};
use numerics::root::halved;

/// A change of a rig: what the true one has more than its keys state, or what it drifts to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RigChange {
    /// Natural frequency, % more.
    pub natural_frequency_percent: f64,
    /// Contact stiffness, % more.
    pub contact_stiffness_percent: f64,
    /// Contact damping (ci, or λ), % more.
    pub contact_damping_percent: f64,
    /// Clearance added to the rig's gap, mm; may be negative.
    pub gap_offset_mm: f64,
    /// Newton's coefficient of restitution that the surface comes to have: of the hammer against a wall.
    pub restitution: Option<f64>,
}

impl RigChange {
    /// The keys, as `[true_rig]` may use them beside a rig's own.
    pub const KEYS: [&str; 5] = [
        "natural_frequency_percent",
        "contact_stiffness_percent",
        "contact_damping_percent",
        "gap_offset_mm",
        "restitution",
    ];

    /// Checks each number.
    ///
    /// # Errors
    /// One is out of its range.
    pub fn check(&self) -> Result<(), UserError> {
        let values = [
            (self.natural_frequency_percent, (-90.0, 900.0)),
            (self.contact_stiffness_percent, (-99.0, 1e6)),
            (self.contact_damping_percent, (-100.0, 1e6)),
            (self.gap_offset_mm, (-100.0, 100.0)),
            (self.restitution.unwrap_or(0.5), (0.14, 0.999)),
        ];
        for (key, (value, (from, to))) in Self::KEYS.iter().zip(values) {
            if !(from..=to).contains(&value) {
                return Err(out_of_range(key, value, &format!("{from} to {to}")));
            }
        }
        Ok(())
    }

    /// Checks that the surface of `rig` can change so.
    ///
    /// # Errors
    /// Its law has no restitution of its own.
    pub fn fits(&self, rig: &RigParams) -> Result<(), UserError> {
        if self.restitution.is_some() && restitution_of(rig).is_none() {
            return Err(UserError::new(
                "restitution goes with the spring-dashpot (underdamped) and the laws with a contact_restitution; change contact_damping_percent instead",
            ));
        }
        Ok(())
    }

    /// `rig` with this `share` (0 to 1) of the change.
    #[must_use]
    pub fn apply(&self, rig: &RigParams, share: f64) -> RigParams {
        let times = |percent: f64| 1.0 + 0.01 * percent * share;
        let mut changed = rig.with_natural_frequency_scaled(times(self.natural_frequency_percent));
        changed.gap_m += 1e-3 * self.gap_offset_mm * share;
        let stiffer = times(self.contact_stiffness_percent);
        let damped = times(self.contact_damping_percent);
        changed.contact = changed.contact.scaled(stiffer, damped);
        if let Some((wanted, now)) = self.restitution.zip(restitution_of(&changed)) {
            set_restitution(&mut changed, now + share * (wanted - now));
        }
        changed
    }
}

/// The key of the laws that are given a restitution.
const RESTITUTION: &str = "contact_restitution";

/// Restitution of the hammer against the surface held still; none where the law has none that is the same at every
/// speed.
fn restitution_of(rig: &RigParams) -> Option<f64> {
    let mut law = rig.contact;
    if let Some(own) = law.number_mut(RESTITUTION) {
        return Some(*own);
    }
    let zeta = contact_damping_ratio(rig)?;
    (zeta > 0.0 && zeta < 1.0).then(|| restitution(zeta))
}

fn set_restitution(rig: &mut RigParams, wanted: f64) {
    if let Law::SpringDashpot { stiffness, damping } = &mut rig.contact {
        // Falls with the damping ratio.
        let (_, ratio) = halved((1e-9, 1.0 - 1e-9), 60, |zeta| restitution(zeta) <= wanted);
        *damping = 2.0 * ratio * (*stiffness * rig.mass_kg).sqrt();
    } else if let Some(own) = rig.contact.number_mut(RESTITUTION) {
        *own = wanted;
    }
}
