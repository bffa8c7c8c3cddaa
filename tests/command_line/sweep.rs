//! `host-sim sweep`.

use serde_json::Value;

use crate::support::{
    Folder, answer, assert_svg_shows, csv_rows, finish, keys, number, png_size, without_origin,
};

const SHORT: &str = "--cycles 160 --transient 140";

fn sweep(line: &str) -> Vec<Value> {
    let rows = answer(&format!("sweep {line} {SHORT}"));
    rows.as_array().expect("rows").clone()
}

/// Forces of the sweep up and the sweep down, by rising frequency.
fn up_and_down(line: &str) -> Vec<(f64, f64)> {
    let [up, down] = ["up", "down"].map(|way| sweep(&format!("{line} --direction {way}")));
    let hz = |rows: &[Value]| {
        rows.iter()
            .map(|r| number(r, "frequency_hz"))
            .collect::<Vec<_>>()
    };
    assert_eq!(hz(&up), hz(&down));
    let force = |row| number(row, "force_n");
    up.iter().map(force).zip(down.iter().map(force)).collect()
}

/// The picture names what the table names.
#[test]
fn the_legend_has_what_has_not_settled() {
    let folder = Folder::new();
    folder
        .run("sweep --ratio 2:2.2:0.1 --cycles 20 --transient 4 --out a --quiet")
        .well();
    let picture = folder.read_made("a/sweep", ".svg");
    assert!(picture.contains("unsettled") && !picture.contains("aperiodic"));
}

#[test]
fn a_large_gap_jumps_between_up_and_down_and_no_gap_does_not() {
    let worst = |line: &str| {
        let differences = up_and_down(line).into_iter();
        let relative = differences.map(|(up, down)| (up - down).abs() / up.max(down).max(1.0));
        relative.fold(0.0, f64::max)
    };
    let jump = worst("--gap 2.4 --ratio 1.0:1.8:0.1");
    assert!(
        jump > 0.9,
        "one of the two must be silent somewhere: {jump}"
    );
    let none = worst("--gap 0.0 --ratio 1.2:2.6:0.1");
    assert!(none < 1e-6, "{none}");
}

#[test]
fn rows_are_what_simulate_says_of_each_frequency() {
    let rows = sweep("--gap 1 --ratio 1.4:1.6:0.1");
    assert_eq!(rows.len(), 3);
    for (row, ratio) in rows.iter().zip([1.4, 1.5, 1.6]) {
        let alone = answer(&format!("simulate --gap 1 --ratio {ratio} {SHORT}"));
        for key in keys(row) {
            match (row[key].as_f64(), alone[key].as_f64()) {
                // 1.4 + 2 × 0.1 is not 1.6 to the last digit.
                (Some(a), Some(b)) => assert!((a - b).abs() <= 1e-9 * b.abs(), "{key}: {a} {b}"),
                _ => assert_eq!(row[key], alone[key], "{key}"),
            }
        }
    }
}

#[test]
fn csv_says_what_json_says() {
    let line = "--gap 2.4 --ratio 1.2:1.8:0.2";
    let csv = Folder::new()
        .run(&format!("sweep {line} {SHORT} --format csv --quiet"))
        .well();
    assert_eq!(csv_rows(&csv.out), sweep(line));
}

#[test]
fn threads_do_not_change_a_byte() {
    let folder = Folder::new();
    let with = |threads: &str| {
        let words = format!("sweep --ratio 1.0:3.0:0.25 {SHORT} --format json --quiet");
        let words: Vec<_> = words.split_whitespace().collect();
        let mut command = folder.command(&words);
        command.env("RAYON_NUM_THREADS", threads);
        finish(command).well().out
    };
    assert_eq!(with("1"), with("2"));
}

#[test]
fn the_switch_model_sweeps_too() {
    let line = "--ratio 1.4:1.6:0.1 --cart prescribed";
    let reference = sweep(line);
    for (switch, event) in sweep(&format!("{line} --engine switch"))
        .iter()
        .zip(&reference)
    {
        assert_eq!(switch["regime"], event["regime"]);
        let error = number(switch, "force_n") / number(event, "force_n") - 1.0;
        assert!(error.abs() < 2e-4, "{error:e}");
    }
}

#[test]
fn out_holds_both_directions_in_one_picture() {
    let folder = Folder::new();
    let line = format!("sweep --gap 2.4 --ratio 1.3:1.6:0.1 --direction up {SHORT} --out o");
    let ran = folder.run(&format!("{line} --format json --quiet")).well();
    assert!(ran.err.is_empty());
    let names = ["-down.csv", ".csv", ".json", ".png", ".svg"];
    assert_eq!(folder.ends("o/sweep"), names);
    assert_eq!(folder.read_made("o/sweep", ".json"), ran.out);
    assert_eq!(
        Value::from(csv_rows(&folder.read_made("o/sweep", ".csv"))),
        without_origin(ran.json())
    );
    let down = csv_rows(&folder.read_made("o/sweep", "-down.csv"));
    assert_ne!(
        down,
        csv_rows(&folder.read_made("o/sweep", ".csv")),
        "this gap jumps"
    );
    assert_svg_shows(
        &folder.read_made("o/sweep", ".svg"),
        &["carried up", "carried down", "drive frequency, Hz"],
    );
    png_size(&std::fs::read(folder.made("o/sweep", ".png")).expect("a picture"));
}

/// A "measurement" made from the sweep itself, 1/1.25 of it: the simulation is 25 % too high.
#[test]
fn measured_prints_the_error_that_was_put_in() {
    let line = "--ratio 1.4:1.8:0.1";
    let mut csv = String::from("frequency_hz,comment,force_n\n");
    for row in sweep(line) {
        let (hz, force) = (number(&row, "frequency_hz"), number(&row, "force_n"));
        csv += &format!("{hz:?},made up,{:?}\n", force / 1.25);
    }
    csv += "99.0,outside,1.0\n";
    let folder = Folder::new().with("rig1.csv", csv);
    let line = format!("sweep {line} {SHORT} --measured rig1.csv");
    let said = "measured: 5 points compared (1 outside), mean +25.0 %, largest 25.0 %";
    let text = folder.run(&line).well();
    assert!(text.out.contains(said), "{text:?}");
    let json = folder.run(&format!("{line} --format json --out o")).well();
    assert!(json.err.contains(said), "{json:?}");
    assert_eq!(json.json().as_array().map(Vec::len), Some(5));
    let error: Value =
        serde_json::from_str(&folder.read_made("o/sweep", "-error.json")).expect("JSON");
    for key in ["mean_percent", "largest_percent"] {
        assert!((number(&error, key) - 25.0).abs() < 1e-9, "{error}");
    }
    assert_svg_shows(
        &folder.read_made("o/sweep", ".svg"),
        &["measured", "mean +25.0 %"],
    );
}
