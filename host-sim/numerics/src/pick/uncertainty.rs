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
    /// In its place a factor: the stiffness is up to so many times as large, or as small.
    pub contact_stiffness_factor: Option<f64>,
    /// Contact damping, % either way, whatever the stiffness.
    pub contact_damping_percent: f64,
    /// In its place the contact's damping ratio, % either way: the damping then goes with the square root of the stiffness.
    /// A law whose damping has no scale (λ, or a restitution) keeps it at another stiffness as it is.
    pub contact_damping_ratio_percent: Option<f64>,
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
    /// Damping ratio of that loop, % either way (a cart that recoils).
    pub shaker_damping_percent: f64,
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
    /// See [`Uncertainty::contact_stiffness_factor`].
    pub contact_stiffness_factor: Option<f64>,
    /// See [`Uncertainty::contact_damping_percent`].
    pub contact_damping_percent: Option<f64>,
    /// See [`Uncertainty::contact_damping_ratio_percent`].
    pub contact_damping_ratio_percent: Option<f64>,
    /// See [`Uncertainty::gap_mm`].
    pub gap_mm: Option<f64>,
    /// See [`Uncertainty::mass_percent`].
    pub mass_percent: Option<f64>,
    /// See [`Uncertainty::cart_mass_percent`].
    pub cart_mass_percent: Option<f64>,
    /// See [`Uncertainty::shaker_loop_percent`].
    pub shaker_loop_percent: Option<f64>,
    /// See [`Uncertainty::shaker_damping_percent`].
    pub shaker_damping_percent: Option<f64>,
}

impl Stated {
    /// What is stated here, else what is stated in `other`. The two ways to state the contact's stiffness, or its damping, take
    /// each other's place.
    #[must_use]
    pub fn or(&self, other: &Self) -> Self {
        let damping =
            self.contact_damping_percent.is_some() || self.contact_damping_ratio_percent.is_some();
        let of_damping = if damping { self } else { other };
        let stiffness =
            self.contact_stiffness_percent.is_some() || self.contact_stiffness_factor.is_some();
        let of_stiffness = if stiffness { self } else { other };
        Self {
            natural_frequency_percent: self
                .natural_frequency_percent
                .or(other.natural_frequency_percent),
            amplitude_percent: self.amplitude_percent.or(other.amplitude_percent),
            contact_stiffness_percent: of_stiffness.contact_stiffness_percent,
            contact_stiffness_factor: of_stiffness.contact_stiffness_factor,
            contact_damping_percent: of_damping.contact_damping_percent,
            contact_damping_ratio_percent: of_damping.contact_damping_ratio_percent,
            gap_mm: self.gap_mm.or(other.gap_mm),
            mass_percent: self.mass_percent.or(other.mass_percent),
            cart_mass_percent: self.cart_mass_percent.or(other.cart_mass_percent),
            shaker_loop_percent: self.shaker_loop_percent.or(other.shaker_loop_percent),
            shaker_damping_percent: self.shaker_damping_percent.or(other.shaker_damping_percent),
        }
    }

