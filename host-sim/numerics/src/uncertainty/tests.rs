use super::*;
use shared::model::cart::{ASSUMED_SHAKER, CartDrive};
use shared::model::contact::Law;
use shared::model::params::{RigParams, WIRES, preset};

use crate::limits::PickLimits;
use crate::orbit::Orbit;
use crate::pick::search::follow_member;
use crate::pick::{best_branch, pick};
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
    assert_eq!(moved, law.scaled(1.0 - 0.81, 1.0 - 0.1));
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
    let rigs = [
        ("wires", 2.5),
        ("beam-150", 1.0),
        ("wires", 0.0),
        ("wires", 1.0),
        ("wires", 2.4),
        ("wires", 3.0),
        ("beam-170", 0.0),
    ];
    let long = std::env::var_os("LONG_CHECKS").is_some();
    for (name, gap_mm) in rigs.into_iter().take(if long { 7 } else { 2 }) {
        let params = RigParams {
            cart: CartDrive::Loop(ASSUMED_SHAKER),
            ..preset(name).unwrap().with_gap_mm(gap_mm).unwrap()
        };
        let rig = NamedRig::new(name, params);
        let found = pick(&rig, Some(uncertainty), PickLimits::default(), &()).unwrap();
        let hz = found.answer.operating_frequency_hz;
        let orbit = best_branch(&rig).unwrap().at(hz).unwrap();
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
