//! `host-sim bifurcation`.

use crate::support::{
    Folder, answer, assert_refused, assert_svg_shows, csv_rows, finish, number, png_size,
};

const SHORT: &str = "--cycles 160 --recorded 20";

#[test]
fn the_doubling_is_listed_and_located() {
    let found = answer(&format!("bifurcation --gap 0 --ratio 2.5:2.8:0.02 {SHORT}"));
    let changes = found["diagrams"][0]["changes"].as_array().expect("changes");
    let doubling = changes.iter().find(|c| c["kind"] == "doubling");
    let doubling = doubling.expect("the 1/1 doubles between 2.5 and 2.8");
    assert_eq!(
        (&doubling["below"], &doubling["above"]),
        (&"1/1".into(), &"2/2".into())
    );
    // The chapter sees the doubled motion at 2.7.
    let ratio = number(doubling, "frequency_ratio");
    assert!((2.6..2.7).contains(&ratio), "{ratio}");
    assert!(number(doubling, "within_hz") < 1e-4);
}

/// Below the doubling the alternation dies out so slowly that it repeats within the section's tolerance: that is no 2/2, here
/// as in `simulate`. `orbits` has the doubling at 4.850725 Hz.
#[test]
fn a_doubling_is_where_orbits_has_it() {
    let found = answer("bifurcation --gap 0 --frequency 4.6:5:0.02");
    let hz = number(&found["diagrams"][0]["changes"][0], "frequency_hz");
    assert!((hz - 4.850_725).abs() < 5e-4, "{hz}");
    let folder = Folder::new();
    for (cycles, said) in [(1000, "give more --cycles"), (3000, "give --transient 9")] {
        let line = format!("simulate --gap 0 --frequency 4.8485 --cycles {cycles}");
        let told = folder.run(&line).well().out;
        assert!(told.contains("unsettled") && told.contains(said), "{told}");
    }
}

/// Carried down at 2.4 mm, the motion without contact gives way to one that does not repeat, in a strip narrower than the step,
/// before it becomes a 1/1. (The row said from none to 1/1 at 1.597, where there is no 1/1: its fold is at 1.5914.)
#[test]
fn a_motion_between_two_frequencies_is_named() {
    let found =
        answer("bifurcation --gap 2.4 --direction down --ratio 1.2:2:0.02 --cart prescribed");
    let changes = found["diagrams"][0]["changes"].as_array().expect("changes");
    let from_none = changes.iter().filter(|change| change["above"] == "none");
    for change in from_none {
        let known = change["below"] != "1/1" || number(change, "frequency_ratio") < 1.5914;
        assert!(known, "{change}");
    }
    assert!(changes.iter().any(|change| change["above"] == "none"));
}

/// What has not settled is not aperiodic, as `sweep` has it, and no regime changes there.
#[test]
fn a_run_too_short_to_settle_is_unsettled() {
    let folder = Folder::new();
    let line = "bifurcation --gap 0 --ratio 2.5:2.8:0.02 --cycles 20";
    let rows = csv_rows(&folder.run(&format!("{line} --format csv")).well().out);
    assert!(rows.iter().any(|row| row["regime"] == "unsettled"));
    assert!(rows.iter().all(|row| row["regime"] != "aperiodic"));
    let found = answer(line);
    let diagram = &found["diagrams"][0];
    assert!(number(diagram, "not_settled") > 0.0);
    for change in diagram["changes"].as_array().expect("changes") {
        assert!(
            change["below"] != "aperiodic" && change["above"] != "aperiodic",
            "{change}"
        );
    }
    let one = folder
        .run("bifurcation --gap 0 --ratio 2 --cycles 160")
        .well();
    assert!(one.out.contains("each from rest: 1 frequency\n"), "{one:?}");
}

#[test]
fn several_gaps_and_directions_answer_one_after_the_other() {
    let folder = Folder::new();
    let line = format!(
        "bifurcation --gap 0:1:1 --gap 2.4 --ratio 1.4:1.6:0.1 --direction all {SHORT} --format csv --quiet"
    );
    let rows = csv_rows(&folder.run(&line).well().out);
    let mut seen: Vec<(f64, String)> = Vec::new();
    for row in &rows {
        let key = (
            number(row, "gap_mm"),
            row["direction"].as_str().expect("a name").to_owned(),
        );
        if seen.last() != Some(&key) {
            seen.push(key);
        }
    }
    let wanted = [0.0, 1.0, 2.4].map(|gap| ["rest", "up", "down"].map(|d| (gap, d.to_owned())));
    assert_eq!(seen, wanted.concat());
    // A 1/1 is one point at each frequency.
    let settled = rows
        .iter()
        .filter(|r| r["regime"] == "1/1" && number(r, "gap_mm") == 1.0);
    assert_eq!(settled.count(), 9);
}

#[test]
fn a_point_is_what_simulate_shows_on_its_section() {
    let folder = Folder::new();
    let line = format!("bifurcation --gap 1 --ratio 1.5:1.5:1 {SHORT} --format csv --quiet");
    let rows = csv_rows(&folder.run(&line).well().out);
    folder
        .run("simulate --gap 1 --ratio 1.5 --cycles 160 --transient 140 --out a --quiet")
        .well();
    let section = csv_rows(&folder.read_made("a/simulate", "-section.csv"));
    let last = section.last().expect("a section");
    let [here, there] = [
        number(&rows[0], "displacement_mm"),
        number(last, "relative_displacement_mm"),
    ];
    // Both settle on the same orbit: the section's tolerance is 1e-3 of A0, the orbit attracts far below it.
    assert!((here - there).abs() < 1e-3 * 0.89, "{here} {there}");
}

