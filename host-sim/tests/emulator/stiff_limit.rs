//! Prescribed motion, and the two bodies on their way to it, against the reference.

use emulator::record::TrueContact;
use emulator::shaker::ShakerParams;
use numerics::orbit::shoot;
use numerics::reference::{self, Reference};
use shared::model::cart::{CartDrive, LoopParams};
use shared::model::contacts::Period;
use shared::model::params::{BEAM_135, BEAM_150, RigParams, WIRES};
use shared::model::regime::{Detector, Regime};

use crate::support::{TICK_S, contacts, on_the_sine, prescribed, rest, shaken, sine};

/// Rig, ratio Ω/ω: 1/1 at both ends of its band, several contacts per cycle, a doubling, gaps.
fn points() -> Vec<(&'static str, RigParams, f64)> {
    let gap = |rig: RigParams, mm: f64| RigParams {
        gap_m: mm * 1e-3,
        ..rig
    };
    vec![
        ("wires 0.0 mm, 1.5", WIRES, 1.5),
        ("wires 0.0 mm, 2.0", WIRES, 2.0),
        ("wires 0.0 mm, 2.7", WIRES, 2.7),
        ("wires 1.0 mm, 1.5", gap(WIRES, 1.0), 1.5),
        ("beam-150 0.0 mm, 1.5", BEAM_150, 1.5),
        ("beam-150 0.0 mm, 2.0", BEAM_150, 2.0),
        ("beam-135 1.0 mm, 1.6", gap(BEAM_135, 1.0), 1.6),
    ]
}

#[test]
fn prescribed_motion_is_the_references() {
    for (name, params, ratio) in points() {
        let hz = ratio * params.natural_frequency_hz();
        let mut plant = prescribed(&params, TICK_S);
        plant.set_state(on_the_sine(&params, hz, rest(&params), 0.0));
        let seen = contacts(&mut plant, &params, hz, TICK_S, 25.0 / hz);
        let mut truth = Vec::<reference::LocatedContact>::new();
        let mut hammer = Reference::<f64>::at_rest(&params, hz).unwrap();
        for _ in 0..25 {
            hammer.run_period(&mut truth);
        }
        assert!(truth.len() >= 12, "{name}: {}", truth.len());
        assert!(
            seen.len().abs_diff(truth.len()) <= 1,
            "{name}: {}",
            seen.len()
        );
        let (mut late, mut force) = (0.0_f64, 0.0_f64);
        for (a, b) in seen.iter().zip(&truth) {
            late = late.max((a.onset_s - b.onset_s).abs());
            force = force.max((a.peak_force_n / b.peak_force_n - 1.0).abs());
        }
        println!(
            "{name}: {} contacts, onset {late:.1e} s, force {force:.1e}",
            truth.len()
        );
        // The cart's course is a cubic per tick, whose acceleration is off by (Ω · tick)²/12 at most.
        assert!(late < 1e-8, "{name}: {late:.1e} s");
        assert!(force < 1e-6, "{name}: {force:.1e}");
    }
}

/// Two bodies: the emulator's plant and the reference with a cart that recoils describe the same thing.
#[test]
fn a_cart_that_recoils_is_the_references() {
    for (name, params, ratio) in points() {
        for (loop_hz, loop_damping_ratio, feed_forward) in
            [(50.0, 0.7, 1.0), (12.0, 0.7, 1.0), (200.0, 0.4, 0.8)]
        {
            let hz = ratio * params.natural_frequency_hz();
            let cart = CartDrive::Loop(LoopParams {
                frequency_hz: loop_hz,
                damping_ratio: loop_damping_ratio,
                feed_forward,
                max_force_n: 1e9,
            });
            let shaker = ShakerParams {
                loop_hz,
                loop_damping_ratio,
                feed_forward,
                force_n: f64::INFINITY,
                ..ShakerParams::default()
            };
            let mut plant = shaken(&params, &shaker, TICK_S);
            plant.set_state(on_the_sine(&params, hz, rest(&params), 0.0));
            let seen = contacts(&mut plant, &params, hz, TICK_S, 25.0 / hz);
            let mut truth = Vec::<reference::LocatedContact>::new();
            let recoiling = RigParams { cart, ..params };
            let mut hammer = Reference::<f64>::at_rest(&recoiling, hz).unwrap();
            for _ in 0..25 {
                hammer.run_period(&mut truth);
            }
            assert!(truth.len() >= 12, "{name}, {loop_hz} Hz: {}", truth.len());
            assert!(
                seen.len().abs_diff(truth.len()) <= 1,
                "{name}, {loop_hz} Hz"
            );
            let (mut late, mut force) = (0.0_f64, 0.0_f64);
            for (a, b) in seen.iter().zip(&truth) {
                late = late.max((a.onset_s - b.onset_s).abs());
                force = force.max((a.peak_force_n / b.peak_force_n - 1.0).abs());
            }
            println!(
                "{name}, {loop_hz} Hz: {} contacts, onset {late:.1e} s, force {force:.1e}",
                truth.len()
            );
            assert!(late < 1e-8, "{name}, {loop_hz} Hz: {late:.1e} s");
            assert!(force < 1e-6, "{name}, {loop_hz} Hz: {force:.1e}");
        }
    }
}

