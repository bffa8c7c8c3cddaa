//! `host-sim orbits`.

use serde_json::Value;

use crate::support::{
    Folder, answer, assert_refused, assert_svg_shows, csv_rows, keys, number, png_size,
};

/// The 1/1 on wires at 0.0 mm about its period doubling, and the 2/2 it doubles into.
const SHORT: &str = "orbits --gap 0 --ratio 2.4:2.8 --starts 4 --cart prescribed";

#[test]
fn the_doubling_is_told_and_the_doubled_orbits_begin_there() {
    let answer = answer(SHORT);
    let branches = answer["branches"].as_array().unwrap();
    let names: Vec<_> = branches
        .iter()
        .map(|b| b["branch"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["1/1", "2/2"]);
    assert_eq!(branches[1]["doubled_from"], "1/1");
    let special = &answer["special_points"][0];
    assert_eq!(special["special"], "period_doubling");
    assert!(
        (number(special, "frequency_ratio") - 2.66068).abs() < 1e-4,
        "{special}"
    );
    assert!((number(special, "multiplier_modulus") - 1.0).abs() < 1e-6);
    // Stable below, unstable above; the doubled orbits stable, two strobes each.
    for orbit in answer["orbits"].as_array().unwrap() {
        let ratio = number(orbit, "frequency_ratio");
        let single = orbit["branch"] == "1/1";
        let stable = !single || ratio < number(special, "frequency_ratio");
        if orbit["special"].is_null() {
            assert_eq!(orbit["stable"], Value::Bool(stable), "{orbit}");
        }
        assert_eq!(orbit["periods"], if single { 1 } else { 2 });
    }
}

#[test]
fn csv_pictures_and_json_say_the_same() {
    let folder = Folder::new();
    let ran = folder
        .run(&format!(
            "{SHORT} --behind 5 --format csv --out out --quiet"
        ))
        .well();
    assert_eq!(folder.ends("out/orbits"), [".csv", ".json", ".png", ".svg"]);
    let rows = csv_rows(&ran.out);
    let json: Value = serde_json::from_str(&folder.read_made("out/orbits", ".json")).unwrap();
    let orbits = json["orbits"].as_array().unwrap();
    assert_eq!(rows.len(), orbits.len());
    for key in ["frequency_hz", "displacement_mm", "force_ratio", "stable"] {
        assert!(keys(&rows[0]).contains(&key), "{key}");
        assert_eq!(rows[3][key], orbits[3][key], "{key}");
    }
    assert_eq!(folder.read_made("out/orbits", ".csv"), ran.out);
    assert_svg_shows(
        &folder.read_made("out/orbits", ".svg"),
        &["1/1 stable", "period doubling", "Ω/ω"],
    );
    let (width, height) = png_size(&std::fs::read(folder.made("out/orbits", ".png")).unwrap());
    assert!(width > 1000 && height > 800);
}

#[test]
fn the_same_orbits_are_found_with_one_thread() {
    let folder = Folder::new();
    let run = |threads: &str| {
        let line = format!("{SHORT} --format csv --quiet");
        let words: Vec<_> = line.split_whitespace().collect();
        let mut command = folder.command(&words);
        command.env("RAYON_NUM_THREADS", threads);
        crate::support::finish(command).well().out
    };
    assert_eq!(run("1"), run("3"));
}

#[test]
fn along_the_gap_the_graze_is_where_the_frequency_s_is() {
    // At Ω/ω = 1.26058 the swing without contact reaches 2.4 mm (docs/orbits.md): there the unstable 1/1 ends that comes
    // back from the fold.
    let answer = answer(
        "orbits --along gap --ratio 1.26058 --gap 0.5:10 --starts 4 --periods 1 --impacts 1",
    );
    let specials = answer["special_points"].as_array().unwrap();
    let graze = specials.iter().find(|s| s["special"] == "grazing_lost");
    assert!(specials.iter().any(|s| s["special"] == "fold"));
    let graze = graze.unwrap_or_else(|| panic!("no graze in {specials:?}"));
    assert!((number(graze, "gap_mm") - 2.4).abs() < 1e-3, "{graze}");
}

#[test]
fn curves_give_a_row_per_gap_and_special_point() {
    let answer = answer("orbits --curves --gap 0:0.1:0.05 --ratio 2.4:2.8 --starts 3");
    let rows = answer.as_array().unwrap();
    let doubling = |r: &&Value| r["special"] == "period_doubling";
    let gaps: Vec<_> = rows
        .iter()
        .filter(doubling)
        .map(|r| number(r, "gap_mm"))
        .collect();
    assert_eq!(gaps, [0.0, 0.05, 0.1]);
    assert!(
        rows.iter().all(|r| r["branch"] == rows[0]["branch"]),
        "one line"
    );
}

/// The doubling of the 1/1 over gap and frequency, as one curve: the one-parameter run's at 0.0 mm is its end.
#[test]
fn a_curve_over_two_parameters_has_the_one_parameter_run_s_points() {
    let folder = Folder::new();
    let line = "orbits --curve gap_mm=0:0.5 --ratio 2.3:2.8 --periods 1 --impacts 1 --starts 3 --searches 2";
    let ran = folder
        .run(&format!("{line} --format csv --out out --quiet"))
        .well();
    assert_eq!(folder.ends("out/orbits"), [".csv", ".json", ".png", ".svg"]);
    let json: Value = serde_json::from_str(&folder.read_made("out/orbits", ".json")).unwrap();
    let curves = json["curves"].as_array().unwrap();
    assert_eq!(curves.len(), 1, "{curves:?}");
    assert_eq!(curves[0]["condition"], "period_doubling");
    assert_eq!(curves[0]["ends"], serde_json::json!(["limit", "limit"]));
    let rows = csv_rows(&ran.out);
    assert_eq!(rows.len(), json["points"].as_array().unwrap().len());
    for row in &rows {
        assert_eq!(row["parameter_2"], "gap_mm");
        let multiplier = |k: &str| number(row, k);
        let nearest = (multiplier("multiplier_1_re") + 1.0).abs();
        let nearest = nearest.min((multiplier("multiplier_2_re") + 1.0).abs());
        assert!(nearest < 1e-9, "{row:?}");
    }
    let end = rows.iter().find(|r| number(r, "value_2") == 0.0).unwrap();
    let alone =
        answer("orbits --gap 0 --ratio 2.3:2.8 --periods 1 --impacts 1 --starts 3 --checks 0");
    let alone = number(&alone["special_points"][0], "frequency_ratio");
    assert!((number(end, "value_1") - alone).abs() < 1e-8);
    assert_svg_shows(
        &folder.read_made("out/orbits", ".svg"),
        &["1/1 period doubling", "gap_mm", "frequency_ratio"],
    );
}

#[test]
fn the_text_has_the_branches_the_special_points_and_a_chart() {
    let text = Folder::new().run(&format!("{SHORT} --quiet")).well().out;
    for part in [
        "branch",
        "period doubling",
        "2.66068",
        "1/1",
        "2/2",
        "frequency ratio",
    ] {
        assert!(text.contains(part), "{part} in {text}");
    }
}

#[test]
fn what_cannot_be_used_is_refused_in_one_line() {
    let lines = [
        ("orbits --ratio 3:1", "swap them"),
        ("orbits --ratio 1:2:0.1", "write FROM:TO"),
        ("orbits --ratio nan:2", "write FROM:TO"),
        ("orbits --ratio -1:2", "not a positive value"),
        ("orbits --along gap", "needs the drive frequency"),
        (
            "orbits --along gap --ratio 1:2",
            "write one positive number",
        ),
        (
            "orbits --along gap --ratio 1.5 --gap 1",
            "--gap 1: write FROM:TO",
        ),
        ("orbits --along gap --ratio 1.5 --gap 0:200", "--gap"),
        ("orbits --gap 0:1", "FROM:TO goes with --along gap"),
        ("orbits --curves --gap 1", "--gap 1: write FROM:TO:STEP"),
        ("orbits --curves --gap 0:1", "FROM:TO:STEP"),
        ("orbits --curve gap_mm", "write KEY=FROM:TO"),
        ("orbits --curve gap=0:3", "did you mean 'gap_mm'?"),
        ("orbits --curve gap_mm=3:0", "swap them"),
        ("orbits --curve gap_mm=0:3:log", "must be positive with log"),
        (
            "orbits --curve damping_ratio=0:0.1",
            "has no frequency_ratio and damping_ratio",
        ),
        ("orbits --curve gap_mm=0:300", "gap_mm"),
        (
            "orbits --curve gap_mm=0:3 --gap 1",
            "--gap does not go with",
        ),
        (
            "orbits --along gap --ratio 2 --curve gap_mm=0:3",
            "must differ",
        ),
        (
            "orbits --curve gap_mm=0:3 --curve mass_kg=0.2:0.4",
            "needs the drive frequency",
        ),
        ("orbits --engine switch", "unexpected argument '--engine'"),
        ("orbits --periods 0", "--periods"),
        ("orbits --starts 0", "--starts"),
    ];
    let folder = Folder::new();
    assert_refused(&folder, lines);
    assert!(folder.names().is_empty());
}