/// Against the reference: `sweep` carries the state in the same way.
#[test]
fn a_cart_that_recoils_is_carried_up_as_sweep_has_it() {
    let asked = "--gap 2.4 --ratio 1.2:1.5:0.05 --direction up --cart recoil --cycles 160";
    let found = answer(&format!("bifurcation {asked} --recorded 20"));
    assert_eq!(found["cart"], "recoil");
    let folder = Folder::new();
    let line = format!("bifurcation {asked} --recorded 20 --format csv --quiet");
    let points = csv_rows(&folder.run(&line).well().out);
    let line = format!("sweep {asked} --transient 140 --format csv --quiet");
    let rows = csv_rows(&folder.run(&line).well().out);
    assert_eq!(rows.len(), 7);
    for row in &rows {
        let hz = number(row, "frequency_hz");
        let here = points.iter().filter(|p| number(p, "frequency_hz") == hz);
        let here: Vec<_> = here.collect();
        let force = here
            .iter()
            .map(|p| number(p, "force_n"))
            .fold(0.0, f64::max);
        assert_eq!(row["regime"], "1/1");
        assert!(
            here.iter()
                .all(|p| p["regime"] == "1/1" && p["cart"] == "recoil")
        );
        let off = force / number(row, "force_n") - 1.0;
        assert!(off.abs() < 1e-3, "{hz} {off}");
    }
}

#[test]
fn out_holds_pictures_tables_and_the_measured_points() {
    let folder = Folder::new().with(
        "m.csv",
        "frequency_hz,displacement_mm,force_n\n2.7,-2.0,60\n2.8,-2.1,61\n9,0,0\n",
    );
    folder
        .run(&format!(
            "bifurcation --gap 1 --frequency 2.6:2.9:0.1 {SHORT} --measured m.csv --out a --quiet"
        ))
        .well();
    let wanted = ["-changes.csv", ".csv", ".json", ".png", ".svg"];
    assert_eq!(folder.ends("a/"), wanted);
    let told: serde_json::Value =
        serde_json::from_str(&folder.read_made("a/bifurcation", ".json")).expect("JSON");
    let distance = &told["diagrams"][0]["measured_displacement_mm"];
    assert_eq!(
        (
            number(distance, "points_compared"),
            number(distance, "points_outside")
        ),
        (2.0, 1.0)
    );
    assert_svg_shows(
        &folder.read_made("a/bifurcation", ".svg"),
        &["displacement, mm", "drive frequency, Hz", "measured"],
    );
    assert!(
        png_size(&std::fs::read(folder.made("a/bifurcation", ".png")).expect("a picture")).0
            >= 1200
    );
}

#[test]
fn threads_do_not_change_a_byte() {
    let folder = Folder::new();
    let with = |threads: &str| {
        let words = format!(
            "bifurcation --gap 2.4 --ratio 1.2:2.0:0.1 --direction all {SHORT} --format json --quiet"
        );
        let words: Vec<_> = words.split_whitespace().collect();
        let mut command = folder.command(&words);
        command.env("RAYON_NUM_THREADS", threads);
        finish(command).well().out
    };
    assert_eq!(with("1"), with("2"));
}

#[test]
fn bad_input_gets_one_line() {
    let folder = Folder::new()
        .with("no.csv", "hz,force\n1,2\n")
        .with("bad.csv", "frequency_hz,displacement_mm\n2.7,x\n");
    assert_refused(
        &folder,
        [
            ("--gap nan", "gap_mm"),
            ("--gap a", "write a number of millimetres"),
            ("--gap 2:1:0.1", "swap them"),
            ("--ratio 0:1:0.5", "is not a positive value"),
            ("--ratio 1:2:0", "must be positive"),
            ("--ratio 1:2:1 --frequency 1:2:1", "cannot be used with"),
            ("--recorded 0", "must be from 1 to the 300 drive cycles"),
            ("--recorded 400", "must be from 1 to the 300 drive cycles"),
            ("--measured none.csv", "cannot read none.csv"),
            ("--measured no.csv", "no.csv, line 1"),
            (
                "--measured bad.csv",
                "bad.csv, line 2: displacement_mm is 'x'",
            ),
            ("--direction sideways", "sideways"),
        ]
        .map(|(options, said)| (format!("bifurcation {options} --quiet"), said)),
    );
}

#[test]
fn a_command_for_one_gap_refuses_several() {
    let ran = Folder::new().run("simulate --ratio 1.5 --gap 0:1:0.5");
    assert_eq!(ran.code, Some(2));
    assert!(ran.err.contains("this command takes one"), "{ran:?}");
}

/// At 2.4 mm the 1/1 ends in a strip of chaos two frequencies wide; that is no reason not to list its end.
#[test]
fn the_end_of_the_one_one_is_listed_where_what_follows_is_brief() {
    let line = "bifurcation --gap 2.4 --frequency 2.5:3.1:0.01 --cart prescribed";
    let told = answer(line);
    let changes = told["diagrams"][0]["changes"].as_array().expect("changes");
    let end = changes
        .iter()
        .find(|c| c["below"] == "1/1" && c["lasting"] == true)
        .expect("the end of the 1/1");
    assert!(
        (number(end, "frequency_ratio") - 1.585).abs() < 0.005,
        "{end}"
    );
    let text = Folder::new().run(line).well().out;
    assert!(text.contains("1/1        aperiodic"), "{text}");
}
