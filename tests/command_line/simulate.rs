//! `host-sim simulate`.

use serde_json::Value;

use crate::support::{Folder, answer, assert_svg_shows, csv_rows, keys, number, png_size};

fn regime(line: &str) -> String {
    let row = answer(&format!("simulate {line}"));
    row["regime"].as_str().expect("a regime").to_owned()
}

/// What the chapter reports of the hammer on wires: gap in mm, Ω/ω, regime.
const CHAPTER: [(f64, f64, &str); 9] = [
    (0.0, 1.1, "2/1"),
    (0.0, 1.5, "1/1"),
    (0.0, 2.7, "2/2"),
    (0.0, 3.8, "1/2"),
    (1.0, 1.5, "1/1"),
    (1.0, 3.3, "1/2"),
    (2.4, 1.2, "1/1"),
    (2.4, 1.4, "1/1"),
    (2.4, 2.7, "1/2"),
];

#[test]
fn the_chapter_s_regimes() {
    for (gap, ratio, expected) in CHAPTER {
        let seen = regime(&format!("--gap {gap} --ratio {ratio} --cart prescribed"));
        assert_eq!(seen, expected, "gap {gap} mm, ratio {ratio}");
    }
}

#[test]
fn hops_that_die_out_are_chatter_and_no_contact_is_none() {
    assert_eq!(regime("--gap 0 --ratio 0.8"), "chatter");
    let silent = answer("simulate --gap 2.4 --ratio 0.8");
    assert_eq!(silent["regime"], "none");
    assert_eq!(number(&silent, "force_n"), 0.0);
    for key in [
        "periods",
        "approach_speed_m_per_s",
        "contact_time_ms",
        "energy_per_blow_j",
    ] {
        assert_eq!(silent[key], Value::Null, "{key}");
    }
}

#[test]
fn where_it_starts_decides_where_two_regimes_share_a_frequency() {
    let at = |start: &str| regime(&format!("--gap 2.4 --ratio 2.7 --initial {start}"));
    assert_eq!(at("rest"), "1/2");
    assert_eq!(at("0,0"), "1/2");
    assert_eq!(at("-2.5,0.1"), "1/2");
    assert_eq!(at("fixed"), "none");
}

/// In single precision at the microcontroller's tick and at a fifth of it. Forces within 0.02 %, the
/// corrected stepper's known error; each side's frequency differs by the switch model's phase grain.
#[test]
fn the_switch_model_agrees_with_the_reference() {
    for (gap, ratio, expected) in [CHAPTER[0], CHAPTER[1], CHAPTER[2], CHAPTER[3], CHAPTER[7]] {
        let line = format!("simulate --gap {gap} --ratio {ratio} --cart prescribed");
        let reference = number(&answer(&line), "force_n");
        // The finer takes long: once is enough.
        let ticks: &[u32] = if expected == "2/2" { &[50, 10] } else { &[50] };
        for &tick_us in ticks {
            let seen = answer(&format!("{line} --engine switch --tick-us {tick_us}"));
            assert_eq!(seen["regime"], expected, "{line}, {tick_us} us");
            let error = number(&seen, "force_n") / reference - 1.0;
            assert!(error.abs() < 2e-4, "{line}, {tick_us} us: {error:e}");
            assert_eq!(
                (
                    &seen["engine"],
                    &seen["precision"],
                    number(&seen, "tick_us")
                ),
                (&"switch".into(), &"f32".into(), f64::from(tick_us))
            );
        }
    }
}

#[test]
fn ratio_and_frequency_say_the_same() {
    let cycles = "--cycles 40 --transient 20";
    assert_eq!(
        answer(&format!("simulate --ratio 1.5 {cycles}")),
        answer(&format!("simulate --frequency 2.73 {cycles}"))
    );
}

/// Half m (approach² − rebound²) is what a blow takes, but for what gravity and drive do meanwhile.
#[test]
fn the_answer_s_blow_adds_up() {
    let row = answer("simulate --gap 0 --ratio 2 --cart prescribed");
    let square = |key| number(&row, key).powi(2);
    let lost = 0.5 * 0.298 * (square("approach_speed_m_per_s") - square("rebound_speed_m_per_s"));
    let said = number(&row, "energy_per_blow_j");
    assert!((lost / said - 1.0).abs() < 0.01, "{lost} {said}");
    let weight = number(&row, "force_n") / number(&row, "force_ratio");
    assert!((weight - 0.298 * 9.81).abs() < 1e-9, "{weight}");
}

#[test]
fn csv_says_what_json_says_with_units_in_its_header() {
    let line = "simulate --ratio 1.5 --cycles 60 --transient 40";
    let json = answer(line);
    let folder = Folder::new();
    let csv = folder.run(&format!("{line} --format csv --quiet")).well();
    assert_eq!(
        csv.out.lines().next().unwrap_or_default(),
        "rig,gap_mm,cart,frequency_hz,frequency_ratio,impacts,periods,regime,force_ratio,force_n,\
         approach_speed_m_per_s,contact_time_ms"
    );
    let rows = csv_rows(&csv.out);
    assert_eq!(rows.len(), 1);
    for key in keys(&rows[0]) {
        assert_eq!(rows[0][key], json[key], "{key}");
    }
    let more = [
        "contacts_recorded",
        "settling_cycles",
        "settling_s",
        "rebound_speed_m_per_s",
        "energy_per_blow_j",
        "impulse_n_s",
        "cycles",
        "transient",
        "engine",
        "stepper",
        "precision",
        "tick_us",
    ];
    assert_eq!(keys(&json)[keys(&rows[0]).len()..], more);
    assert!(folder.names().is_empty());
}

