//! The rigs the real one may be: every corner of the stated uncertainty, and seeded samples inside it.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use shared::model::cart::CartDrive;
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
    /// Hammer mass at the same natural frequency, % either way.
    pub mass_percent: f64,
    /// Cart mass at the same loop frequency, % either way (a cart that recoils).
    pub cart_mass_percent: f64,
    /// Natural frequency of the shaker's position loop, % either way (a cart that recoils).
    pub shaker_loop_percent: f64,
}

/// What is said of a rig's uncertainty, for example in its file; `None` where nothing is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stated {
    /// See [`Uncertainty::natural_frequency_percent`].
    pub natural_frequency_percent: Option<f64>,
    /// See [`Uncertainty::amplitude_percent`].
    pub amplitude_percent: Option<f64>,
    /// See [`Uncertainty::contact_stiffness_percent`].
    pub contact_stiffness_percent: Option<f64>,
    /// See [`Uncertainty::contact_damping_percent`].
    pub contact_damping_percent: Option<f64>,
    /// See [`Uncertainty::gap_mm`].
    pub gap_mm: Option<f64>,
    /// See [`Uncertainty::mass_percent`].
    pub mass_percent: Option<f64>,
    /// See [`Uncertainty::cart_mass_percent`].
    pub cart_mass_percent: Option<f64>,
    /// See [`Uncertainty::shaker_loop_percent`].
    pub shaker_loop_percent: Option<f64>,
}

impl Stated {
    /// What is stated here, else what is stated in `other`.
    #[must_use]
    pub fn or(&self, other: &Self) -> Self {
        Self {
            natural_frequency_percent: self
                .natural_frequency_percent
                .or(other.natural_frequency_percent),
            amplitude_percent: self.amplitude_percent.or(other.amplitude_percent),
            contact_stiffness_percent: self
                .contact_stiffness_percent
                .or(other.contact_stiffness_percent),
            contact_damping_percent: self
                .contact_damping_percent
                .or(other.contact_damping_percent),
            gap_mm: self.gap_mm.or(other.gap_mm),
            mass_percent: self.mass_percent.or(other.mass_percent),
            cart_mass_percent: self.cart_mass_percent.or(other.cart_mass_percent),
            shaker_loop_percent: self.shaker_loop_percent.or(other.shaker_loop_percent),
        }
    }

    /// The uncertainty of a rig whose cart recoils or not: what is stated, else the usual widths. What only a cart that
    /// recoils feels has no width for one that does not.
    pub fn complete(&self, samples: u32, seed: u64, recoils: bool) -> Uncertainty {
        let usual = Uncertainty::default();
        let of_recoil = |stated: Option<f64>, usual: f64| {
            if recoils {
                stated.unwrap_or(usual)
            } else {
                0.0
            }
        };
        Uncertainty {
            natural_frequency_percent: self
                .natural_frequency_percent
                .unwrap_or(usual.natural_frequency_percent),
            amplitude_percent: self.amplitude_percent.unwrap_or(usual.amplitude_percent),
            contact_stiffness_percent: self
                .contact_stiffness_percent
                .unwrap_or(usual.contact_stiffness_percent),
            contact_damping_percent: self
                .contact_damping_percent
                .unwrap_or(usual.contact_damping_percent),
            gap_mm: self.gap_mm.unwrap_or(usual.gap_mm),
            samples,
            seed,
            mass_percent: self.mass_percent.unwrap_or(usual.mass_percent),
            cart_mass_percent: of_recoil(self.cart_mass_percent, usual.cart_mass_percent),
            shaker_loop_percent: of_recoil(self.shaker_loop_percent, usual.shaker_loop_percent),
        }
    }
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
            mass_percent: 0.0,
            cart_mass_percent: 0.0,
            shaker_loop_percent: 0.0,
        }
    }
}

/// Dimensions of the uncertainty.
const DIMENSIONS: usize = 8;
/// The dimensions from here on move together in the corners: hammer mass, cart mass and loop all raise the force, and hardly.
/// Each with corners of its own would make every pick four times as long. In the samples they move by themselves.
const TOGETHER: usize = 5;

