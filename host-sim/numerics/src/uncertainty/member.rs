//! One rig of those that the real one may be.

use shared::model::cart::CartDrive;
use shared::model::contact::Law;
use shared::model::params::RigParams;

use super::DIMENSIONS;

/// One rig within the uncertainty: its relative deviations, and that of the gap in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Member {
    pub(super) deviations: [f64; DIMENSIONS],
    /// Whether the deviation of the contact's stiffness is the logarithm of a factor.
    pub(super) stiffness_factor: bool,
    /// Whether the contact's damping deviates as a ratio.
    pub(super) damping_ratio: bool,
}

impl Member {
    /// `params` with a `share` (0 to 1) of this member's deviations.
    pub fn apply(&self, params: &RigParams, share: f64) -> RigParams {
        let [
            frequency,
            amplitude,
            stiffness,
            damping,
            gap,
            mass,
            cart_mass,
            shaker_loop,
            shaker_damping,
        ] = self.deviations.map(|d| d * share);
        let mut rig = params.with_natural_frequency_scaled(1.0 + frequency);
        rig.amplitude_m *= 1.0 + amplitude;
        rig.gap_m += gap;
        let by_stiffness = if self.stiffness_factor {
            stiffness.exp()
        } else {
            1.0 + stiffness
        };
        let with_stiffness = match params.contact {
            Law::SpringDashpot { .. } if self.damping_ratio => by_stiffness.sqrt(),
            _ => 1.0,
        };
        let by_damping = with_stiffness * (1.0 + damping);
        rig.contact = rig.contact.scaled(by_stiffness, by_damping);
        rig.mass_kg *= 1.0 + mass;
        rig.cart_mass_kg *= 1.0 + cart_mass;
        if let CartDrive::Loop(held) = &mut rig.cart {
            held.frequency_hz *= 1.0 + shaker_loop;
            held.damping_ratio *= 1.0 + shaker_damping;
        }
        rig
    }

    /// This member at a `share` of its deviations.
    #[must_use]
    pub fn scaled(&self, share: f64) -> Self {
        Self {
            deviations: self.deviations.map(|deviation| deviation * share),
            ..*self
        }
    }

    /// How its natural frequency relates to the nominal one.
    pub fn natural_frequency_factor(&self) -> f64 {
        1.0 + self.deviations[0]
    }
}