#[test]
fn text_says_the_regime_and_pictures_go_into_the_usual_folder() {
    let folder = Folder::new();
    let ran = folder
        .run("simulate --ratio 1.5 --cycles 60 --transient 40")
        .well();
    assert!(
        ran.out
            .contains("regime         1/1: 1 contact in 1 drive period")
    );
    assert_eq!(folder.ends("out/simulate").len(), 6);
    assert!(ran.err.starts_with("wrote out/simulate-wires-"), "{ran:?}");
}

#[test]
fn out_holds_pictures_and_tables_that_agree_with_the_answer() {
    let folder = Folder::new();
    let ran = folder
        .run("simulate --ratio 1.5 --cycles 60 --transient 40 --format json --out a/b")
        .well();
    let names = [
        "-contacts.csv",
        "-history.csv",
        "-section.csv",
        ".json",
        ".png",
        ".svg",
    ];
    assert_eq!(folder.ends("a/b/simulate"), names);
    assert!(names.iter().all(|name| ran.err.contains(name)), "{ran:?}");

    let row = ran.json();
    assert_eq!(folder.read_made("a/b/simulate", ".json"), ran.out);
    let contacts = csv_rows(&folder.read_made("a/b/simulate", "-contacts.csv"));
    assert_eq!(contacts.len() as f64, number(&row, "contacts_recorded"));
    let peaks = contacts.iter().map(|c| number(c, "peak_force_n"));
    assert_eq!(peaks.fold(0.0, f64::max), number(&row, "force_n"));
    assert_eq!(
        csv_rows(&folder.read_made("a/b/simulate", "-section.csv")).len(),
        20
    );

    let history = csv_rows(&folder.read_made("a/b/simulate", "-history.csv"));
    let times: Vec<_> = history.iter().map(|s| number(s, "time_s")).collect();
    assert!(times.is_sorted());
    let span = (times[times.len() - 1] - times[0]) * 2.73;
    assert!((span - 20.0).abs() < 0.01, "{span} periods");
    let highest = history
        .iter()
        .map(|s| number(s, "force_n"))
        .fold(0.0, f64::max);
    let force = number(&row, "force_n");
    assert!(
        (0.9 * force..=force * (1.0 + 1e-9)).contains(&highest),
        "{highest}"
    );

    let svg = folder.read_made("a/b/simulate", ".svg");
    assert_svg_shows(&svg, &["regime 1/1", "Phase plane", "contact force, N"]);
    let png = std::fs::read(folder.made("a/b/simulate", ".png")).expect("a picture");
    assert!(png_size(&png).0 >= 1200);
}

/// A 1/1 that settles after a few periods, recorded from the first: it is not called aperiodic.
#[test]
fn a_transient_is_not_called_aperiodic_and_a_run_says_when_it_repeats() {
    let folder = Folder::new();
    let from_the_start = "simulate --cart prescribed --ratio 2.02 --transient 0 --cycles 30";
    let ran = folder.run(&format!("{from_the_start} --out out")).well();
    assert!(!ran.out.contains("aperiodic"), "{ran:?}");
    let early = answer(from_the_start);
    assert_eq!(early["regime"], "unsettled");
    let after = number(&early, "settling_cycles");
    let says = format!("repeats only from drive period {after} on");
    assert!(ran.out.contains(&says), "{ran:?}");
    // The map says the same of its cell, and so does a run that is recorded late.
    let cells = folder
        .run("map --cart prescribed --gap 0 --ratio 2.02 --format csv --quiet")
        .well();
    assert_eq!(number(&csv_rows(&cells.out)[0], "settling_cycles"), after);
    let late = answer(&format!(
        "simulate --cart prescribed --ratio 2.02 --cycles 30 --transient {after}"
    ));
    assert_eq!(
        (&late["regime"], number(&late, "settling_cycles")),
        (&"1/1".into(), after)
    );
    let seconds = number(&late, "settling_s") * number(&late, "frequency_hz");
    assert!((seconds - after).abs() < 1e-9, "{seconds}");
    // The hammer is pressed on from the start: its first contact begins at 0.
    let contacts = folder.read_made("out/simulate", "-contacts.csv");
    let onset = number(&csv_rows(&contacts)[0], "onset_s");
    assert!(onset == 0.0 || onset > 1e-6, "{onset:e}");
    // What never repeats is still aperiodic.
    assert_eq!(
        answer("simulate --cart prescribed --gap 2.4 --ratio 2.3")["regime"],
        "aperiodic"
    );
}

/// A table without rows says what would be in them.
#[test]
fn without_a_contact_the_table_of_contacts_has_its_header() {
    let folder = Folder::new();
    folder
        .run("simulate --gap 3 --frequency 1 --cycles 40")
        .well();
    let contacts = folder.read_made("out/simulate", "-contacts.csv");
    assert!(contacts.starts_with("onset_s,duration_ms,"), "{contacts}");
    assert_eq!(contacts.lines().count(), 1, "{contacts}");
}

#[test]
fn a_few_cycles_need_no_other_option() {
    let few = answer("simulate --ratio 2.02 --cycles 10");
    assert_eq!((&few["cycles"], &few["transient"]), (&10.into(), &8.into()));
    let usual = answer("simulate --ratio 2.02");
    assert_eq!(
        (&usual["cycles"], &usual["transient"]),
        (&600.into(), &480.into())
    );
    for (command, cycles) in [
        ("bifurcation --gap 0 --ratio 2", 40),
        ("basins --ratio 2 --grid 2 --samples 0", 40),
    ] {
        answer(&format!("{command} --cycles {cycles}"));
    }
}