    /// The uncertainty of a rig whose cart recoils or not: what is stated, else the usual widths. What only a cart that
    /// recoils feels has no width for one that does not.
    pub fn complete(&self, samples: u32, seed: u64, recoils: bool) -> Uncertainty {
        let usual = Uncertainty::usual(recoils);
        let of_recoil =
            |stated: Option<f64>, usual: f64| stated.filter(|_| recoils).unwrap_or(usual);
        let damping = match self.contact_damping_ratio_percent {
            Some(_) => 0.0,
            None => self
                .contact_damping_percent
                .unwrap_or(usual.contact_damping_percent),
        };
        let stiffness = match self.contact_stiffness_factor {
            Some(_) => 0.0,
            None => self
                .contact_stiffness_percent
                .unwrap_or(usual.contact_stiffness_percent),
        };
        Uncertainty {
            natural_frequency_percent: self
                .natural_frequency_percent
                .unwrap_or(usual.natural_frequency_percent),
            amplitude_percent: self.amplitude_percent.unwrap_or(usual.amplitude_percent),
            contact_stiffness_percent: stiffness,
            contact_stiffness_factor: self.contact_stiffness_factor,
            contact_damping_percent: damping,
            contact_damping_ratio_percent: self.contact_damping_ratio_percent,
            gap_mm: self.gap_mm.unwrap_or(usual.gap_mm),
            samples,
            seed,
            mass_percent: self.mass_percent.unwrap_or(usual.mass_percent),
            cart_mass_percent: of_recoil(self.cart_mass_percent, usual.cart_mass_percent),
            shaker_loop_percent: of_recoil(self.shaker_loop_percent, usual.shaker_loop_percent),
            shaker_damping_percent: of_recoil(
                self.shaker_damping_percent,
                usual.shaker_damping_percent,
            ),
        }
    }
}

impl Default for Uncertainty {
    /// Of a cart moved as prescribed.
    fn default() -> Self {
        Self {
            natural_frequency_percent: 2.0,
            amplitude_percent: 5.0,
            contact_stiffness_percent: 20.0,
            contact_stiffness_factor: None,
            contact_damping_percent: 20.0,
            contact_damping_ratio_percent: None,
            gap_mm: 0.05,
            samples: 256,
            seed: 1,
            mass_percent: 0.0,
            cart_mass_percent: 0.0,
            shaker_loop_percent: 0.0,
            shaker_damping_percent: 0.0,
        }
    }
}

/// Dimensions of the uncertainty.
const DIMENSIONS: usize = 9;
/// This dimension, the hammer's mass, moves with the next, the cart's, in the corners: it is weighed to little, and a corner
/// of its own would double their number. In the samples they move by themselves.
const WITH_THE_NEXT: usize = 5;
/// Where more axes than this are open, the corners are a fraction of all: so many axes freely, and each of the others on
/// the side that [`GENERATORS`] say.
const FREE: usize = 6;
/// The free axes whose sides multiply to that of the first and of the second axis beyond them. With two, this is the design
/// 2^(8−2) of resolution V of the textbooks (Box, Hunter and Hunter, Statistics for Experimenters; NIST/SEMATECH e-Handbook
/// of Statistical Methods, 5.3.3.4): every side of any four axes meets every side of the others' four, and the first five
/// axes have all their corners.
const GENERATORS: [&[usize]; 2] = [&[0, 1, 2, 3], &[0, 1, 4, 5]];

impl Uncertainty {
    /// The usual widths, of a cart that recoils or not.
    pub fn usual(recoils: bool) -> Self {
        let prescribed = Self::default();
        if !recoils {
            return prescribed;
        }
        Self {
            cart_mass_percent: 5.0,
            shaker_loop_percent: 30.0,
            shaker_damping_percent: 30.0,
            ..prescribed
        }
    }

    /// The half-widths of the deviations of a [`Member`].
    fn half_widths(&self) -> [f64; DIMENSIONS] {
        let damping = self.contact_damping_ratio_percent;
        let stiffness = match self.contact_stiffness_factor {
            Some(factor) => factor.ln(),
            None => self.contact_stiffness_percent / 100.0,
        };
        [
            self.natural_frequency_percent / 100.0,
            self.amplitude_percent / 100.0,
            stiffness,
            damping.unwrap_or(self.contact_damping_percent) / 100.0,
            self.gap_mm / 1e3,
            self.mass_percent / 100.0,
            self.cart_mass_percent / 100.0,
            self.shaker_loop_percent / 100.0,
            self.shaker_damping_percent / 100.0,
        ]
    }

