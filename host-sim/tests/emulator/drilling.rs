//! Ground that gives way: the plant against the integrator of `drill`, which locates every switch by another method and has
//! the ground's own motion in closed form.

use emulator::ground::Ground;
use emulator::plant::Plant;
use numerics::drill::{Drill, Feed};
use shared::model::params::{BEAM_150, RigParams, WIRES};
use shared::model::slider::Slider;

use crate::support::{TICK_S, contacts, on_the_sine, rest};

/// Drive periods; the hammer is in flight at their end.
const PERIODS: u32 = 12;

#[test]
fn the_plant_drills_what_the_integrator_drills() {
    let gap = RigParams {
        gap_m: 5e-4,
        ..WIRES
    };
    for (params, ratio, threshold) in [
        (WIRES, 2.04, 25.0),
        (WIRES, 2.0, 60.0),
        (gap, 1.8, 25.0),
        (BEAM_150, 2.0, 100.0),
    ] {
        let slider = Slider {
            stiffness: 5.5e6,
            damping: 1.2e3,
            threshold,
        };
        let hz = ratio * params.natural_frequency_hz();
        let ground = Ground {
            slider,
            // No feed.
            feed_s: 1e15,
            slipping: false,
        };
        let plant = Plant::prescribed(&params, TICK_S).unwrap();
        let mut plant = plant.on_ground(Some(ground));
        plant.set_state(on_the_sine(&params, hz, rest(&params), 0.0));
        let seen = contacts(&mut plant, &params, hz, TICK_S, f64::from(PERIODS) / hz);
        let mut drill = Drill::<f64>::hammer(&params, &slider, Feed::Speed(0.0), hz).unwrap();
        let mut truth = Vec::new();
        for _ in 0..PERIODS {
            drill.run_period(&mut truth);
        }
        assert_eq!(seen.len(), truth.len(), "{threshold} N");
        let (dug, known) = (plant.progress_m(), drill.drift_m());
        assert!(known > 1e-6, "{threshold} N: {known}");
        assert!(
            (dug / known - 1.0).abs() < 1e-5,
            "{threshold} N: {dug} {known}"
        );
        for (a, b) in seen.iter().zip(&truth) {
            assert!((a.onset_s - b.onset_s).abs() < 1e-7, "{threshold} N");
            let (force, known) = (a.peak_force_n, b.peak_force_n);
            assert!(
                (force - known).abs() < 1e-6 * threshold,
                "{threshold} N, {} s: {force} {known}",
                a.onset_s
            );
        }
    }
}
