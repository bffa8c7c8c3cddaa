use super::*;
use shared::model::cart::{ASSUMED_SHAKER, CartDrive, LoopParams, UNLIMITED_N};
use shared::model::params::{BEAM_150, PRESETS, RigParams, WIRES};
use shared::settings::{Calibration, DriveSettings, Interlock};

#[test]
fn what_is_written_reads_back_the_same_onto_any_base() {
    let base = Settings::for_rig(&BEAM_150);
    let held = CartDrive::Loop(ASSUMED_SHAKER);
    for (name, rig) in PRESETS {
        for (cart, other) in [(CartDrive::Prescribed, held), (held, CartDrive::Prescribed)] {
            let mut settings = Settings::for_rig(&RigParams { cart, ..rig });
            settings.operator.acknowledge = true;
            settings.interlock.relay = true;
            settings.calibration.hammer = Calibration {
                day: 20_260_229,
                uncertainty_percent: 0.5,
            };
            let text = to_toml(&settings);
            // The support of the file replaces the support of the base, and its shaker the base's.
            let rig = RigParams { cart: other, ..rig };
            let onto_its_kind = Settings { rig, ..base };
            assert_eq!(overlay(&onto_its_kind, &text).unwrap(), settings, "{name}");
        }
    }
}

/// The settings of `shared/src/link/store/layout-1.bin` as version 0.2.0 wrote them into a file.
#[test]
fn a_file_of_version_0_2_gives_the_settings_that_version_had() {
    let told = Settings {
        drive: DriveSettings {
            kind: DriveKind::Motor,
            frequency_slew_hz_per_s: 0.125,
            ..Settings::for_rig(&WIRES).drive
        },
        ..Settings::for_rig(&WIRES)
    };
    let text = include_str!("version-0.2.toml");
    let read = overlay(&Settings::for_rig(&WIRES), text).unwrap();
    assert_eq!(read.rig.gap_m, 1.25e-3);
    assert_eq!(read.force.zero_code, 611.5);
    assert_eq!(read.hammer.unit_per_code, -told.hammer.unit_per_code);
    assert_eq!(read.drive, told.drive);
    assert_eq!(read.limits.min_frequency_hz, 1.365);
    assert_eq!(read.trips.link_timeout_s, 1.5);
    assert_eq!(read.detection.refractory_s, 1.75e-3);
    // What version 0.2.0 did not have stays as it is on the board.
    let base = Settings {
        interlock: Interlock {
            relay: true,
            ready: false,
        },
        ..Settings::for_rig(&WIRES)
    };
    assert!(overlay(&base, text).unwrap().interlock.relay);
}

#[test]
fn a_shaker_is_given_changed_and_taken_away_and_an_absurd_one_refused() {
    let base = Settings::for_rig(&WIRES);
    let with = |base: &Settings, lines: &str| overlay(base, &format!("[rig]\n{lines}\n"));
    let held = with(&base, "shaker_loop_hz = 35").unwrap();
    let wanted = LoopParams {
        frequency_hz: 35.0,
        max_force_n: UNLIMITED_N,
        ..ASSUMED_SHAKER
    };
    assert_eq!(held.rig.cart, CartDrive::Loop(wanted));
    let damped = with(&held, "shaker_damping_ratio = 0.5\ncart_mass_kg = 7").unwrap();
    let wanted = LoopParams {
        damping_ratio: 0.5,
        ..wanted
    };
    assert_eq!(damped.rig.cart, CartDrive::Loop(wanted));
    let without = with(
        &damped,
        "shaker_loop_hz = \"prescribed\"\ncart_mass_kg = 5.38",
    )
    .unwrap();
    assert_eq!(without, base);
    let complaint = |lines: &str| with(&held, lines).unwrap_err().to_string();
    for (lines, line) in [
        (
            "shaker_loop_hz = 0.1",
            "shaker_loop_hz is 0.1, must be 1 to 500 for the controller",
        ),
        (
            "shaker_loop_hz = 1000",
            "shaker_loop_hz is 1000, must be 1 to 500",
        ),
        (
            "shaker_loop_hz = nan",
            "shaker_loop_hz is NaN, must be a number from",
        ),
        ("shaker_loop_hz = \"stiff\"", "must be a number"),
        (
            "shaker_damping_ratio = 0",
            "shaker_damping_ratio is 0, must be 0.05 to 5",
        ),
        (
            "shaker_damping_ratio = 10",
            "shaker_damping_ratio is 10, must be 0.05 to 5",
        ),
        (
            "cart_mass_kg = 0.001",
            "cart_mass_kg is 0.001, must be at least a fifth of mass_kg",
        ),
    ] {
        let found = complaint(lines);
        assert!(found.contains(line), "{found}");
    }
    let orphan = with(&base, "shaker_damping_ratio = 0.5").unwrap_err();
    assert!(
        orphan.to_string().contains("needs shaker_loop_hz"),
        "{orphan}"
    );
}

