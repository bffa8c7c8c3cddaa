//! `host-sim map`.

use std::collections::BTreeMap;
use std::fs;

use serde_json::Value;

use crate::support::{
    Folder, answer, assert_refused, assert_svg_shows, csv_rows, keys, number, png_size,
};

/// A map in which much happens, in a moment.
const SMALL: &str = "map --gap 0:3:1 --ratio 0.9:3.9:0.5 --cycles 120";

const COLUMNS: [&str; 14] = [
    "gap_mm",
    "frequency_hz",
    "frequency_ratio",
    "impacts",
    "periods",
    "regime",
    "force_ratio",
    "force_n",
    "settled",
    "settling_cycles",
    "largest_period_searched",
    "uncertain",
    "failed",
    "cart",
];

/// The files of a folder and what they hold.
fn outputs(folder: &Folder) -> BTreeMap<String, Vec<u8>> {
    let names = folder.names().into_iter();
    names
        .map(|name| {
            let bytes = fs::read(folder.path(&name)).expect("a readable file");
            (name, bytes)
        })
        .collect()
}

fn run(folder: &Folder, line: &str) -> String {
    folder.run(line).well().out
}

/// Every cell of the map is what `simulate` finds alone, by the reference, over the same cycles.
#[test]
fn cells_are_what_single_runs_find() {
    let csv = run(&Folder::new(), &format!("{SMALL} --format csv --quiet"));
    assert_eq!(csv.lines().next().unwrap_or(""), COLUMNS.join(","));
    let rows = csv_rows(&csv);
    assert_eq!(rows.len(), 4 * 7);
    for row in rows.iter().step_by(3) {
        let line = format!(
            "simulate --gap {} --frequency {} --cycles 120 --transient 60",
            row["gap_mm"], row["frequency_hz"]
        );
        let alone = answer(&line);
        if !row["periods"].is_number() || row["settled"] == Value::Bool(false) {
            // Where nothing repeats, or not yet, two integrators part; what strikes still strikes.
            assert_eq!(row["regime"] == "none", alone["regime"] == "none", "{row}");
            continue;
        }
        for key in ["regime", "impacts", "periods"] {
            assert_eq!(row[key], alone[key], "{key}: {row}");
        }
        // The map's accuracy: a tenth of a percent.
        let error = number(row, "force_n") / number(&alone, "force_n") - 1.0;
        assert!(error.abs() < 1e-3, "{error:e}: {row}");
    }
}

#[test]
fn threads_change_no_byte() {
    // The reference has small tiles: 6 × 50 cells are three.
    let line = "map --gap 0:2.5:0.5 --ratio 1:3.45:0.05 --cycles 20 --reference --out o --quiet";
    let by = |threads: u32| {
        let folder = Folder::new();
        run(&folder, &format!("{line} --threads {threads}"));
        outputs(&folder)
    };
    let one = by(1);
    assert_eq!(one.len(), 6);
    assert_eq!(by(2), one);
}

#[test]
fn out_holds_pictures_and_tables_that_agree() {
    let folder = Folder::new();
    let line = format!("{SMALL} --format json --out o --quiet");
    let json = run(&folder, &line);
    let names = ["-force.png", "-force.svg", ".csv", ".json", ".png", ".svg"];
    assert_eq!(folder.ends("o/map-wires"), names);
    assert_eq!(folder.read_made("o/map-wires", ".json"), json);
    let whole: Value = serde_json::from_str(&json).expect("JSON");
    let map = &whole["maps"][0];
    let rows = csv_rows(&folder.read_made("o/map-wires", ".csv"));
    let layers = &map["layers"];
    assert!(keys(layers).contains(&"settling_cycles"));
    for (i, row) in rows.iter().enumerate() {
        for key in ["regime", "impacts", "force_ratio", "uncertain"] {
            assert_eq!(row[key], layers[key][i], "{key}");
        }
        // Row by row: all frequencies of the first gap first.
        assert_eq!(row["gap_mm"], map["gaps_mm"][i / 7]);
        assert_eq!(row["frequency_hz"], map["frequencies_hz"][i % 7]);
    }
    let counted: u64 = map["summary"]["regimes"]
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(|r| r["cells"].as_u64())
        .sum();
    assert_eq!(counted, 28);
    assert_svg_shows(&folder.read_made("o/map-wires", ".svg"), &["1/1", "Ω/ω"]);
    png_size(&fs::read(folder.made("o/map-wires", "-force.png")).expect("a picture"));
}

