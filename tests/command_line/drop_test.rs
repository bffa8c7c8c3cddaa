//! `host-sim drop` and `host-sim identify`.

use serde_json::Value;

use crate::support::{
    Folder, answer, assert_refused, assert_svg_shows, csv_rows, number, png_size,
};

/// A folder with a drop test made by `drop` with these options.
fn dropped(options: &str) -> Folder {
    let folder = Folder::new();
    let ran = folder
        .run(&format!("drop {options} --format csv --quiet"))
        .well();
    folder.with("drop.csv", ran.out)
}

fn parameter(fit: &Value, i: usize) -> f64 {
    number(&fit["parameters"][i], "value")
}

#[test]
fn what_drop_makes_identify_gives_back() {
    let folder = dropped("--noise-n 0.1");
    let line = "identify drop.csv --out o --format json --quiet";
    let ran = folder.run(line).well();
    let json = ran.json();
    assert_eq!(json["impacts"], 4);
    for fit in json["fits"].as_array().expect("fits") {
        // 41 N of peak and 0.1 N of noise: ki and ci to about a percent.
        assert!((parameter(fit, 0) / 5.5e6 - 1.0).abs() < 0.03, "{fit}");
        assert!((parameter(fit, 1) / 1.2e3 - 1.0).abs() < 0.03, "{fit}");
        for p in fit["parameters"].as_array().expect("parameters") {
            let (low, high) = (number(p, "low"), number(p, "high"));
            assert!(low < number(p, "value") && number(p, "value") < high, "{p}");
        }
    }
    // ki with ci and ci with ki are one pair.
    for fit in json["fits"].as_array().expect("fits") {
        let warnings = fit["warnings"].as_array().expect("warnings").iter();
        let pairs = warnings.filter(|w| w.to_string().contains("stand in for each other"));
        assert!(pairs.count() <= 1, "{fit}");
    }
    assert_eq!(json["ring"], Value::Null);
    assert_svg_shows(
        &folder.read_made("o/identify", ".svg"),
        &[
            "Impact 1",
            "force peak, N",
            "Profile likelihood: ki",
            "Profile likelihood: ci",
            "\nki, 10⁶ N/m\n",
            "measured",
        ],
    );
    png_size(&std::fs::read(folder.made("o/identify", ".png")).expect("a picture"));
    assert_eq!(csv_rows(&folder.read_made("o/identify", ".csv")).len(), 4);
    assert_eq!(folder.read_made("o/identify", ".json"), ran.out);
    // The same record, the same answer, whatever the threads.
    let mut alone = folder.command(&line.split_whitespace().collect::<Vec<_>>());
    alone.env("RAYON_NUM_THREADS", "1");
    assert_eq!(crate::support::finish(alone).well().out, ran.out);
}

/// Of a clean record the ends of the interval were printed alike.
#[test]
fn the_ends_of_an_interval_are_told_apart() {
    let folder = dropped("");
    let line = "identify drop.csv --misfit force --gain-percent 0 --release-height-percent 0 --clock-percent 0 --quiet";
    let ran = folder.run(line).well();
    let ends = ran.out.lines().filter_map(|l| l.split_once("95 %: "));
    let ends: Vec<_> = ends.filter_map(|(_, e)| e.split_once(" to ")).collect();
    assert_eq!(ends.len(), 2, "{}", ran.out);
    assert!(ends.iter().all(|(low, high)| low != high), "{}", ran.out);
}

/// The record of which stiffness −43 % was said, from −53 to −33 %.
#[test]
fn two_percent_of_noise_leave_the_truth_in_the_interval() {
    let folder = dropped("--noise-n 1 --seed 1008");
    let ran = folder.run("identify drop.csv --misfit force --format json --quiet");
    let json = ran.well().json();
    let stiffness = &json["fits"][0]["parameters"][0];
    let (low, high) = (number(stiffness, "low"), number(stiffness, "high"));
    assert!(low < 5.5e6 && high > 5.5e6, "{stiffness}");
    assert!((json["noise_n"].as_f64().expect("noise") - 1.0).abs() < 0.02);
}

#[test]
fn a_law_that_does_not_fit_is_refused_in_one_line() {
    let folder = dropped("--noise-n 0.1 --impacts 2 --sampling-hz 20000");
    let line = "identify drop.csv --law hertz --misfit force --out o --quiet";
    assert_refused(&folder, [(line, "hertz does not fit: at least")]);
    let both = "identify drop.csv --law hertz --law spring-dashpot --misfit force";
    let json = folder
        .run(&format!("{both} --format json --quiet"))
        .well()
        .json();
    assert_eq!(json["fits"][0]["refused"], true);
    assert_eq!(json["fits"][0]["parameters"][0]["low"], Value::Null);
    assert_eq!(json["fits"][1]["refused"], false);
}

