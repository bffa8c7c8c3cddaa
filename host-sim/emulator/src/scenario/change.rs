//! A change of the rig during a run, or between the true rig and the one its keys describe.

use serde::Deserialize;
use shared::model::contact::Law;
use shared::model::params::RigParams;

use super::complaint::out_of_range;
use files::UserError;

/// A change of a rig: what the true one has more than its keys state, or what it drifts to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Change {
    /// Natural frequency, % more.
    pub natural_frequency_percent: f64,
    /// Contact stiffness, % more.
    pub contact_stiffness_percent: f64,
    /// Contact damping (ci, or λ), % more.
    pub contact_damping_percent: f64,
    /// Clearance, mm more.
    pub gap_offset_mm: f64,
}

impl Change {
    /// The keys, as `[true_rig]` may use them beside a rig's own.
    pub const KEYS: [&str; 4] = [
        "natural_frequency_percent",
        "contact_stiffness_percent",
        "contact_damping_percent",
        "gap_offset_mm",
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
        ];
        for (key, (value, (from, to))) in Self::KEYS.iter().zip(values) {
            if !(from..=to).contains(&value) {
                return Err(out_of_range(key, value, &format!("{from} to {to}")));
            }
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
        match &mut changed.contact {
            Law::Hertz { stiffness, .. } | Law::LankaraniNikravesh { stiffness, .. } => {
                *stiffness *= stiffer;
            }
            Law::SpringDashpot { stiffness, damping } => {
                *stiffness *= stiffer;
                *damping *= damped;
            }
            Law::HuntCrossley {
                stiffness,
                damping_ratio,
                ..
            } => {
                *stiffness *= stiffer;
                *damping_ratio *= damped;
            }
        }
        changed
    }
}
