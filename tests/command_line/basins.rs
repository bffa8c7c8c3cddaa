//! `host-sim basins`, and `host-sim pick --gap`.

use serde_json::Value;

use crate::support::{Folder, answer, assert_svg_shows, csv_rows, finish, number, png_size};

const SMALL: &str = "--grid 8x6 --cycles 60 --recorded 30 --samples 30 --until 90";

#[test]
fn the_table_of_starts_adds_up_to_the_summary() {
    let folder = Folder::new();
    let line = format!("basins --ratio 2 --gap-ratio 2 {SMALL} --out o");
    let ran = folder.run(&format!("{line} --format json --quiet")).well();
    assert_eq!(folder.ends("o/basins"), [".csv", ".json", ".png", ".svg"]);
    assert_eq!(folder.read_made("o/basins", ".json"), ran.out);
    let summary = ran.json();
    let rows = csv_rows(&folder.read_made("o/basins", ".csv"));
    assert_eq!(rows.len(), 48);
    let impacts = rows.iter().filter(|row| row["impact"] == true).count();
    assert!((number(&summary, "impact_share") - impacts as f64 / 48.0).abs() < 1e-12);
    let attractors = summary["attractors"].as_array().expect("a list");
    for attractor in attractors {
        let here = rows
            .iter()
            .filter(|row| row["attractor"] == attractor["name"]);
        let share = here.count() as f64 / 48.0;
        assert!(
            (number(attractor, "share") - share).abs() < 1e-12,
            "{attractor}"
        );
    }
    // The first start is the middle of the cell at the lowest displacement and velocity.
    assert!((number(&rows[0], "displacement_mm") - (-6.0 + 7.78 / 16.0)).abs() < 1e-9);
    assert!((number(&rows[0], "velocity_m_per_s") - (-0.15 + 0.025)).abs() < 1e-12);
    let words = [
        "impact / no impact",
        "by attractor",
        "displacement at the start, mm",
    ];
    assert_svg_shows(&folder.read_made("o/basins", ".svg"), &words);
    png_size(&std::fs::read(folder.made("o/basins", ".png")).expect("a picture"));
}

#[test]
fn frequency_ratio_gap_and_phase_are_taken_as_said() {
    let by_ratio = answer(&format!(
        "basins --rig beam-170 --ratio 1.8 --gap-ratio 2 {SMALL}"
    ));
    let by_hz = answer(&format!(
        "basins --rig beam-170 --frequency 8.1 --gap 1.78 {SMALL}"
    ));
    assert_eq!(by_ratio["attractors"], by_hz["attractors"]);
    assert_eq!(number(&by_ratio, "gap_mm"), 1.78);
    let later = answer(&format!(
        "basins --rig beam-170 --ratio 1.8 --gap-ratio 2 --phase 0.5 {SMALL}"
    ));
    assert_eq!(number(&later, "phase_turns"), 0.5);
    let narrow = answer(&format!(
        "basins --ratio 2 --displacement -1:0 --velocity -0.01:0.02 {SMALL}"
    ));
    assert_eq!(narrow["displacement_mm"], serde_json::json!([-1.0, 0.0]));
}

#[test]
fn a_cart_that_recoils_is_asked_for_as_elsewhere_and_told() {
    let asked = format!("basins --rig beam-170 --ratio 1.8 --gap-ratio 2 {SMALL}");
    let rigid = answer(&format!("{asked} --cart prescribed"));
    let recoiling = answer(&asked);
    assert_eq!(
        (&rigid["cart"], &recoiling["cart"]),
        (&"prescribed".into(), &"recoil".into())
    );
    assert_eq!(recoiling, answer(&format!("{asked} --cart recoil")));
    let strongest = |found: &Value| {
        let attractors = found["attractors"].as_array().expect("a list");
        let forces = attractors.iter().map(|a| number(a, "force_ratio"));
        forces.fold(0.0, f64::max)
    };
    assert!(strongest(&recoiling) < strongest(&rigid));
    let folder = Folder::new();
    let text = folder.run(&format!("{asked} --cart recoil --quiet")).well();
    let picture = folder.read_made("out/basins", ".svg");
    assert!(!picture.contains("from which it repeats"));
    assert!(text.out.contains("beam-170, cart recoils"), "{}", text.out);
    let refused = folder.run("basins --chapter --cart recoil");
    assert_eq!(refused.code, Some(2), "{refused:?}");
}

/// A plain area of one colour shows nothing.
#[test]
fn where_all_strike_to_the_end_the_picture_shows_how_soon_they_repeat() {
    let folder = Folder::new();
    folder
        .run(&format!("basins --ratio 2 --gap 0 {SMALL}"))
        .well();
    let picture = folder.read_made("out/basins", ".svg");
    assert_svg_shows(&picture, &["cycle from which it repeats"]);
    assert!(!picture.contains("cycle of the last contact"));
}

#[test]
fn threads_do_not_change_a_byte_of_the_starts() {
    let folder = Folder::new();
    let with = |threads: &str| {
        let line = format!("basins --ratio 2.2 --gap-ratio 1.5 {SMALL} --format csv --quiet");
        let words: Vec<_> = line.split_whitespace().collect();
        let mut command = folder.command(&words);
        command.env("RAYON_NUM_THREADS", threads);
        finish(command).well().out
    };
    assert_eq!(with("1"), with("2"));
}

#[test]
fn the_chapter_has_twelve_points() {
    let line = "basins --chapter --grid 3 --cycles 20 --recorded 10 --samples 0";
    let all = answer(line);
    let rigs: Vec<_> = all
        .as_array()
        .expect("a list")
        .iter()
        .map(|one| one["rig"].clone())
        .collect();
    let expected = [
        ("wires", 6),
        ("beam-170", 2),
        ("beam-150", 2),
        ("beam-135", 2),
    ];
    for (rig, count) in expected {
        assert_eq!(rigs.iter().filter(|r| **r == rig).count(), count);
    }
    let csv = Folder::new()
        .run(&format!("{line} --format csv --quiet"))
        .well();
    let rows = csv_rows(&csv.out);
    assert_eq!(rows.len(), 12);
    assert_eq!(rows[6]["figure"], Value::from("3.52 a"));
    assert_eq!(number(&rows[8], "gap_over_amplitude"), 1.74);
}

#[test]
fn gaps_stand_beside_each_other_and_one_is_advised() {
    let folder = Folder::new();
    let line = "pick --gap 0:2.4:2.4 --nominal --starts 20 --out o";
    let text = folder.run(line).well();
    assert!(
        text.out
            .starts_with("wires, cart recoils: Run at a gap of 0.0 mm"),
        "{text:?}"
    );
    assert_eq!(folder.ends("o/pick"), [".csv", ".json", ".png", ".svg"]);
    let rows = csv_rows(&folder.read_made("o/pick-wires-starts-20-nominal-gap", ".csv"));
    assert_eq!(rows.len(), 2);
    let alone = answer("pick --gap 2.4 --nominal");
    for key in ["operating_frequency_hz", "force_ratio"] {
        assert_eq!(rows[1][key], alone[key], "{key}");
    }
    assert_svg_shows(
        &folder.read_made("o/pick-wires-starts-20-nominal-gap", ".svg"),
        &["where starts end", "gap, mm"],
    );
}
