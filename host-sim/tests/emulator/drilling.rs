//! Ground that gives way: the plant against the integrator of `drill`, which locates every switch by another method and has
//! the ground's own motion in closed form.

use emulator::ground::PlantGround;
use emulator::plant::Plant;
use emulator::shaker::ShakerParams;
use numerics::drill::{Drill, DrillSetting, Feed};
use shared::model::cart::{CartDrive, LoopParams};
use shared::model::params::{BEAM_150, RigParams, WIRES};
use shared::model::slider::Slider;

use crate::support::{TICK_S, contacts, on_the_sine, prescribed, rest, shaken};

/// Drive periods; the hammer is in flight at their end.
const PERIODS: u32 = 12;

/// A hop that ends more gently than this has been so short that the top of the ground has not relaxed, as the plant takes
/// it to have: when it ends is not the same then, what it gives is.
const GENTLE_M_PER_S: f64 = 1e-4;

/// Rig, Ω/ω, threshold.
fn points() -> [(RigParams, f64, f64); 4] {
    let gap = RigParams {
        gap_m: 5e-4,
        ..WIRES
    };
    [
        (WIRES, 2.04, 25.0),
        (WIRES, 2.0, 60.0),
        (gap, 1.8, 25.0),
        (BEAM_150, 2.0, 100.0),
    ]
}

fn slider(threshold: f64) -> Slider<f64> {
    Slider {
        stiffness: 5.5e6,
        damping: 1.2e3,
        threshold,
    }
}

/// Both from rest with no feed: the same contacts and the same progress.
fn assert_alike(plant: Plant, params: &RigParams, hz: f64, threshold: f64) {
    let slider = slider(threshold);
    let ground = PlantGround {
        slider,
        // No feed.
        feed_s: 1e15,
        slipping: false,
    };
    let mut plant = plant.on_ground(Some(ground));
    plant.set_state(on_the_sine(params, hz, rest(params), 0.0));
    let seen = contacts(&mut plant, params, hz, TICK_S, f64::from(PERIODS) / hz);
    let mut drill = Drill::<f64>::through(
        params,
        &DrillSetting::new(slider, None, Feed::Speed(0.0)),
        hz,
    )
    .unwrap();
    let mut truth = Vec::new();
    for _ in 0..PERIODS {
        drill.run_period(&mut truth);
    }
    assert_eq!(seen.len(), truth.len(), "{threshold} N");
    let (dug, known) = (plant.progress_m(), drill.drift_m());
    assert!(known > 1e-6, "{threshold} N: {known}");
    let apart = (dug / known - 1.0).abs();
    println!("{threshold} N: progress {apart:.1e}");
    assert!(apart < 1e-7, "{threshold} N: {dug} {known}");
    for (a, b) in seen.iter().zip(&truth) {
        let late = (a.onset_s - b.onset_s).abs();
        if late > 1e-7 {
            let apart = (a.impulse_n_s / b.impulse_n_s - 1.0).abs();
            let gentle = b.approach_speed_m_per_s < GENTLE_M_PER_S;
            assert!(gentle && apart < 1e-6, "{threshold} N: {late} s, {apart}");
            continue;
        }
        let (force, known) = (a.peak_force_n, b.peak_force_n);
        assert!(
            (force - known).abs() < 1e-6 * threshold,
            "{threshold} N, {} s: {force} {known}",
            a.onset_s
        );
    }
}

#[test]
fn the_plant_drills_what_the_integrator_drills() {
    for (params, ratio, threshold) in points() {
        let hz = ratio * params.natural_frequency_hz();
        let plant = prescribed(&params, TICK_S);
        assert_alike(plant, &params, hz, threshold);
    }
}

#[test]
fn with_a_cart_that_recoils_too() {
    for (params, ratio, threshold) in points() {
        for (loop_hz, loop_damping_ratio, feed_forward) in [(50.0, 0.7, 1.0), (12.0, 0.4, 0.8)] {
            let hz = ratio * params.natural_frequency_hz();
            let shaker = ShakerParams {
                loop_hz,
                loop_damping_ratio,
                feed_forward,
                force_n: f64::INFINITY,
                ..ShakerParams::default()
            };
            let plant = shaken(&params, &shaker, TICK_S);
            let cart = CartDrive::Loop(LoopParams {
                frequency_hz: loop_hz,
                damping_ratio: loop_damping_ratio,
                feed_forward,
                max_force_n: 1e9,
            });
            assert_alike(plant, &RigParams { cart, ..params }, hz, threshold);
        }
    }
}
