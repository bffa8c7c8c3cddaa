use super::*;
use crate::model::cart::{ASSUMED_SHAKER, LoopParams};
use crate::model::contact::Law;
use crate::model::params::{PRESETS, RigParams, WIRES};

/// 1.7 kg against rubber with a stroke of 4 mm: a 1/1 strikes with some 46 N (`host-sim pick`).
#[test]
fn a_larger_stroke_and_a_soft_contact_have_settings_that_suit_them() {
    let rig = RigParams {
        mass_kg: 1.7,
        amplitude_m: 2e-3,
        contact: Law::SpringDashpot {
            stiffness: 1.56e5,
            damping: 306.0,
        },
        ..WIRES
    }
    .with_natural_frequency_scaled(0.895 / 1.82);
    let settings = Settings::for_rig(&rig);
    assert_eq!(settings.check(), Ok(()));
    let on_n = settings.detection.on_n;
    assert!((3.0..12.0).contains(&on_n), "{on_n}");
    assert!(settings.trips.travel_m > 10.0 * 2e-3);
}

#[test]
fn a_force_wanted_that_is_hardly_detected_is_refused() {
    let mut settings = Settings::for_rig(&PRESETS[3].1);
    let on_n = settings.detection.on_n;
    for (force_n, holds) in [(0.0, true), (2.01 * on_n, true), (1.99 * on_n, false)] {
        settings.aim.force_n = force_n;
        assert_eq!(settings.check().is_ok(), holds, "{force_n}");
    }
}

#[test]
fn a_force_limit_that_cannot_be_kept_is_refused_by_name() {
    for (_, rig) in PRESETS {
        let mut settings = Settings::for_rig(&rig);
        let on_n = settings.detection.on_n;
        for (limit_n, holds) in [(2.01 * on_n, true), (1.99 * on_n, false)] {
            settings.limits.force_n = limit_n;
            settings.trips.force_n = 1.5 * limit_n;
            let key = settings.check().map_err(|error| error.key);
            assert_eq!(key, if holds { Ok(()) } else { Err("limits.force_n") });
        }
        settings.limits.force_n = settings.least_force_n();
        assert_eq!(settings.check(), Ok(()));
    }
}

#[test]
fn defaults_of_every_rig_pass_and_what_is_out_of_range_is_named() {
    for (name, rig) in PRESETS {
        assert_eq!(Settings::for_rig(&rig).check(), Ok(()), "{name}");
    }
    let mut settings = Settings::for_rig(&PRESETS[0].1);
    settings.rig.mass_kg = -1.0;
    assert!(settings.check().unwrap_err().key.starts_with("mass"));
}

#[test]
fn a_shaker_that_no_forecast_can_follow_is_refused_by_name() {
    let refused = |change: fn(&mut RigParams, &mut LoopParams)| {
        let (mut rig, mut held) = (PRESETS[0].1, ASSUMED_SHAKER);
        change(&mut rig, &mut held);
        rig.cart = CartDrive::Loop(held);
        Settings::for_rig(&rig).check().err().map(|e| e.key)
    };
    assert_eq!(refused(|_, _| ()), None);
    assert_eq!(refused(|rig, _| rig.cart_mass_kg = 1e3), None);
    assert_eq!(refused(|_, held| held.feed_forward = 0.0), None);
    for hz in [0.1, 0.99, 500.1, 0.0, -50.0, f64::INFINITY, f64::NAN] {
        let (mut rig, held) = (PRESETS[0].1, ASSUMED_SHAKER);
        rig.cart = CartDrive::Loop(LoopParams {
            frequency_hz: hz,
            ..held
        });
        let error = Settings::for_rig(&rig).check().unwrap_err();
        assert_eq!(error.key, "shaker_loop_hz", "{hz}");
    }
    let (damping, loop_hz) = (Some("shaker_damping_ratio"), Some("shaker_loop_hz"));
    assert_eq!(refused(|_, held| held.damping_ratio = 0.0), damping);
    assert_eq!(refused(|_, held| held.damping_ratio = 10.0), damping);
    assert_eq!(refused(|_, held| held.damping_ratio = f64::NAN), damping);
    // The fast root of 50 Hz with 5 lies at 495 Hz, that of 51 Hz at 505 Hz.
    let strongly_damped = |hz| {
        let mut rig = PRESETS[0].1;
        rig.cart = CartDrive::Loop(LoopParams {
            frequency_hz: hz,
            damping_ratio: 5.0,
            ..ASSUMED_SHAKER
        });
        check_shaker(&rig).err().map(|e| e.key)
    };
    assert_eq!(
        (strongly_damped(50.0), strongly_damped(51.0)),
        (None, loop_hz)
    );
    assert_eq!(
        refused(|rig, _| rig.cart_mass_kg = 1e-3),
        Some("cart_mass_kg")
    );
    assert_eq!(
        refused(|rig, _| rig.cart_mass_kg = f64::NAN),
        Some("cart_mass_kg")
    );
    let feed = Some("shaker_feed_forward");
    assert_eq!(refused(|_, held| held.feed_forward = f64::NAN), feed);
    assert_eq!(refused(|_, held| held.feed_forward = -0.1), feed);
}