/// A cell whose hammer cannot be followed is a row that says so, and takes no other with it.
#[test]
fn a_cell_that_fails_is_a_row_that_says_so() {
    let folder = Folder::new();
    let ran = folder.run(
        "map --gap 0 --ratio 1.5 --engine switch --cart prescribed --tick-us 1000 --format json",
    );
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert!(ran.err.contains("in 1 of 1 cell"), "{ran:?}");
    let json: Value = serde_json::from_str(&ran.out).unwrap();
    let map = &json["maps"][0];
    assert_eq!(map["layers"]["regime"][0], "failed");
    assert_eq!(map["layers"]["failed"][0], Value::Bool(true));
    assert_eq!(
        (
            number(&map["summary"], "cells"),
            number(&map["summary"], "failed")
        ),
        (1.0, 1.0)
    );
    assert_eq!(map["summary"]["regimes"], serde_json::json!([]));
    let ran =
        folder.run("map --gap 0 --ratio 1.5 --engine switch --cart prescribed --tick-us 1000 --format csv --quiet");
    let rows = csv_rows(&ran.out);
    assert_eq!(
        (&rows[0]["regime"], &rows[0]["failed"]),
        (&"failed".into(), &true.into())
    );
}

/// Carried up and down, the same gap shows other regimes where the hammer jumps; one chain is what `sweep` does.
#[test]
fn carried_maps_follow_one_chain_per_gap() {
    let grid = "--ratio 1.3:1.8:0.05";
    for direction in ["up", "down"] {
        let line = format!("map --gap 2.4 {grid} --from {direction} --cycles 120 --recorded 40");
        let csv = run(&Folder::new(), &format!("{line} --format csv --quiet"));
        let line = format!("sweep --gap 2.4 {grid} --direction {direction}");
        let sweep = answer(&format!("{line} --cycles 120 --transient 80"));
        let rows = csv_rows(&csv);
        let mut compared = 0;
        for (row, other) in rows.iter().zip(sweep.as_array().expect("rows")) {
            if other["regime"] != "1/1" {
                continue;
            }
            compared += 1;
            assert_eq!(row["regime"], other["regime"], "{row} {other}");
            let error = number(row, "force_n") / number(other, "force_n") - 1.0;
            assert!(error.abs() < 2e-3, "{error:e}: {row}");
        }
        assert!(compared >= 2, "{direction}: {compared}");
    }
}

#[test]
fn settle_runs_on_what_has_not_settled() {
    let unsettled = |line: &str| {
        let rows = csv_rows(&run(&Folder::new(), line));
        let open = rows.iter().filter(|r| r["regime"] == "unsettled");
        (open.count(), rows)
    };
    let line = "map --gap 0.5 --ratio 1:3:0.1 --cycles 20 --format csv --quiet";
    let (short, _) = unsettled(line);
    let (longer, rows) = unsettled(&format!("{line} --settle 400"));
    assert!(longer < short, "{longer} of {short}");
    assert!(rows.iter().all(|r| r["regime"] != "aperiodic"));
    // What settled late says so.
    let late = rows.iter().filter_map(|r| r["settling_cycles"].as_f64());
    assert!(late.fold(0.0, f64::max) > 20.0);
}