impl Uncertainty {
    fn half_widths(&self) -> [f64; DIMENSIONS] {
        [
            self.natural_frequency_percent / 100.0,
            self.amplitude_percent / 100.0,
            self.contact_stiffness_percent / 100.0,
            self.contact_damping_percent / 100.0,
            self.gap_mm / 1e3,
            self.mass_percent / 100.0,
            self.cart_mass_percent / 100.0,
            self.shaker_loop_percent / 100.0,
        ]
    }

    /// The dimensions that have a width, those that move together in the corners as one.
    fn axes(&self) -> Vec<Vec<usize>> {
        let widths = self.half_widths();
        let open = |i: &usize| widths[*i] != 0.0;
        let alone = (0..TOGETHER).filter(open).map(|i| vec![i]);
        let together: Vec<usize> = (TOGETHER..DIMENSIONS).filter(open).collect();
        let together = Some(together).filter(|axis| !axis.is_empty());
        alone.chain(together).collect()
    }

    /// The corners of the dimensions that have a width.
    pub fn corners(&self) -> Vec<Member> {
        let axes = self.axes().len();
        let count = if axes == 0 { 0 } else { 1 << axes };
        self.members().into_iter().take(count).collect()
    }

    /// Every member: the corners, then the samples inside them.
    pub fn members(&self) -> Vec<Member> {
        let widths = self.half_widths();
        let axes = self.axes();
        if axes.is_empty() {
            return Vec::new();
        }
        let corner = |bits: usize| {
            let mut deviation = [0.0; DIMENSIONS];
            for (bit, axis) in axes.iter().enumerate() {
                let side = if bits >> bit & 1 == 0 { -1.0 } else { 1.0 };
                for i in axis {
                    deviation[*i] = side;
                }
            }
            deviation
        };
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let corners = (0..1 << axes.len()).map(corner);
        let samples = (0..self.samples).map(|_| {
            let mut deviation = [0.0; DIMENSIONS];
            for i in axes.iter().flatten() {
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
        let [
            frequency,
            amplitude,
            stiffness,
            damping,
            gap,
            mass,
            cart_mass,
            shaker_loop,
        ] = self.0.map(|d| d * share);
        let mut rig = params.with_natural_frequency_scaled(1.0 + frequency);
        rig.amplitude_m *= 1.0 + amplitude;
        rig.gap_m += gap;
        rig.contact = scale_contact(&rig.contact, 1.0 + stiffness, 1.0 + damping);
        rig.mass_kg *= 1.0 + mass;
        rig.cart_mass_kg *= 1.0 + cart_mass;
        if let CartDrive::Loop(held) = &mut rig.cart {
            held.frequency_hz *= 1.0 + shaker_loop;
        }
        rig
    }

    /// This member at a `share` of its deviations.
    #[must_use]
    pub fn scaled(&self, share: f64) -> Self {
        Self(self.0.map(|deviation| deviation * share))
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
    use shared::model::cart::ASSUMED_SHAKER;
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
    fn the_masses_and_the_loop_are_dimensions_where_the_cart_recoils() {
        let stated = Stated {
            mass_percent: Some(1.0),
            cart_mass_percent: Some(2.0),
            shaker_loop_percent: Some(10.0),
            ..Stated::default()
        };
        let recoiling = stated.complete(0, 1, true);
        assert_eq!(recoiling.corners().len(), 64);
        let rig = RigParams {
            cart: CartDrive::Loop(ASSUMED_SHAKER),
            ..WIRES
        };
        let largest = recoiling.corners()[63].apply(&rig, 1.0);
        assert!((largest.mass_kg / rig.mass_kg - 1.01).abs() < 1e-12);
        assert!((largest.cart_mass_kg / rig.cart_mass_kg - 1.02).abs() < 1e-12);
        let CartDrive::Loop(held) = largest.cart else {
            panic!("the cart still recoils");
        };
        assert!((held.frequency_hz / ASSUMED_SHAKER.frequency_hz - 1.1).abs() < 1e-12);
        let prescribed = stated.complete(0, 1, false);
        assert_eq!(prescribed.corners().len(), 64);
        assert_eq!(
            Stated::default().complete(256, 1, true),
            Uncertainty::default()
        );
    }

    #[test]
    fn no_share_is_the_rig_itself() {
        for member in Uncertainty::default().members() {
            assert_eq!(member.apply(&WIRES, 0.0), WIRES);
            assert_eq!(member.apply(&WIRES, 1.0).check(), Ok(()));
        }
    }
}