    /// The dimensions that have a width, those that move together in the corners as one.
    fn axes(&self) -> Vec<Vec<usize>> {
        let widths = self.half_widths();
        let mut axes: Vec<Vec<usize>> = Vec::new();
        for i in (0..DIMENSIONS).filter(|i| widths[*i] != 0.0) {
            match axes.last_mut() {
                Some(last) if *last == [WITH_THE_NEXT] && i == WITH_THE_NEXT + 1 => last.push(i),
                _ => axes.push(vec![i]),
            }
        }
        axes
    }

    /// How many of the members are corners: all of them up to six dimensions, else a quarter or half.
    fn corner_count(&self) -> usize {
        match self.axes().len() {
            0 => 0,
            axes => 1 << axes.min(FREE),
        }
    }

    /// The corners of the dimensions that have a width: all of them for up to six, else a fraction.
    pub fn corners(&self) -> Vec<Member> {
        self.members()
            .into_iter()
            .take(self.corner_count())
            .collect()
    }

    /// Every member: the corners, then the samples inside them.
    pub fn members(&self) -> Vec<Member> {
        let widths = self.half_widths();
        let axes = self.axes();
        if axes.is_empty() {
            return Vec::new();
        }
        let corner = |bits: usize| {
            let side = |axis: usize| if bits >> axis & 1 == 0 { -1.0 } else { 1.0 };
            let mut deviation = [0.0; DIMENSIONS];
            for (axis, dimensions) in axes.iter().enumerate() {
                let side = match axis.checked_sub(FREE) {
                    None => side(axis),
                    Some(beyond) => GENERATORS[beyond].iter().map(|free| side(*free)).product(),
                };
                for i in dimensions {
                    deviation[*i] = side;
                }
            }
            deviation
        };
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let corners = (0..self.corner_count()).map(corner);
        let samples = (0..self.samples).map(|_| {
            let mut deviation = [0.0; DIMENSIONS];
            for i in axes.iter().flatten() {
                deviation[*i] = random.random_range(-1.0..=1.0);
            }
            deviation
        });
        let member = |d: [f64; DIMENSIONS]| Member {
            deviations: std::array::from_fn(|i| d[i] * widths[i]),
            stiffness_factor: self.contact_stiffness_factor.is_some(),
            damping_ratio: self.contact_damping_ratio_percent.is_some(),
        };
        corners.chain(samples).map(member).collect()
    }
}

