//! Sensors and lines: what the controller gets to see.

use emulator::sensors::{
    BadContactEnd, Defect, EmulatedSensor, SensorErrors, SensorParams, Sensors,
};
use emulator::shaker::{SetPointPath, ShakerParams};
use numerics::noise::Noise;
use shared::io::{AdcCode, Reading};
use shared::model::params::{RigParams, WIRES};
use shared::settings::Settings;

use crate::support::{TICK_S, on_the_sine, prescribed, rest, shaken, sine};

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
    let mut plant = shaken(&params, &ShakerParams::default(), TICK_S);
    plant.set_state(on_the_sine(&params, 1e-6, rest(&params) - 0.02, 0.0));
    let errors = SensorParams {
        hammer: SensorErrors {
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
        plant.tick(SetPointPath::default(), false);
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
    let plant = shaken(&WIRES, &ShakerParams::default(), TICK_S);
    let noisy = SensorErrors {
        noise: 20e-6,
        ..SensorErrors::default()
    };
    let params = SensorParams {
        cart: noisy,
        ..SensorParams::default()
    };
    let mut sensors = Sensors::new(&params, &settings, TICK_S, 3);
    let mut read = |defect| {
        sensors.end(0);
        if let Some(defect) = defect {
            sensors.begin(EmulatedSensor::Cart, 0, defect);
        }
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
    let mut plant = prescribed(&WIRES, TICK_S);
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

/// Values that a hammer sensor reads of a hammer held 1 mm past rest, at each of `ticks`, noiseless.
fn hammer_reads(defects: &[Defect], ticks: usize) -> Vec<f64> {
    let params = RigParams {
        gap_m: 3e-3,
        ..WIRES
    };
    let settings = Settings::for_rig(&params);
    let mut plant = shaken(&params, &ShakerParams::default(), TICK_S);
    let mut sensors = noiseless(&settings, SensorParams::default());
    let state = on_the_sine(&params, 0.0, rest(&params) + 1e-3 / 0.075, 0.0);
    // The filter settles before the defects come.
    for _ in 0..200 {
        plant.set_state(state);
        sensors.read(&plant);
    }
    for (id, defect) in defects.iter().enumerate() {
        sensors.begin(EmulatedSensor::Hammer, id, *defect);
    }
    let read = |_| f64::from(settings.hammer.value(sensors.read(&plant)[1]));
    (0..ticks).map(read).collect()
}

#[test]
fn every_defect_of_a_value_is_its_formula_and_several_add_up() {
    let codes = 6.4e-6;
    let close = |got: f64, want: f64| assert!((got - want).abs() < codes, "{got} against {want}");
    let whole = hammer_reads(&[], 1)[0];
    close(whole, 1e-3);
    close(hammer_reads(&[Defect::Reversed], 1)[0], -whole);
    close(hammer_reads(&[Defect::Offset(2e-3)], 1)[0], whole + 2e-3);
    close(hammer_reads(&[Defect::Gain(0.64)], 1)[0], 0.64 * whole);
    // After half a second.
    let drifted = hammer_reads(&[Defect::OffsetDrift(1e-3)], 10_001)[10_000];
    close(drifted, whole + 0.5e-3);
    close(
        hammer_reads(&[Defect::GainDrift(0.5)], 10_001)[10_000],
        1.25 * whole,
    );
    let both = [Defect::Reversed, Defect::Offset(0.4e-3), Defect::Gain(2.0)];
    close(hammer_reads(&both, 1)[0], 2.0 * (0.4e-3 - whole));
    // The whole signal, from code 0 on: at half the supply the zero of 2048 reads as 1024.
    let settings = Settings::for_rig(&WIRES);
    let zero_m = f64::from(settings.hammer.zero_code * settings.hammer.unit_per_code);
    close(
        hammer_reads(&[Defect::Supply(0.5)], 1)[0],
        0.5 * (whole - zero_m),
    );
}

#[test]
fn a_dead_sensor_keeps_its_noise_and_a_bad_contact_its_rhythm() {
    let dead = hammer_reads(&[Defect::Dead(Some(50e-6))], 20_000);
    let n = dead.len() as f64;
    let mean = dead.iter().sum::<f64>() / n;
    let variance = dead.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
    assert!(mean.abs() < 5.0 * 50e-6 / n.sqrt() + 1e-6, "{mean}");
    // Five standard errors of a variance, and the quantisation's twelfth.
    assert!((variance / 2.5e-9 - 1.0).abs() < 5.0 * (2.0 / n).sqrt() + 2e-3);
    for (at, is) in [
        (BadContactEnd::Open, 0),
        (BadContactEnd::High, 4095),
        (BadContactEnd::Low, 100),
    ] {
        let settings = Settings::for_rig(&WIRES);
        let bad = Defect::Intermittent {
            at,
            ticks: 2,
            of: 3,
        };
        let reads = hammer_reads(&[bad], 30);
        let end = f64::from(settings.hammer.value(AdcCode(is)));
        for (k, value) in reads.iter().enumerate() {
            assert_eq!(k % 3 < 2, (value - end).abs() < 1e-9, "{at:?} {k} {value}");
        }
    }
}

#[test]
fn a_late_sensor_reads_what_was_so_many_ticks_before() {
    let settings = Settings::for_rig(&WIRES);
    let hz = 2.0 * WIRES.natural_frequency_hz();
    let run = |late: Option<u32>| {
        let mut plant = prescribed(&WIRES, TICK_S);
        plant.set_state(on_the_sine(&WIRES, hz, rest(&WIRES), 0.0));
        let mut sensors = noiseless(&settings, SensorParams::default());
        if let Some(ticks) = late {
            sensors.begin(EmulatedSensor::Cart, 7, Defect::Delayed(ticks));
        }
        let mut codes = Vec::new();
        for k in 0..5000 {
            plant.tick(sine(&WIRES, hz, TICK_S, k), true);
            codes.push(sensors.read(&plant)[2]);
        }
        codes
    };
    let (now, late) = (run(None), run(Some(40)));
    assert_eq!(late[40..], now[..4960]);
    assert!(now[1000] != late[1000]);
}

#[test]
fn a_delay_that_drifts_grows_from_none_by_its_rate() {
    let settings = Settings::for_rig(&WIRES);
    let mut plant = prescribed(&WIRES, TICK_S);
    let mut sensors = [0, 1].map(|_| noiseless(&settings, SensorParams::default()));
    // 1 ms in half a second.
    sensors[1].begin(EmulatedSensor::Cart, 7, Defect::DelayDrift(2e-3));
    let hz = 2.0 * WIRES.natural_frequency_hz();
    plant.set_state(on_the_sine(&WIRES, hz, rest(&WIRES), 0.0));
    let mut seen = [Vec::new(), Vec::new()];
    for k in 0..10_001 {
        plant.tick(sine(&WIRES, hz, TICK_S, k), true);
        for (sensors, seen) in sensors.iter_mut().zip(&mut seen) {
            let code = sensors.read(&plant)[2];
            seen.push(f64::from(settings.cart.value(code)));
        }
    }
    let codes = 2.0 * f64::from(settings.cart.unit_per_code);
    for k in 20..10_001_usize {
        let late_ticks = 2e-3 * k as f64;
        let want = seen[0][k - late_ticks.round() as usize];
        // Half a tick at the largest speed, and the rounding of both codes.
        let reach = 0.5 * TICK_S * WIRES.amplitude_m * std::f64::consts::TAU * hz + codes;
        assert!(
            (seen[1][k] - want).abs() < reach,
            "{k}: {} {want}",
            seen[1][k]
        );
    }
    assert!((seen[1][9_900] - seen[0][9_900]).abs() > codes);
}

#[test]
fn scenarios_name_sensors_alone_together_and_from_the_start() {
    use emulator::scenario::parse;
    let parsed = |more: &str| {
        let text = format!("duration_s = 9.0\n[true_rig]\npreset = \"wires\"\n{more}");
        parse("mine", &text, "mine.toml")
    };
    let supply = "[[sensors.defects]]\nsensor = \"displacements\"\nfault = \"supply\"\ntimes = 0.5\n[[events]]\nat_s = 2.0\nkind = \"sensor-fault\"\nsensor = \"all\"\nfault = \"offset\"\noffset_n = 3.0\noffset_um = -20\nfor_s = 1.0\n";
    let scenario = parsed(supply).unwrap();
    let defects: Vec<_> = scenario.events.iter().map(|e| e.act.defects()).collect();
    let half = Some(Defect::Supply(0.5));
    assert_eq!(defects[0], [None, half, half]);
    let length = Some(Defect::Offset(-20.0 * 1e-6));
    assert_eq!(defects[1], [Some(Defect::Offset(3.0)), length, length]);
    assert_eq!(scenario.events[0].at_s, 0.0);
    for (how, complaint) in [
        (
            "fault = \"offset\"\noffset_n = 1.0",
            "offset_n goes with another fault",
        ),
        ("fault = \"offset\"", "needs offset_um"),
        ("fault = \"reversed\"\ntimes = 2.0", "takes no number"),
        (
            "fault = \"intermittent\"\nticks = 3\nof = 2",
            "ticks is 3, must be 1 to 2",
        ),
        ("fault = \"intermittent\"\nticks = 3", "needs of"),
        ("fault = \"delayed\"\ndelay_ms = -1.0", "delay_ms is -1"),
        ("fault = \"open\"\nat = \"high\"", "at goes with"),
        (
            "fault = \"dead\"\nat_s = 2.0",
            "at_s stands in events alone",
        ),
    ] {
        let text = format!("[[sensors.defects]]\nsensor = \"hammer\"\n{how}\n");
        let line = parsed(&text).unwrap_err().to_string();
        assert!(line.contains(complaint), "{line}");
        assert!(line.contains("[[sensors.defects]] 1"), "{line}");
    }
}