#[test]
fn the_switch_engine_makes_maps_and_its_difference_is_told() {
    let folder = Folder::new();
    let line = "map --gap 0:0.4:0.4 --ratio 1.3:2.3:0.5 --cycles 120 --cart prescribed --against switch --quiet";
    let ran = folder.run(&format!("{line} --format json --out o")).well();
    let whole = ran.json();
    let engines: Vec<_> = [0, 1].map(|i| whole["maps"][i]["engine"].clone()).to_vec();
    assert_eq!(engines, ["event", "switch"]);
    let against = &whole["against"];
    assert_eq!(against["cells"], 6);
    // Settled 1/1 at small gaps: both see the same (docs/accuracy.md).
    assert_eq!(against["same_label"], 6, "{against}");
    assert_eq!(against["same_force"], 6, "{against}");
    let names = folder.names();
    let options = "ratio-1.3-2.3-0.5-cycles-120-against-switch-gap-0-0.4-0.4-cart-prescribed";
    for (map, end) in [
        ("map-wires-switch", ".csv"),
        ("map-wires", "-against.svg"),
        ("map-wires", ".csv"),
    ] {
        let name = format!("o/{map}-{options}{end}");
        assert!(names.contains(&name), "{name} {names:?}");
    }
}

#[test]
fn the_beams_stand_beside_one_another() {
    let folder = Folder::new();
    let line = "map --beams --gap 0:2:1 --ratio 1.2:3.2:0.5 --cycles 100 --out o";
    let ran = folder.run(line).well();
    for pair in [
        "beam-170 and beam-150",
        "beam-170 and beam-135",
        "beam-150 and beam-135",
    ] {
        assert!(ran.out.contains(pair), "{ran:?}");
    }
    let options = "ratio-1.2-3.2-0.5-cycles-100-beams-gap-0-2-1";
    let frequencies = |rig: &str| {
        let rows = csv_rows(&folder.read(&format!("o/map-{rig}-{options}.csv")));
        assert_eq!(rows.len(), 15);
        let ratios: Vec<_> = rows.iter().map(|r| r["frequency_ratio"].clone()).collect();
        (number(&rows[0], "frequency_hz"), ratios)
    };
    let ((soft, ratios), (stiff, same)) = (frequencies("beam-170"), frequencies("beam-135"));
    assert!(stiff > 1.4 * soft);
    assert_eq!(ratios, same);
    assert_svg_shows(
        &folder.read_made("o/map-beam-170", "-beside.svg"),
        &["beam-150", "same regime in"],
    );
}

#[test]
fn an_audit_finds_the_map_right() {
    let line = "map --gap 0:1:0.25 --ratio 1.2:2.2:0.1 --audit 12 --seed 7";
    let whole = answer(line);
    let audit = &whole["audit"];
    assert_eq!(audit["cells"], 12);
    assert_eq!(audit["same_label"], 12, "{audit}");
    assert_eq!(audit["same_force"], audit["both_periodic"], "{audit}");
    assert!(audit["both_periodic"].as_u64() > Some(6), "{audit}");
}

#[test]
fn measured_points_are_laid_over() {
    let csv = "gap_mm,frequency_hz,regime\n0.0,3.64,1/1\n0.02,3.64,1/2\n0.0,99,none\n";
    let folder = Folder::new().with("seen.csv", csv);
    let line = "map --gap 0:1:0.5 --frequency 2.64:4.64:0.5 --measured seen.csv --out o";
    let ran = folder.run(line).well();
    let said = "1 of 2 points have the regime of the cell they lie on (1 outside the map)";
    assert!(ran.out.contains(said), "{ran:?}");
    assert_svg_shows(&folder.read_made("o/map-wires", ".svg"), &["seen"]);
}

#[test]
fn one_gap_and_one_frequency_are_maps_too() {
    for grid in ["--gap 0", "--gap 0:1:0.5", "--ratio 1.5"] {
        let extra = match grid {
            "--ratio 1.5" => "--gap 1:1:1",
            "--gap 0" => "--ratio 1:3:0.5",
            _ => "--frequency 3",
        };
        let folder = Folder::new();
        let ran = folder
            .run(&format!("map {grid} {extra} --cycles 60"))
            .well();
        assert!(ran.out.contains("regimes"), "{ran:?}");
        assert!(folder.made("out/map-wires", ".png").is_file());
    }
}