/// One rig within the uncertainty: its relative deviations, and that of the gap in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Member {
    deviations: [f64; DIMENSIONS],
    /// Whether the deviation of the contact's stiffness is the logarithm of a factor.
    stiffness_factor: bool,
    /// Whether the contact's damping deviates as a ratio.
    damping_ratio: bool,
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
        rig.contact = scale_contact(&rig.contact, by_stiffness, by_damping);
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
    use shared::model::params::{WIRES, preset};

    use crate::orbit::Orbit;
    use crate::pick::search::follow_member;
    use crate::pick::{Limits, best_branch, pick};
    use crate::row::NamedRig;

    #[test]
    fn members_are_all_corners_and_the_same_samples_for_the_same_seed() {
        let uncertainty = Uncertainty::default();
        let members = uncertainty.members();
        assert_eq!(members.len(), 32 + 256);
        assert_eq!(members, uncertainty.members());
        assert_eq!(uncertainty.corners(), members[..32]);
        let extremes = members
            .iter()
            .filter(|m| m.deviations[0] == 0.02 && m.deviations[4] == -0.05e-3);
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
        let recoiling = Stated {
            shaker_damping_percent: Some(0.0),
            ..stated
        }
        .complete(0, 1, true);
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
        // Nobody stated them: they have widths nevertheless, and the rigs are hardly more.
        let usual = Stated::default().complete(256, 1, true);
        assert_eq!(usual.members().len(), 64 + 256);
        assert!(usual.cart_mass_percent > 0.0 && usual.shaker_damping_percent > 0.0);
    }

    /// One reading of a contact time gives both: a stiffer contact is damped more, at the same ratio.
    #[test]
    fn stiffness_and_damping_ratio_deviate_by_themselves() {
        let stated = Stated {
            contact_stiffness_percent: Some(81.0),
            contact_damping_ratio_percent: Some(10.0),
            ..Stated::default()
        };
        let uncertainty = stated.complete(64, 1, false);
        assert_eq!(uncertainty.members().len(), 32 + 64);
        let ratio = |rig: &RigParams| {
            let Law::SpringDashpot { stiffness, damping } = rig.contact else {
                panic!("{rig:?}");
            };
            (stiffness, damping / stiffness.sqrt())
        };
        let (stiffness, nominal) = ratio(&WIRES);
        let spread = |members: Vec<Member>| {
            let rigs = members.into_iter().map(|m| ratio(&m.apply(&WIRES, 1.0)));
            let mut sides: Vec<_> = rigs
                .map(|(k, z)| {
                    (
                        (100.0 * k / stiffness).round(),
                        (100.0 * z / nominal).round(),
                    )
                })
                .collect();
            sides.sort_by(|a, b| a.partial_cmp(b).unwrap());
            sides.dedup();
            sides
        };
        let corners = [(19.0, 90.0), (19.0, 110.0), (181.0, 90.0), (181.0, 110.0)];
        assert_eq!(spread(uncertainty.corners()), corners);
        let all = spread(uncertainty.members());
        assert!(
            all.iter().all(|(_, z)| (90.0..=110.0).contains(z)),
            "{all:?}"
        );
        // A law whose damping has no scale keeps it at another stiffness as it is.
        let law = Law::HuntCrossley {
            stiffness: 1e8,
            exponent: 1.5,
            damping_ratio: 0.4,
        };
        let rig = RigParams {
            contact: law,
            ..WIRES
        };
        let moved = uncertainty.corners()[0].apply(&rig, 1.0).contact;
        assert_eq!(moved, scale_contact(&law, 1.0 - 0.81, 1.0 - 0.1));
        // The two ways to state the damping take each other's place.
        let other = Stated {
            contact_damping_percent: Some(5.0),
            ..Stated::default()
        };
        let whole = other.or(&stated).complete(0, 1, false);
        assert_eq!(whole.contact_damping_ratio_percent, None);
        assert_eq!(whole.contact_damping_percent, 5.0);
        let whole = Stated::default().or(&stated).complete(0, 1, false);
        assert_eq!(whole.contact_damping_ratio_percent, Some(10.0));
        assert_eq!(whole.contact_damping_percent, 0.0);
    }

    /// Known to a decade, the stiffness is as often a third as three times its middle.
    #[test]
    fn a_stiffness_known_to_a_factor_deviates_by_it_up_and_down() {
        let stated = Stated {
            contact_stiffness_factor: Some(9.0),
            contact_damping_ratio_percent: Some(0.0),
            ..Stated::default()
        };
        let usual = Stated {
            contact_stiffness_percent: Some(20.0),
            ..Stated::default()
        };
        let uncertainty = stated.or(&usual).complete(64, 1, false);
        assert_eq!(uncertainty.contact_stiffness_percent, 0.0);
        let stiffness = |member: &Member, share| {
            let Law::SpringDashpot { stiffness, .. } = member.apply(&WIRES, share).contact else {
                panic!("{member:?}");
            };
            stiffness / 5.5e6
        };
        let corners = uncertainty.corners();
        assert_eq!(corners.len(), 16);
        for corner in &corners {
            let (whole, half) = (stiffness(corner, 1.0), stiffness(corner, 0.5));
            let by = if whole > 1.0 { whole } else { 1.0 / whole };
            assert!((by - 9.0).abs() < 1e-9, "{whole}");
            assert!((half * half / whole - 1.0).abs() < 1e-9, "{half}");
        }
        let members = uncertainty.members();
        let below = members.iter().filter(|m| stiffness(m, 1.0) < 1.0).count();
        assert!((30..=50).contains(&below), "{below} of 80");
        assert_eq!(usual.or(&stated).contact_stiffness_factor, None);
    }

    /// Of eight dimensions a quarter of the corners: every side of any four meets every side of the others, and the first
    /// five have all of theirs.
    #[test]
    fn a_fraction_of_the_corners_has_every_side_of_any_four_dimensions() {
        let stated = Stated {
            mass_percent: Some(1.0),
            cart_mass_percent: Some(1.0),
            shaker_loop_percent: Some(1.0),
            shaker_damping_percent: Some(1.0),
            ..Stated::default()
        };
        let uncertainty = stated.complete(0, 1, true);
        let corners = uncertainty.members();
        assert_eq!(corners.len(), 64);
        let side = |member: &Member, axis: usize| {
            // The hammer's mass moves with the cart's.
            let dimension = if axis < 5 { axis } else { axis + 1 };
            usize::from(member.deviations[dimension] > 0.0)
        };
        let all_met = |axes: &[usize]| {
            let of = |m: &Member| axes.iter().fold(0, |bits, axis| 2 * bits + side(m, *axis));
            let mut met: Vec<_> = corners.iter().map(of).collect();
            met.sort_unstable();
            met.dedup();
            met.len() == 1 << axes.len()
        };
        assert!(all_met(&[0, 1, 2, 3, 4]));
        for a in 0..8 {
            for b in 0..a {
                for c in 0..b {
                    for d in 0..c {
                        assert!(all_met(&[a, b, c, d]), "{a} {b} {c} {d}");
                    }
                }
            }
        }
        assert!(corners.iter().all(|m| m.deviations[5] == m.deviations[6]));
    }

    /// The corners that are computed are a quarter of all, and the strongest 1/1 at this gap is against the edge of what they
    /// have in common: the reserve is for the others.
    #[test]
    fn every_corner_has_a_stable_one_one_at_the_frequency_recommended() {
        let uncertainty = Uncertainty {
            samples: 0,
            ..Uncertainty::usual(true)
        };
        let whole: Vec<Member> = (0..256)
            .map(|bits: usize| {
                let widths = uncertainty.half_widths();
                let mut deviations = [0.0; DIMENSIONS];
                let open = (0..DIMENSIONS).filter(|i| widths[*i] != 0.0);
                for (bit, i) in open.enumerate() {
                    let side = if bits >> bit & 1 == 0 { -1.0 } else { 1.0 };
                    deviations[i] = side * widths[i];
                }
                Member {
                    deviations,
                    stiffness_factor: false,
                    damping_ratio: false,
                }
            })
            .collect();
        for (name, gap_mm) in [
            ("wires", 2.5),
            ("wires", 0.0),
            ("wires", 1.0),
            ("wires", 2.4),
            ("wires", 3.0),
            ("beam-170", 0.0),
            ("beam-150", 1.0),
        ] {
            let params = RigParams {
                cart: CartDrive::Loop(ASSUMED_SHAKER),
                ..preset(name).unwrap().with_gap_mm(gap_mm).unwrap()
            };
            let rig = NamedRig::new(name, params);
            let found = pick(&rig, Some(uncertainty), Limits::default(), &()).unwrap();
            let hz = found.answer.operating_frequency_hz;
            let orbit = best_branch(&rig).unwrap().at(&params, hz).unwrap();
            let lost = whole.iter().filter(|corner| {
                let own = follow_member(&params, corner, &orbit, hz);
                !own.as_ref().is_some_and(Orbit::is_stable_one_one)
            });
            println!(
                "{name} {gap_mm} {hz} {:?} worst {}",
                found.answer.robust_band_hz, found.answer.multipliers_worst
            );
            assert_eq!(lost.count(), 0, "{name}, {gap_mm} mm, {hz} Hz");
        }
    }

    #[test]
    fn no_share_is_the_rig_itself() {
        for member in Uncertainty::default().members() {
            assert_eq!(member.apply(&WIRES, 0.0), WIRES);
            assert_eq!(member.apply(&WIRES, 1.0).check(), Ok(()));
        }
    }
}