/// No two keys write into one place.
#[test]
fn every_number_has_a_place_and_a_place_of_its_own() {
    let mut settings = Settings::for_rig(&WIRES);
    for (i, key) in NUMBERS.iter().enumerate() {
        *(key.place)(&mut settings) = i as f32;
    }
    for (i, key) in NUMBERS.iter().enumerate() {
        assert_eq!(
            *(key.place)(&mut settings),
            i as f32,
            "{}.{}",
            key.section,
            key.name
        );
    }
}

#[test]
fn a_force_that_is_too_low_is_refused_with_the_lowest_that_is_not() {
    let base = Settings::for_rig(&PRESETS[0].1);
    let least = base.least_force_n();
    let text = |n: f32| format!("[aim]\nforce_n = {n:?}\n");
    let complaint = overlay(&base, &text(0.9 * least)).unwrap_err().to_string();
    assert!(
        complaint.contains(&format!("(here {least} N)")),
        "{complaint}"
    );
    assert!(overlay(&base, &text(least)).is_ok());
}

/// A value that no key takes is refused by the key that the file has, whoever checks it.
#[test]
fn a_value_out_of_range_is_refused_by_its_key_in_the_file() {
    let base = Settings::for_rig(&WIRES);
    for key in &NUMBERS {
        let (section, name) = (key.section, key.name);
        let complaint = overlay(&base, &format!("[{section}]\n{name} = -1e30\n")).unwrap_err();
        let complaint = complaint.to_string();
        assert!(
            complaint.contains(&format!("{section}.{name} is ")),
            "{section}.{name}: {complaint}"
        );
    }
}

#[test]
fn a_file_names_only_what_differs_and_mistakes_are_told() {
    let base = Settings::for_rig(&WIRES);
    let new = overlay(&base, "[trips]\nforce_n = 450\n[rig]\ngap_mm = 1.0\n").unwrap();
    assert_eq!((new.trips.force_n, new.rig.gap_m), (450.0, 1e-3));
    assert_eq!(new.limits, base.limits);
    let complaint = |text: &str| overlay(&base, text).unwrap_err().to_string();
    assert!(complaint("[trips]\nforce = 1\n").contains("trips.force (did you mean 'force_n'?)"));
    assert!(complaint("[trip]\n").contains("did you mean 'trips'"));
    assert!(complaint("trips = 1\n").contains("must be a section"));
    assert!(complaint("[rig]\nmas_kg = 1\n").contains("[rig]: there is no parameter"));
    assert!(complaint("[trips]\nforce_n = 1.0\n").contains("trips.force_n is 1, must be at least"));
    assert!(complaint("[trips]\nforce_n = \"x\"\n").contains("must be a number"));
    assert!(complaint("[drive]\nkind = \"hand\"\n").contains("must be \"shaker\""));
    assert!(complaint("[trips\n").contains("line 1"));
    let new = overlay(&base, "[operator]\nheartbeat = true\n").unwrap();
    assert!(new.operator.heartbeat && !new.operator.acknowledge);
    let dated = overlay(&base, "[force]\ncalibrated = \"2026-11-23\"\n").unwrap();
    assert_eq!(dated.calibration.force.day, 20_261_123);
    assert!(complaint("[force]\ncalibrated = 2026\n").contains("must be a day"));
    assert!(complaint("[force]\ncalibrated = \"2026-13-01\"\n").contains("must be a day"));
    assert!(complaint("[cart]\ncalibratd = 1\n").contains("did you mean 'calibrated'"));
    assert!(complaint("[operator]\nheartbeat = 1\n").contains("must be true or false"));
    assert!(complaint("[operator]\nheart = true\n").contains("did you mean 'heartbeat'"));
}

#[test]
fn the_force_wanted_is_in_newtons_or_in_units_of_the_weight() {
    let base = Settings::for_rig(&WIRES);
    let wanted = |text: &str| overlay(&base, text).unwrap().aim.force_n;
    assert_eq!(wanted("[aim]\nforce_n = 80\n"), 80.0);
    let twenty = wanted("[aim]\nforce_ratio = 20\n");
    assert_eq!(twenty, (20.0 * WIRES.weight_n()) as f32);
    // The weight of the rig of the same file, which stands after it or before.
    let text = "[aim]\nforce_ratio = 20\n[rig]\nmass_kg = 0.2\n";
    let heavier = wanted(text);
    let ratio = f64::from(heavier / twenty) * WIRES.mass_kg / 0.2;
    assert!((ratio - 1.0).abs() < 1e-6, "{heavier}");
    // What is not named stays.
    let asked = overlay(&base, "[aim]\nforce_n = 80\n").unwrap();
    let power = overlay(&asked, "[aim]\npower = true\n").unwrap();
    assert_eq!((power.aim.force_n, power.aim.power), (80.0, true));
    let complaint = |text: &str| overlay(&base, text).unwrap_err().to_string();
    assert_eq!(
        complaint("[aim]\nforce_n = 80\nforce_ratio = 20\n"),
        "[aim] has force_n and force_ratio; give one of them"
    );
    assert!(complaint("[aim]\nforce_ratio = 2000\n").contains("at most limits.force_n"));
    assert!(complaint("[aim]\nforce_ratio = true\n").contains("must be a number"));
    assert!(complaint("[aim]\nforce_rato = 2\n").contains("did you mean 'force_ratio'"));
}
