//! Sensors and lines: what the controller gets to see.

use emulator::plant::Plant;
use emulator::sensors::{Defect, Errors, Sensor, SensorParams, Sensors};
use emulator::shaker::{Path, ShakerParams};
use numerics::noise::Noise;
use shared::io::{AdcCode, Reading};
use shared::model::params::{RigParams, WIRES};
use shared::settings::Settings;

use crate::support::{TICK_S, on_the_sine, rest, sine};

fn noiseless(settings: &Settings, params: SensorParams) -> Sensors {
    Sensors::new(&params, settings, TICK_S, 1)
}

#[test]
fn noise_is_gaussian_and_the_same_for_the_same_seed() {
    let mut noise = Noise::new(7);
    let mut again = Noise::new(7);
    let n = 200_000;
    let (mut sum, mut square, mut far) = (0.0, 0.0, 0);
    for _ in 0..n {
        let x = noise.sample();
        assert_eq!(x, again.sample());
        sum += x;
        square += x * x;
        far += u32::from(x.abs() > 3.0);
    }
    let n = f64::from(n);
    // Five standard errors each; beyond 3σ lie 0.27 %.
    assert!((sum / n).abs() < 5.0 / n.sqrt());
    assert!((square / n - 1.0).abs() < 5.0 * (2.0 / n).sqrt());
    assert!((f64::from(far) / n - 0.0027).abs() < 5.0 * (0.0027 / n).sqrt());
}

#[test]
fn a_still_rig_reads_its_calibration_with_offset_and_gain_error() {
    let params = RigParams {
        gap_m: 1e-3,
        ..WIRES
    };
    let settings = Settings::for_rig(&params);
    let mut plant = Plant::new(&params, &ShakerParams::default(), TICK_S).unwrap();
    plant.set_state(on_the_sine(&params, 1e-6, rest(&params) - 0.02, 0.0));
    let errors = SensorParams {
        hammer: Errors {
            offset: 20e-6,
            gain_error: 0.05,
            noise: 0.0,
        },
        ..SensorParams::default()
    };
    let mut sensors = noiseless(&settings, errors);
    let mut codes = [AdcCode::default(); 3];
    let mut path = 0.0;
    for _ in 0..100 {
        plant.tick(Path::default(), false);
        codes = sensors.read(&plant);
        path = plant.hammer_m();
    }
    let read = f64::from(settings.hammer.value(codes[1]));
    let want = 1.05 * path + 20e-6;
    // A code is 6.3 µm wide; the filter is 0.1 ms late on a hammer that falls at 1 mm/s by then.
    let lsb = f64::from(settings.hammer.unit_per_code);
    assert!((read - want).abs() < lsb, "{read} against {want}");
    assert_eq!(settings.force.read(codes[0]), Reading::Value(0.0));
}

#[test]
fn each_defect_shows_as_itself_and_goes() {
    let settings = Settings::for_rig(&WIRES);
    let plant = Plant::new(&WIRES, &ShakerParams::default(), TICK_S).unwrap();
    let noisy = Errors {
        noise: 20e-6,
        ..Errors::default()
    };
    let params = SensorParams {
        cart: noisy,
        ..SensorParams::default()
    };
    let mut sensors = Sensors::new(&params, &settings, TICK_S, 3);
    let mut read = |defect| {
        sensors.set_defect(Sensor::Cart, defect);
        (0..50).map(|_| sensors.read(&plant)[2]).collect::<Vec<_>>()
    };
    let moves = |codes: &[AdcCode]| codes.iter().any(|c| *c != codes[0]);
    let whole = read(None);
    assert!(moves(&whole));
    let all = |codes: Vec<AdcCode>, is: fn(Reading) -> bool| {
        codes.into_iter().all(|c| is(settings.cart.read(c)))
    };
    assert!(all(read(Some(Defect::Open)), |r| r == Reading::Open));
    assert!(all(read(Some(Defect::Saturated)), |r| matches!(
        r,
        Reading::Saturated(_)
    )));
    assert!(!moves(&read(Some(Defect::Frozen))));
    assert!(moves(&read(None)));
}

#[test]
fn the_surface_rings_at_half_the_peak_and_dies_away() {
    let settings = Settings::for_rig(&WIRES);
    let hz = 2.0 * WIRES.natural_frequency_hz();
    let mut plant = Plant::prescribed(&WIRES, TICK_S).unwrap();
    plant.set_state(on_the_sine(&WIRES, hz, rest(&WIRES), 0.0));
    let mut sensors = noiseless(&settings, SensorParams::default());
    let (mut largest, mut lowest, mut since) = (0.0_f64, 0.0_f64, None::<u64>);
    let mut late = 0.0_f64;
    let mut peak = 0.0;
    for k in 0..(12.0 / hz / TICK_S) as u64 {
        plant.tick(sine(&WIRES, hz, TICK_S, k), true);
        let force = f64::from(settings.force.value(sensors.read(&plant)[0]));
        let Some(blow) = plant.finished().last() else {
            if let Some(at) = since {
                let after = (k - at) as f64 * TICK_S;
                if after < 1e-3 {
                    lowest = lowest.min(force);
                    largest = largest.max(force);
                }
                // e⁻⁵ of a half.
                if (10e-3..11e-3).contains(&after) {
                    late = late.max(force.abs());
                }
            }
            continue;
        };
        since = Some(k);
        peak = blow.peak_force_n;
    }
    assert!(peak > 50.0, "{peak}");
    for swing in [-lowest, largest] {
        assert!((0.2..0.5).contains(&(swing / peak)), "{swing} of {peak}");
    }
    assert!(late < 0.01 * peak, "{late} of {peak}");
}
