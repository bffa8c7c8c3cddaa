use super::*;
use crate::uncertainty::Uncertainty;
use shared::model::cart::{ASSUMED_SHAKER, CartDrive};
use shared::model::params::{BEAM_170, WIRES};

fn request<'a>(
    params: &'a RigParams,
    members: &'a [Member],
    hz: (f64, f64, f64),
) -> BendingRequest<'a> {
    BendingRequest {
        params,
        springs: Springs::default(),
        members,
        corners: members.len().saturating_sub(8),
        chosen_hz: hz.1,
        band_hz: (hz.0, hz.2),
        kept_hz: (hz.0, hz.2),
        max_force_n: None,
    }
}

/// Inside the safe band of one mode, 8.317 to 9.802 Hz with a prescribed cart, five modes have 81 to 82 % of the force at
/// 8.60 and 9.45 Hz: both are outside what is left of it, and the force at its ends is 90 %.
#[test]
fn the_band_of_several_modes_leaves_out_where_their_force_falls() {
    let bent = request(&BEAM_170, &[], (8.317, 9.036, 9.802))
        .run(&())
        .unwrap();
    let Bent {
        bending,
        chosen_hz,
        band_hz,
    } = bent.unwrap();
    assert_eq!(chosen_hz, 9.036);
    assert!((2..=5).contains(&bending.modes.unwrap()), "{bending:?}");
    let least = bending.one_mode_safe_band_force_share.unwrap();
    assert!((0.79..0.83).contains(&least), "{least}");
    assert!(8.60 < band_hz.0 && band_hz.1 < 9.45, "{band_hz:?}");
    assert!(band_hz.0 < 8.75 && 9.3 < band_hz.1, "{band_hz:?}");
    let weak = bending.modes_weak_hz.unwrap();
    assert!(
        weak.len() == 2 && (weak[0] - 8.58).abs() < 0.05 && (weak[1] - 9.44).abs() < 0.05,
        "{weak:?}"
    );
    let five = Modal {
        params: &BEAM_170,
        beam: Springs::default().beam,
        modes: 5,
    };
    let at = |hz: f64| five.at(hz, None).unwrap().force_n;
    for hz in [8.60, 9.45] {
        let share = at(hz) / at(9.036);
        assert!((0.80..0.83).contains(&share), "{hz}: {share}");
    }
    for hz in [band_hz.0, band_hz.1] {
        let share = at(hz) / at(9.036);
        assert!((share - 0.9).abs() < 0.012, "{hz}: {share}");
    }
    // Exact parameters: no other rig, no other springs.
    assert_eq!(bending.modes_rigs, Some(1));
    assert_eq!(bending.safe_band_force_share_any_springs, None);
}

/// Springs whose second mode meets a multiple of the lumped choice move the choice off it.
#[test]
fn a_choice_in_a_dip_is_moved_out_of_it() {
    let moved = request(&BEAM_170, &[], (8.317, 9.45, 9.802))
        .run(&())
        .unwrap()
        .unwrap();
    assert!((8.9..9.25).contains(&moved.chosen_hz), "{moved:?}");
    assert_eq!(moved.bending.one_mode_frequency_hz, Some(9.45));
}

#[test]
fn the_uncertainty_has_every_member_and_springs_of_other_masses() {
    let params = RigParams {
        cart: CartDrive::Loop(ASSUMED_SHAKER),
        ..BEAM_170
    };
    let uncertainty = Uncertainty {
        natural_frequency_percent: 0.0,
        contact_stiffness_percent: 0.0,
        contact_damping_percent: 0.0,
        samples: 8,
        ..Uncertainty::default()
    };
    let members = uncertainty.members();
    let bent = request(&params, &members, (8.8, 9.07, 9.3))
        .run(&())
        .unwrap();
    let found = bent.unwrap().bending;
    assert_eq!(found.modes_rigs, Some(3 * 4 + 8 + 1));
    assert_eq!(found.modes_rigs_one_one, found.modes_rigs);
    let (worst, ratio, largest) = (
        found.modes_force_ratio_worst.unwrap(),
        found.modes_force_ratio.unwrap(),
        found.modes_force_ratio_largest.unwrap(),
    );
    assert!(worst < 0.9 * ratio && 1.03 * ratio < largest, "{found:?}");
    assert!(found.safe_band_force_share_any_springs.unwrap() < 0.9);
    assert!(found.modes_multipliers_worst.unwrap() < 1.0);
}

#[test]
fn wires_have_no_modes_and_a_multiple_meets_a_mode_where_it_should() {
    assert_eq!(
        request(&WIRES, &[], (3.4, 3.7, 4.0)).run(&()).unwrap(),
        None
    );
    assert!(!on_beams(&WIRES) && on_beams(&BEAM_170));
    assert_eq!(meeting(90.0, 8.9..=10.0), [9.0, 10.0]);
    assert!(meeting(90.0, 9.1..=9.9).is_empty());
}
