//! The rigs the real one may be: every corner of the stated uncertainty, and seeded samples inside it.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use shared::model::contact::Law;
use shared::model::params::RigParams;

/// Half-widths of what is not known exactly.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Uncertainty {
    /// Natural frequency, % either way (wires: through their length).
    pub natural_frequency_percent: f64,
    /// Cart amplitude, % either way.
    pub amplitude_percent: f64,
    /// Contact stiffness, % either way.
    pub contact_stiffness_percent: f64,
    /// Contact damping, % either way.
    pub contact_damping_percent: f64,
    /// Gap, mm either way.
    pub gap_mm: f64,
    /// Samples inside the corners.
    pub samples: u32,
    /// Seed of the samples.
    pub seed: u64,
}

impl Default for Uncertainty {
    fn default() -> Self {
        Self {
            natural_frequency_percent: 2.0,
            amplitude_percent: 5.0,
            contact_stiffness_percent: 20.0,
            contact_damping_percent: 20.0,
            gap_mm: 0.05,
            samples: 256,
            seed: 1,
        }
    }
}

/// Dimensions of the uncertainty.
const DIMENSIONS: usize = 5;

impl Uncertainty {
    fn half_widths(&self) -> [f64; DIMENSIONS] {
        [
            self.natural_frequency_percent / 100.0,
            self.amplitude_percent / 100.0,
            self.contact_stiffness_percent / 100.0,
            self.contact_damping_percent / 100.0,
            self.gap_mm / 1e3,
        ]
    }

    /// The corners of the dimensions that have a width.
    pub fn corners(&self) -> Vec<Member> {
        let open = self
            .half_widths()
            .iter()
            .filter(|width| **width != 0.0)
            .count();
        let count = if open == 0 { 0 } else { 1 << open };
        self.members().into_iter().take(count).collect()
    }

    /// Every member: the corners, then the samples inside them.
    pub fn members(&self) -> Vec<Member> {
        let widths = self.half_widths();
        let open: Vec<usize> = (0..DIMENSIONS).filter(|i| widths[*i] != 0.0).collect();
        if open.is_empty() {
            return Vec::new();
        }
        let corner = |bits: usize| {
            let mut deviation = [0.0; DIMENSIONS];
            for (bit, i) in open.iter().enumerate() {
                deviation[*i] = if bits >> bit & 1 == 0 { -1.0 } else { 1.0 };
            }
            deviation
        };
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let corners = (0..1 << open.len()).map(corner);
        let samples = (0..self.samples).map(|_| {
            let mut deviation = [0.0; DIMENSIONS];
            for i in &open {
                deviation[*i] = random.random_range(-1.0..=1.0);
            }
            deviation
        });
        let scaled = |d: [f64; DIMENSIONS]| Member(std::array::from_fn(|i| d[i] * widths[i]));
        corners.chain(samples).map(scaled).collect()
    }
}

/// One rig within the uncertainty: its relative deviations, and that of the gap in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Member([f64; DIMENSIONS]);

impl Member {
    /// `params` with a `share` (0 to 1) of this member's deviations.
    pub fn apply(&self, params: &RigParams, share: f64) -> RigParams {
        let [frequency, amplitude, stiffness, damping, gap] = self.0.map(|d| d * share);
        let mut rig = params.with_natural_frequency_scaled(1.0 + frequency);
        rig.amplitude_m *= 1.0 + amplitude;
        rig.gap_m += gap;
        rig.contact = scale_contact(&rig.contact, 1.0 + stiffness, 1.0 + damping);
        rig
    }

    /// How its natural frequency relates to the nominal one.
    pub fn natural_frequency_factor(&self) -> f64 {
        1.0 + self.0[0]
    }
}

/// A contact law with stiffness and damping scaled. What damps is ci, λ, or 1 − e² (kept at or below 1).
pub fn scale_contact(law: &Law<f64>, by_stiffness: f64, by_damping: f64) -> Law<f64> {
    let mut law = *law;
    match &mut law {
        Law::Hertz { stiffness, .. } => *stiffness *= by_stiffness,
        Law::SpringDashpot { stiffness, damping } => {
            *stiffness *= by_stiffness;
            *damping *= by_damping;
        }
        Law::HuntCrossley {
            stiffness,
            damping_ratio,
            ..
        } => {
            *stiffness *= by_stiffness;
            *damping_ratio *= by_damping;
        }
        Law::LankaraniNikravesh {
            stiffness,
            restitution,
            ..
        } => {
            *stiffness *= by_stiffness;
            let loss = ((1.0 - *restitution * *restitution) * by_damping).min(1.0);
            *restitution = (1.0 - loss).sqrt();
        }
    }
    law
}

#[cfg(test)]
mod tests {
    use super::*;
    use shared::model::params::WIRES;

    #[test]
    fn members_are_all_corners_and_the_same_samples_for_the_same_seed() {
        let uncertainty = Uncertainty::default();
        let members = uncertainty.members();
        assert_eq!(members.len(), 32 + 256);
        assert_eq!(members, uncertainty.members());
        assert_eq!(uncertainty.corners(), members[..32]);
        let extremes = members
            .iter()
            .filter(|m| m.0[0] == 0.02 && m.0[4] == -0.05e-3);
        assert_eq!(extremes.count(), 8);
        let other = Uncertainty {
            seed: 2,
            ..uncertainty
        }
        .members();
        assert_eq!(other[..32], members[..32]);
        assert_ne!(other[32..], members[32..]);
    }

    #[test]
    fn a_dimension_without_width_has_no_corners() {
        let uncertainty = Uncertainty {
            gap_mm: 0.0,
            amplitude_percent: 0.0,
            ..Uncertainty::default()
        };
        assert_eq!(uncertainty.members().len(), 8 + 256);
        let certain = Uncertainty {
            natural_frequency_percent: 0.0,
            contact_stiffness_percent: 0.0,
            contact_damping_percent: 0.0,
            ..uncertainty
        };
        assert!(certain.members().is_empty());
    }

    #[test]
    fn no_share_is_the_rig_itself() {
        for member in Uncertainty::default().members() {
            assert_eq!(member.apply(&WIRES, 0.0), WIRES);
            assert_eq!(member.apply(&WIRES, 1.0).check(), Ok(()));
        }
    }
}
