//! The lanes with a cart that recoils.

use numerics::lanes::{Cell, CellPlan, Instructions, run_reported, run_with};
use rand::{Rng, SeedableRng};
use shared::model::cart::{ASSUMED_SHAKER, CartDrive, LoopParams};
use shared::model::params::{PRESETS, WIRES};
use shared::model::regime::Regime;
use shared::model::rig::Rig;

use super::{FULL, agreement, agrees_with_the_reference, by_reference, cell, close, sample};

fn held(mut one: Cell, frequency_hz: f64) -> Cell {
    one.params.cart = CartDrive::Loop(LoopParams {
        frequency_hz,
        ..ASSUMED_SHAKER
    });
    one
}

/// Cells of maps of the four rigs over the same ratios, on loops of 25 to 100 Hz.
fn recoiling(count: usize, seed: u64) -> Vec<Cell> {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    (0..count)
        .map(|i| {
            let rig = PRESETS[i % PRESETS.len()].1;
            let gap = f64::from(random.random_range(0..357)) * 1e-5;
            let ratio = (1.41 + 0.01 * f64::from(random.random_range(0..588))) / 1.82;
            let hz = 25.0 * 4_f64.powf(random.random());
            held(cell(rig, gap, ratio * rig.natural_frequency_hz()), hz)
        })
        .collect()
}

#[test]
fn random_cells_of_four_rigs_agree_with_the_reference() {
    agrees_with_the_reference(&recoiling(60, 1), 30, 90);
}

/// At rest its acceleration is rounding, of either sign: the reference had to run every third of these.
#[test]
fn a_hammer_at_rest_on_the_surface_stays_in_the_lanes() {
    for (name, rig) in PRESETS {
        let hz = rig.natural_frequency_hz();
        let at = |i: i32| held(cell(rig, 0.0, (2.0 + 0.05 * f64::from(i)) * hz), 50.0);
        let cells: Vec<_> = (0..40).map(at).collect();
        let (_, report) = run_with(Instructions::Widest, &cells, &FULL).unwrap();
        assert_eq!(report.lanes, 40, "{name}: {report:?}");
    }
}

/// Section, contacts and force of each of the first cycles, from starts at several phases.
#[test]
fn the_first_cycles_follow_the_reference() {
    let plan = CellPlan {
        cycles: 6,
        recorded: 6,
        early: false,
        strobes: 6,
    };
    for (_, rig) in PRESETS {
        for (phase, gap, loop_hz) in [(0.0, 0.0, 50.0), (0.25, 1e-3, 30.0), (0.6, 2e-3, 80.0)] {
            let hz = 1.7 * rig.natural_frequency_hz();
            let mut one = held(cell(rig, gap, hz), loop_hz);
            one.phase = phase;
            let scale = Rig::<f64>::new(&one.params).unwrap().coordinate_scale();
            one.start[1] = 1.5 * scale * std::f64::consts::TAU * hz;
            let best = Instructions::Widest;
            let (ours, report) = run_with(best, &[one], &plan).unwrap();
            assert_eq!(report.lanes, 1);
            let theirs = by_reference(&[one], &plan);
            for (a, b) in ours[0].strobes.iter().zip(&theirs[0].strobes) {
                assert!((a.q - b.q).abs() < 2e-4 * scale, "{phase} {a:?} {b:?}");
                assert_eq!(a.onsets, b.onsets, "{phase}");
                assert!(close(a.force_n, b.force_n, 1e-3), "{phase} {a:?} {b:?}");
            }
            assert_eq!(ours[0].last_contact, theirs[0].last_contact);
        }
    }
}

/// A cart so heavy that no contact moves it is a prescribed one.
#[test]
fn a_very_heavy_cart_is_a_prescribed_one() {
    let free = sample(200, 5);
    let heavy: Vec<_> = free
        .iter()
        .map(|one| {
            let mut one = held(*one, 50.0);
            one.params.cart_mass_kg = 1e6;
            one
        })
        .collect();
    let best = Instructions::Widest;
    let (theirs, _) = run_with(best, &free, &FULL).unwrap();
    let (ours, report) = run_with(best, &heavy, &FULL).unwrap();
    let (both, same, force) = agreement(&ours, &theirs);
    assert!(both > 80 && report.unfit == 0, "{both} {report:?}");
    assert!(
        same + 1 >= both && force + 1 >= both,
        "{both} {same} {force}"
    );
}

/// Chatter and contacts over the section, which are computed one at a time.
#[test]
fn chatter_ends_as_the_reference_has_it() {
    let plan = CellPlan {
        cycles: 40,
        recorded: 20,
        early: false,
        strobes: 1,
    };
    let cells: Vec<_> = (0..12)
        .map(|i| held(cell(WIRES, 0.0, 1.41 + 0.05 * f64::from(i)), 50.0))
        .collect();
    let best = Instructions::Widest;
    let (ours, report) = run_with(best, &cells, &plan).unwrap();
    let theirs = by_reference(&cells, &plan);
    let mut chatters = 0;
    for ((a, b), one) in ours.iter().zip(&theirs).zip(&cells) {
        assert_eq!(a.regime, b.regime, "{} Hz", one.frequency_hz);
        assert!(close(a.force_n, b.force_n, 1e-3), "{} Hz", one.frequency_hz);
        chatters += usize::from(matches!(a.regime, Regime::Chatter { .. }));
    }
    assert!(chatters >= 3 && report.work.sustained > 0, "{chatters}");
    assert_eq!(report.flagged, 0, "{report:?}");
}

#[test]
fn every_instruction_set_gives_the_same_bytes() {
    let cells = recoiling(60, 2);
    let plan = CellPlan {
        cycles: 60,
        recorded: 40,
        early: true,
        strobes: 3,
    };
    let (widest, _) = run_with(Instructions::Widest, &cells, &plan).unwrap();
    for instructions in [Instructions::Avx2, Instructions::Scalar] {
        let (other, _) = run_with(instructions, &cells, &plan).unwrap();
        assert_eq!(widest, other, "{instructions:?}");
    }
}

/// A loop as fast as the contact, one near the hammer's own frequency, one that is overdamped.
#[test]
fn loops_that_the_lanes_cannot_split_go_to_the_reference() {
    let plan = CellPlan {
        cycles: 5,
        recorded: 5,
        early: true,
        strobes: 0,
    };
    let mut damped = held(cell(WIRES, 0.5e-3, 3.0), 50.0);
    damped.params.cart = CartDrive::Loop(LoopParams {
        damping_ratio: 1.2,
        ..ASSUMED_SHAKER
    });
    let stiff = held(cell(WIRES, 0.5e-3, 3.0), 600.0);
    let soft = held(cell(WIRES, 0.5e-3, 3.0), 4.0);
    let cells = [damped, stiff, soft];
    let (ours, report) = run_reported(&cells, &plan).unwrap();
    assert_eq!(report.unfit, 3);
    assert_eq!(ours, by_reference(&cells, &plan));
    let (_, report) = run_with(Instructions::Widest, &[held(cells[0], 50.0)], &plan).unwrap();
    assert_eq!(report.lanes, 1);
}