#[test]
fn sensor_faults_are_in_the_record() {
    let rows = |options: &str| {
        let rows = answer(&format!("drop --impacts 1 --sampling-hz 20000 {options}"));
        rows.as_array().expect("rows").clone()
    };
    let force = |rows: &[Value], i: usize| number(&rows[i], "force_n");
    let plain = rows("");
    let hardest = (0..plain.len())
        .max_by(|a, b| force(&plain, *a).total_cmp(&force(&plain, *b)))
        .expect("rows");
    let peak = force(&plain, hardest);
    let louder = rows("--force-gain-percent 2");
    assert!((force(&louder, hardest) / peak - 1.02).abs() < 1e-9);
    let drifting = rows("--offset-n 1 --drift-n-per-s 0.5");
    let time = number(&plain[hardest], "time_s");
    assert!((force(&drifting, hardest) - peak - 1.0 - 0.5 * time).abs() < 1e-9);
    // A second-order filter of 3 kHz lets nothing of a jump through at once.
    let filtered = rows("--filter-hz 3000");
    let onset = (0..plain.len())
        .find(|i| force(&plain, *i) > 0.0)
        .expect("an onset");
    assert!(force(&filtered, onset) < 0.2 * force(&plain, onset));
    let meant = rows("--converter mean");
    let three = (0..3).map(|i| force(&plain, hardest - i)).sum::<f64>() / 3.0;
    assert!((force(&meant, hardest) - three).abs() < 1e-9);
    let wrong = rows("--displacement-gain-percent 1");
    assert!((number(&wrong[0], "displacement_mm") + 3.03).abs() < 1e-9);
}

#[test]
fn coverage_is_one_command_and_the_same_on_any_number_of_threads() {
    let folder = Folder::new();
    let line =
        "identify --coverage --tests 2 --case filter-6-khz --misfit force --format csv --quiet";
    let ran = folder.run(line).well();
    let rows = csv_rows(&ran.out);
    assert_eq!(rows.len(), 2, "{}", ran.out);
    assert_eq!(rows[0]["case"], "filter-6-khz");
    let mut alone = folder.command(&line.split_whitespace().collect::<Vec<_>>());
    alone.env("RAYON_NUM_THREADS", "1");
    assert_eq!(crate::support::finish(alone).well().out, ran.out);
    assert_refused(
        &folder,
        [
            (
                "identify --coverage --case nonsense",
                "--case nonsense is none of noise-0.1-percent",
            ),
            ("identify --coverage --tests 0", "--tests is 0"),
            ("identify --coverage drop.csv", "cannot be used with"),
        ],
    );
}

#[test]
fn the_same_seed_makes_the_same_record_and_another_does_not() {
    let of = |seed: u32| {
        answer(&format!(
            "drop --impacts 1 --sampling-hz 5000 --noise-n 1 --bits 12 --seed {seed}"
        ))
    };
    assert_eq!(of(3), of(3));
    assert_ne!(of(3), of(4));
    let folder = Folder::new();
    folder
        .run("drop --impacts 2 --sampling-hz 5000 --out o --quiet")
        .well();
    assert_eq!(folder.ends("o/drop"), [".csv", ".json", ".png", ".svg"]);
}

#[test]
fn a_bad_record_is_told_by_file_and_line() {
    let rows = |n: usize| -> String { (0..n).map(|i| format!("0.{i:04},0.0\n")).collect() };
    for (text, says) in [
        (
            "time_s,force_n\n0.1,x\n".to_owned(),
            "bad.csv, line 2: force_n is 'x'",
        ),
        (
            format!("time_s,force_n\n{}0.5\n", rows(30)),
            "bad.csv, line 32: 1 fields",
        ),
        (
            format!("time_s,force_n\n{}0.0001,1\n", rows(30)),
            "line 32: time_s is 0.0001 after 0.0029",
        ),
        (
            format!("time_s,displacement_mm\n{}", rows(30)),
            "there is no column force_n",
        ),
        (
            format!("t,force_n\n{}", rows(30)),
            "line 1: the column 't' has no unit; call it time_s",
        ),
        (
            format!("time_s,force_n\n{}", rows(30)),
            "the force is the same in every sample",
        ),
        ("time_s,force_n\n".to_owned(), "first line: 0"),
        (String::new(), "line 1"),
    ] {
        let folder = Folder::new().with("bad.csv", &text);
        assert_refused(&folder, [("identify bad.csv --out o", says)]);
    }
    assert_refused(
        &Folder::new(),
        [
            ("identify nowhere.csv", "cannot read nowhere.csv"),
            ("drop --release-mm 1", "not clear of the surface"),
            ("drop --release-mm -80", "out of the rig's reach"),
            ("drop --gap 3.5", "never strikes"),
            ("drop --noise-n -1", "--noise-n is -1"),
            ("drop --sampling-hz nan", "--sampling-hz is NaN"),
            ("drop --impacts 0", "--impacts is 0"),
        ],
    );
}