#[test]
fn what_cannot_be_is_refused_in_one_line_and_leaves_nothing() {
    let folder = Folder::new()
        .with(
            "odd.csv",
            "gap_mm,frequency_hz,regime\n0,2,1/1\n0,2,often\n",
        )
        .with("cut.csv", "gap_mm,frequency_hz\n0,2\n")
        .with("taken", "keep");
    assert_refused(
        &folder,
        [
            ("--gap 0:1", "write FROM:TO:STEP"),
            ("--gap 1 --gap 0.5", "rising order"),
            ("--gap nan", "gap_mm is NaN"),
            ("--gap 500", "gap_mm is 500"),
            ("--gap 0:1e9:1", "use a larger STEP"),
            ("--ratio 0:1:0.5", "not a positive value"),
            ("--ratio inf", "a finite number"),
            ("--ratio 1e9", "it must be from 0.01 to 1000 times"),
            ("--frequency 2 --ratio 2", "cannot be used with"),
            ("--gap 0:1:0.0001 --ratio 1:4:0.0001", "20000000"),
            ("--recorded 0", "--recorded is 0"),
            ("--cycles 50 --recorded 100", "--recorded is 100"),
            ("--settle 300", "must be more than the 300"),
            // It may not name an option that was not given as if it was.
            (
                "--transient 900",
                "--transient 900 leaves nothing of the 300 drive cycles of a run to record; give --cycles more than 900",
            ),
            (
                "--recorded 900",
                "must be from 1 to the 300 drive cycles of a run (--cycles)",
            ),
            ("--cycles 0", "--cycles is 0"),
            ("--audit 0", "--audit is 0, must be from 1 to"),
            ("--audit 5 --from up", "leave one of the two out"),
            ("--seed 5", "--audit"),
            ("--against rest", "choose another"),
            ("--reference --against reference", "choose another"),
            ("--beside wires", "two rigs are called wires"),
            ("--beams --rig wires", "cannot be used with"),
            ("--beams --format csv", "do not fit into one table"),
            ("--gap 0 --ratio 2 --audit 2", "the map has 1 cell"),
            ("--threads 0", "from 1 to 1024"),
            (
                "--reference --engine switch",
                "does not go with --engine switch",
            ),
            ("--tick-us 20", "add --engine switch"),
            ("--measured odd.csv", "odd.csv, line 3: regime is 'often'"),
            (
                "--measured cut.csv",
                "cut.csv, line 1: there is no column regime",
            ),
            ("--measured none.csv", "cannot read none.csv"),
            ("--out taken", "choose another folder"),
        ]
        .map(|(line, says)| (format!("map {line}"), says)),
    );
}

#[test]
fn the_strongest_one_one_and_the_strongest_of_all_are_two_answers() {
    let line = "map --gap 0:1:1 --ratio 1.5:4:0.5 --cycles 120";
    let told = answer(line);
    let summary = &told["maps"][0]["summary"];
    let cells = csv_rows(&run(
        &Folder::new(),
        &format!("{line} --format csv --quiet"),
    ));
    let text = run(&Folder::new(), line);
    for (key, name, ones) in [
        ("strongest_one_one", "strongest 1/1:", true),
        ("strongest_of_all", "strongest of all:", false),
    ] {
        let asked = cells.iter().filter(|c| !ones || c["regime"] == "1/1");
        let most = asked.max_by(|a, b| number(a, "force_n").total_cmp(&number(b, "force_n")));
        let most = most.expect("a cell");
        for column in ["regime", "gap_mm", "frequency_hz", "force_n"] {
            assert_eq!(summary[key][column], most[column], "{key} {column}");
        }
        assert_eq!(text.matches(name).count(), 1, "{text}");
    }
    assert_ne!(summary["strongest_of_all"]["regime"], "1/1");
    // Where both are one it is said once.
    let one = run(&Folder::new(), "map --gap 0 --ratio 1.5:2:0.5 --cycles 120");
    assert_eq!(one.matches("strongest").count(), 1, "{one}");
    assert!(one.contains("strongest of all: 1/1 with"), "{one}");
    assert!(!one.contains(": unsettled with "), "{one}");
    // One of each is named in the singular, and what has not settled is no answer to rely on.
    let open = run(&Folder::new(), "map --gap 2.5 --ratio 4 --cycles 20");
    assert!(open.contains(": 1 gap (2.5 mm) by 1 frequency ("), "{open}");
    assert!(open.contains(" Hz), 1 cell\n"), "{open}");
    assert!(open.contains("strongest of all: unsettled with "), "{open}");
}