fn regime_of_plant(params: &RigParams, hz: f64) -> Regime {
    // Whole ticks per period, so that the section falls on ticks.
    let per_period = (1.0 / (hz * TICK_S)).round();
    let tick_s = 1.0 / (hz * per_period);
    let mut plant = prescribed(params, tick_s);
    plant.set_state(on_the_sine(params, hz, rest(params), 0.0));
    let scale = plant.bodies().rig.coordinate_scale();
    let mut detector = Detector::new(scale, scale * std::f64::consts::TAU * hz);
    for cycle in 0..200 {
        let mut period = Period::<f64>::default();
        for k in 0..per_period as u64 {
            let before = plant.bodies().mode;
            plant.tick(sine(params, hz, tick_s, k), true);
            let onset =
                before != plant.bodies().mode && before == shared::model::rig::SwitchMode::Flight;
            period.onsets += u16::from(onset);
            period.touched |= plant.touched();
        }
        if cycle >= 150 {
            detector.push(plant.state().q, plant.state().v, &period);
        }
    }
    detector.regime()
}

#[test]
fn regimes_are_the_references() {
    for (name, params, ratio) in points() {
        let hz = ratio * params.natural_frequency_hz();
        let mut hammer = Reference::<f64>::at_rest(&params, hz).unwrap();
        let scale = hammer.rig().coordinate_scale();
        let mut detector = Detector::new(scale, scale * std::f64::consts::TAU * hz);
        for cycle in 0..200 {
            let period = hammer.run_period(&mut ());
            let (q, v) = hammer.state();
            if cycle >= 150 {
                detector.push(q, v, &period);
            }
        }
        let (got, want) = (regime_of_plant(&params, hz), detector.regime());
        println!("{name}: {got:?}");
        assert_eq!(got, want, "{name}");
    }
}

/// The second contact of two bodies that start on the 1/1 orbit of prescribed motion.
fn second_contact(params: &RigParams, hz: f64, section: [f64; 2], loop_hz: f64) -> TrueContact {
    // Fine enough for the loop: RK4 holds to about 2.8 of its angular frequency times the step.
    let tick_s = 0.1 / (std::f64::consts::TAU * loop_hz);
    let shaker = ShakerParams {
        loop_hz,
        loop_damping_ratio: 1.0,
        force_n: f64::INFINITY,
        ..ShakerParams::default()
    };
    let mut plant = shaken(params, &shaker, tick_s);
    plant.set_state(on_the_sine(params, hz, section[0], section[1]));
    let seen = contacts(&mut plant, params, hz, tick_s, 2.0 / hz);
    assert_eq!(seen.len(), 2);
    seen[1]
}

#[test]
fn a_stiffer_loop_converges_to_prescribed_motion() {
    for (params, ratio) in [(WIRES, 2.0), (BEAM_150, 2.0)] {
        let hz = ratio * params.natural_frequency_hz();
        let mut hammer = Reference::<f64>::at_rest(&params, hz).unwrap();
        for _ in 0..200 {
            hammer.run_period(&mut ());
        }
        let (q, v) = hammer.state();
        let orbit = shoot(&params, hz, [q, v]).unwrap();
        let mut last = None;
        for loop_hz in [4e3, 8e3, 16e3, 32e3] {
            let seen = second_contact(&params, hz, orbit.section, loop_hz);
            let late = (seen.onset_s - 1.0 / hz - orbit.contact.onset_s).abs();
            let force = (seen.peak_force_n / orbit.force_n - 1.0).abs();
            println!("{loop_hz} Hz: onset {late:.2e} s, force {force:.2e}");
            if let Some((later, stronger)) = last {
                // The cart gives way by the loop's compliance, ω⁻², before the blow ends.
                let order = f64::log2(later / late);
                assert!(order > 1.8, "{loop_hz}: onset, order {order:.2}");
                assert!(force < stronger, "{loop_hz}: force");
            }
            last = Some((late, force));
        }
        let (late, force) = last.unwrap();
        assert!(late < 2e-8 && force < 2e-5, "{late:.1e} s, {force:.1e}");
    }
}