#[test]
fn a_heartbeat_needs_a_timeout() {
    let mut settings = Settings::for_rig(&PRESETS[0].1);
    settings.trips.link_timeout_s = 0.0;
    assert_eq!(settings.check(), Ok(()));
    settings.operator.heartbeat = true;
    assert_eq!(settings.check().unwrap_err().key, "trips.link_timeout_s");
    settings.trips.link_timeout_s = 0.1;
    assert_eq!(settings.check(), Ok(()));
}

#[test]
fn what_a_sensor_cannot_measure_cannot_be_a_trip_level() {
    type Change = fn(&mut Settings);
    // A tenth beyond what is allowed, and a tenth below it.
    let cases: [(&str, Change, Change); 10] = [
        // The wires' force sensor reaches 490 N; 95 % of that are 465 N.
        (
            "trips.force_n",
            |s| s.trips.force_n = 500.0,
            |s| s.trips.force_n = 460.0,
        ),
        // 12.1 mm; 95 % of that less 1.3 mm are 10.2 mm.
        (
            "trips.travel_m",
            |s| s.trips.travel_m = 11e-3,
            |s| s.trips.travel_m = 10.1e-3,
        ),
        (
            "trips.cart_m",
            |s| s.trips.cart_m = 2.6e-3,
            |s| s.trips.cart_m = 2.3e-3,
        ),
        // A sensor whose zero is off its middle reaches less far on one side.
        (
            "trips.cart_m",
            |s| s.cart.zero_code = 1500.0,
            |s| s.cart.zero_code = 1800.0,
        ),
        (
            "trips.travel_m",
            |s| s.hammer.zero_code = 2350.0,
            |s| s.hammer.zero_code = 2060.0,
        ),
        (
            "trips.force_n",
            |s| s.force.zero_code = 1400.0,
            |s| s.force.zero_code = 1100.0,
        ),
        (
            "trips.force_n",
            |s| s.limits.force_n = 18.0,
            |s| s.limits.force_n = 20.0,
        ),
        (
            "trips.force_n",
            |s| s.force.unit_per_code *= 0.75,
            |s| s.force.unit_per_code *= 0.85,
        ),
        (
            "force.n_per_code",
            |s| s.force.unit_per_code *= -1.0,
            |_| (),
        ),
        (
            "cart.m_per_code",
            |s| s.cart.unit_per_code = 6e-5,
            |s| s.cart.unit_per_code = -1.4e-6,
        ),
    ];
    for (key, beyond, below) in cases {
        let mut settings = Settings::for_rig(&PRESETS[0].1);
        settings.detection.on_n = 9.0;
        settings.detection.off_n = 6.0;
        let sound = settings;
        beyond(&mut settings);
        assert_eq!(settings.check().expect_err(key).key, key);
        let mut settings = sound;
        below(&mut settings);
        assert_eq!(settings.check(), Ok(()), "{key}");
    }
}

