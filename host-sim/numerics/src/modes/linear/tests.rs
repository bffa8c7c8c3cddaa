use shared::model::cart::ASSUMED_SHAKER;
use shared::model::params::{BEAM_135, BEAM_170, SupportParams};

use super::*;
use crate::branch::one_one_branches;
use crate::engine::{CycleRecorder, Engine, Plan, Start, machine, observe as run};
use crate::modes::observe::watched;
use crate::modes::tests::observed;
use crate::modes::{BendingMode, TipJoint};
use crate::orbit::shoot_at;

const BEAM: Beam = Beam {
    tip: TipJoint::Guided,
    mass_ratio: 0.1,
};

/// The one mode of a hammer on springs without mass.
fn lumped(natural_hz: f64, mass_kg: f64) -> Vec<BendingMode> {
    vec![BendingMode {
        root: 1.0,
        omega: TAU * natural_hz,
        mass_kg,
        participation_kg: mass_kg,
    }]
}

/// Springs that are linear.
fn linear(natural_frequency_hz: f64) -> SupportParams {
    SupportParams::Beams {
        natural_frequency_hz,
        damping_ratio: 0.004,
        cubic_stiffness_n_per_m3: Some(0.0),
    }
}

fn off(a: f64, b: f64) -> f64 {
    (a / b - 1.0).abs()
}

/// With one mode that has the hammer's mass this is the lumped rig, whose orbit the reference finds with a recoiling
/// cart: another method, and the equations of `shared`.
#[test]
fn one_mode_of_the_hammer_s_mass_is_the_reference_with_a_recoiling_cart() {
    for (params, gap_m, ratio, loop_hz) in [
        (BEAM_170, 0.0, 2.0, 50.0),
        (BEAM_135, 1e-3, 1.7, 12.0),
        (BEAM_170, -0.05e-3, 1.5, 200.0),
    ] {
        let held = LoopParams {
            frequency_hz: loop_hz,
            feed_forward: 0.8,
            ..ASSUMED_SHAKER
        };
        let natural_frequency_hz = params.natural_frequency_hz();
        let params = RigParams {
            gap_m,
            cart: CartDrive::Loop(held),
            support: linear(natural_frequency_hz),
            ..params
        };
        let hz = ratio * natural_frequency_hz;
        let branch = &one_one_branches(&params, (1.0, 3.0))[0];
        let known = branch.at(hz).unwrap();
        let open = RigParams {
            gap_m: gap_m.max(0.0),
            ..params
        };
        let mut rig = ModalRig::new(&open, BEAM, 1).unwrap();
        rig.gap_m = gap_m;
        rig.modes = lumped(natural_frequency_hz, params.mass_kg);
        let held = HoldingShaker {
            held,
            cart_kg: params.cart_mass_kg,
            hung_kg: params.mass_kg,
        };
        let motion = LinearMotion::new(&rig, Some(held), hz).unwrap();
        let found = motion.orbit(None).unwrap();
        assert!(off(found.force_n, known.force_n) < 1e-7, "{found:?}");
        let speed = known.contact.approach_speed_m_per_s;
        assert!(off(found.approach_m_per_s, speed) < 1e-7, "{speed}");
        let multiplier = known.multipliers().modulus();
        assert!(off(found.multiplier, multiplier) < 1e-3, "{multiplier}");
        let shot = shoot_at(&params, hz, known.at(), 1).unwrap();
        assert!(off(shot.force_n, found.force_n) < 1e-7);
    }
}

/// With five modes and a prescribed cart, against runs from rest of the engine with closed-form flights and integrated
/// contacts.
#[test]
fn five_modes_are_those_of_the_other_engine() {
    let cycles = Plan {
        cycles: 400,
        transient: 390,
    };
    for hz in [8.6, 9.07, 9.45] {
        let rig = ModalRig::new(&BEAM_170, BEAM, 5).unwrap();
        let found = LinearMotion::of(&BEAM_170, BEAM, 5, hz)
            .unwrap()
            .orbit(None);
        let found = found.unwrap();
        let seen = observed(rig, hz, cycles);
        assert!(off(found.force_n, seen.force_n) < 1e-6, "{hz}: {found:?}");
        let approach = seen.approach_m_per_s.unwrap();
        assert!(off(found.approach_m_per_s, approach) < 1e-6, "{hz}");
    }
}

/// One mode of the hammer's mass in a recoiling cart, run from rest, is what the reference has from rest.
#[test]
fn a_run_in_a_recoiling_cart_is_the_reference_s() {
    let natural_hz = BEAM_170.natural_frequency_hz();
    for (gap_m, ratio) in [(0.0, 2.0), (1e-3, 1.7)] {
        let params = RigParams {
            gap_m,
            cart: CartDrive::Loop(ASSUMED_SHAKER),
            support: linear(natural_hz),
            ..BEAM_170
        };
        let mut rig = ModalRig::new(&params, BEAM, 1).unwrap();
        rig.modes = lumped(natural_hz, params.mass_kg);
        let held = HoldingShaker {
            held: ASSUMED_SHAKER,
            cart_kg: params.cart_mass_kg,
            hung_kg: params.mass_kg,
        };
        let hz = ratio * natural_hz;
        let cycles = Plan {
            cycles: 320,
            transient: 300,
        };
        let motion = LinearMotion::new(&rig, Some(held), hz).unwrap();
        let found = watched(Follower::at_rest(motion, &rig), &rig, hz, cycles).unwrap();
        let mut hammer = machine(Engine::Event, &params, hz, Start::Rest).unwrap();
        let known = run(hammer.as_mut(), cycles, &mut CycleRecorder::default()).unwrap();
        assert_eq!(found.regime, known.regime);
        let (force, exact) = (found.force_n, known.force_n);
        assert!(off(force, exact) < 1e-7, "{force} {exact}");
        let strongest = known.strongest.unwrap();
        let approach = found.approach_m_per_s.unwrap();
        assert!(off(approach, strongest.approach_speed_m_per_s) < 1e-6);
        let lost = strongest.energy_lost_j * hz;
        let loss = found.contact_loss_w;
        assert!(off(loss, lost) < 1e-6, "{loss} {lost}");
    }
}

/// With five modes in a prescribed cart it sees what the other engine sees.
#[test]
fn a_run_with_five_modes_is_the_other_engine_s() {
    let cycles = Plan {
        cycles: 320,
        transient: 300,
    };
    let rig = ModalRig::new(&BEAM_170, BEAM, 5).unwrap();
    let known = observed(rig.clone(), 9.07, cycles);
    let motion = LinearMotion::of(&BEAM_170, BEAM, 5, 9.07).unwrap();
    let found = watched(Follower::at_rest(motion, &rig), &rig, 9.07, cycles).unwrap();
    assert_eq!(found.regime, known.regime);
    let pairs = [
        (found.force_n, known.force_n),
        (found.reach_m[1], known.reach_m[1]),
        (found.contact_loss_w, known.contact_loss_w),
        (found.energy_j[0], known.energy_j[0]),
        (found.energy_j[1], known.energy_j[1]),
        (found.loss_w[1], known.loss_w[1]),
    ];
    for (i, (a, b)) in pairs.into_iter().enumerate() {
        assert!(off(a, b) < 1e-3, "{i}: {a} {b}");
    }
}

/// The derivative of the return map against differences, in every direction, with five modes and a recoiling cart.
#[test]
fn the_derivative_is_that_of_the_return_map() {
    let params = RigParams {
        cart: CartDrive::Loop(ASSUMED_SHAKER),
        ..BEAM_170
    };
    let motion = LinearMotion::of(&params, BEAM, 5, 9.0).unwrap();
    let orbit = motion.orbit(None).unwrap();
    let (_, derivative, _) = motion.image(&orbit.section).unwrap();
    for k in 0..orbit.section.len() {
        let h = 1e-6;
        let moved = |by: f64| {
            let mut at = orbit.section.clone();
            at[k] += by;
            motion.run(&at, 60, None).unwrap()
        };
        let (up, down) = (moved(h), moved(-h));
        for i in 0..up.len() {
            let difference = (up[i] - down[i]) / (2.0 * h);
            let exact = derivative.at(i, k);
            let size = exact.abs().max(1.0);
            assert!((difference - exact).abs() < 2e-4 * size, "{i} {k}");
        }
    }
}