#[test]
fn calibrations_of_absurd_size_are_refused() {
    for unit in [1e-45, 1e38, -1.0, f32::MIN_POSITIVE] {
        let mut settings = Settings::for_rig(&PRESETS[0].1);
        settings.force.unit_per_code = unit;
        assert_eq!(settings.check().unwrap_err().key, "force.n_per_code");
        for (key, field) in [("hammer.m_per_code", true), ("cart.m_per_code", false)] {
            let mut settings = Settings::for_rig(&PRESETS[0].1);
            let channel = if field {
                &mut settings.hammer
            } else {
                &mut settings.cart
            };
            channel.unit_per_code = unit;
            assert_eq!(settings.check().unwrap_err().key, key, "{unit}");
        }
    }
}

#[test]
fn every_setting_has_a_range_and_is_named_outside_it() {
    type Field = fn(&mut Settings) -> &mut f32;
    // Just outside on either side; the ends that are other settings are those of the wires' defaults.
    let cases: [(&str, Field, f32, f32); 24] = [
        (
            "force.n_per_code",
            |s| &mut s.force.unit_per_code,
            0.0,
            f32::INFINITY,
        ),
        (
            "hammer.m_per_code",
            |s| &mut s.hammer.unit_per_code,
            0.0,
            f32::INFINITY,
        ),
        (
            "cart.m_per_code",
            |s| &mut s.cart.unit_per_code,
            0.0,
            f32::INFINITY,
        ),
        ("force.zero_code", |s| &mut s.force.zero_code, 123.0, 3972.0),
        (
            "hammer.zero_code",
            |s| &mut s.hammer.zero_code,
            123.0,
            3972.0,
        ),
        ("cart.zero_code", |s| &mut s.cart.zero_code, 123.0, 3972.0),
        ("drive.m_per_code", |s| &mut s.drive.m_per_code, 0.0, 1.1e-3),
        (
            "drive.frequency_slew_hz_per_s",
            |s| &mut s.drive.frequency_slew_hz_per_s,
            9e-4,
            1.1e3,
        ),
        (
            "drive.amplitude_slew_m_per_s",
            |s| &mut s.drive.amplitude_slew_m_per_s,
            9e-7,
            1.1,
        ),
        ("limits.force_n", |s| &mut s.limits.force_n, 0.0, 1.1e6),
        ("limits.travel_m", |s| &mut s.limits.travel_m, 0.0, 1.1),
        (
            "limits.min_frequency_hz",
            |s| &mut s.limits.min_frequency_hz,
            0.04,
            501.0,
        ),
        (
            "limits.max_frequency_hz",
            |s| &mut s.limits.max_frequency_hz,
            0.5,
            501.0,
        ),
        (
            "limits.amplitude_m",
            |s| &mut s.limits.amplitude_m,
            0.88e-3,
            2.51e-3,
        ),
        ("trips.force_n", |s| &mut s.trips.force_n, 200.0, 1.1e6),
        ("trips.travel_m", |s| &mut s.trips.travel_m, 7.9e-3, 1.1),
        ("trips.cart_m", |s| &mut s.trips.cart_m, 1.3e-3, 1.1),
        (
            "trips.no_contact_s",
            |s| &mut s.trips.no_contact_s,
            0.09,
            31.0,
        ),
        (
            "trips.regime_lost_s",
            |s| &mut s.trips.regime_lost_s,
            0.9,
            301.0,
        ),
        (
            "trips.link_timeout_s",
            |s| &mut s.trips.link_timeout_s,
            -0.1,
            3601.0,
        ),
        ("detection.on_n", |s| &mut s.detection.on_n, 0.0, 300.0),
        ("detection.off_n", |s| &mut s.detection.off_n, 0.0, 20.0),
        (
            "detection.refractory_s",
            |s| &mut s.detection.refractory_s,
            1.9e-4,
            2.1e-2,
        ),
        ("aim.force_n", |s| &mut s.aim.force_n, -1.0, 300.0),
    ];
    for (key, field, below, above) in cases {
        for value in [below, above, f32::NAN] {
            let mut settings = Settings::for_rig(&PRESETS[0].1);
            *field(&mut settings) = value;
            let error = settings.check().expect_err(key);
            assert_eq!(error.key, key, "{value}");
            assert!(error.value == f64::from(value) || value.is_nan());
        }
    }
}
