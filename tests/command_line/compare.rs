//! `host-sim compare`.

use crate::support::{Folder, assert_refused, assert_svg_shows, csv_rows, number, png_size};

const SHORT: &str = "--cycles 160 --transient 140";

/// A folder with a record that `simulate` wrote.
fn simulated(drive: &str) -> Folder {
    let folder = Folder::new();
    folder
        .run(&format!("simulate {drive} {SHORT} --out s --quiet"))
        .well();
    let rows = csv_rows(&folder.read_made("s/simulate", "-history.csv"));
    let mut csv = String::from("time_s,displacement_mm\n");
    // The record's clock starts somewhere; a history has both sides of a switch at one instant.
    for row in rows.iter().skip(137) {
        let (t, x) = (number(row, "time_s") - 50.0, number(row, "displacement_mm"));
        csv += &format!("{t:?},{x:?}\n");
    }
    folder.with("record.csv", csv)
}

/// A simulation is its own measurement: force, contact time and impulse are the same on both sides, with either cart.
/// The history has its instants where the simulation puts them, close together in a contact and far apart in flight.
#[test]
fn a_simulation_finds_its_own_contacts() {
    for cart in ["recoil", "prescribed"] {
        let folder = Folder::new();
        let rig = format!("--gap 1 --ratio 1.8 --cart {cart} {SHORT}");
        let told = folder.run(&format!("simulate {rig} --out s --format json --quiet"));
        let told = told.well().json();
        let history = folder.made("s/simulate", "-history.csv");
        let line = format!("compare {} {rig} --format json --quiet", history.display());
        let seen = folder.run(&line).well().json();
        let off = |a: f64, b: f64| (a / b - 1.0).abs();
        let of = |key: &str| number(&seen, key);
        let times = ["measured", "simulated"].map(|side| of(&format!("{side}_contact_time_ms")));
        assert!(off(times[0], times[1]) < 0.02, "{seen}");
        assert!(
            off(times[0], number(&told, "contact_time_ms")) < 0.03,
            "{seen}"
        );
        assert!(of("force_peak_percent").abs() < 0.1, "{seen}");
        assert_eq!(told["cart"], cart);
    }
}

#[test]
fn a_record_of_the_model_lies_on_it() {
    let folder = simulated("--gap 1 --ratio 1.5");
    let line = format!("compare record.csv --gap 1 --ratio 1.5 {SHORT} --quiet --out o");
    let json = folder.run(&format!("{line} --format json")).well().json();
    assert_eq!(json["regime"], "1/1");
    assert!(number(&json, "displacement_rms_percent") < 0.1, "{json}");
    assert_eq!(
        folder
            .read_made("o/compare", ".json")
            .parse::<serde_json::Value>()
            .ok(),
        Some(json)
    );
    assert_svg_shows(
        &folder.read_made("o/compare", ".svg"),
        &["Phase plane", "displacement, mm", "measured", "simulation"],
    );
    png_size(&std::fs::read(folder.made("o/compare", ".png")).expect("a picture"));
    // Another gap is another motion, and the errors say so.
    let wrong = format!("compare record.csv --gap 0 --ratio 1.5 {SHORT} --quiet --format json");
    let wrong = folder.run(&wrong).well().json();
    assert!(number(&wrong, "displacement_rms_percent") > 3.0, "{wrong}");
}

/// The emulator's own log: drive and phase are found by the cart, and the motion is much like the simulation's.
#[test]
fn an_emulators_log_is_read() {
    let folder = Folder::new();
    folder.run("emulate link-timeout --out e --quiet");
    let Some(log) = folder.names().into_iter().find(|n| n.ends_with(".parquet")) else {
        panic!("no log: {:?}", folder.names());
    };
    let whole = folder
        .run(&format!(
            "compare {log} --from 5 --to 9 {SHORT} --format json --quiet"
        ))
        .well()
        .json();
    assert_eq!(whole["frequency_from"], "cart", "{whole}");
    assert_eq!(whole["regime"], "1/1", "{whole}");
    let contacts = number(&whole, "measured_contacts_per_period");
    assert!((contacts - 1.0).abs() < 0.1, "{whole}");
}

#[test]
fn bad_input_is_one_line() {
    let folder = simulated("--gap 1 --ratio 1.5");
    assert_refused(
        &folder,
        [
            ("compare nowhere.csv", "cannot read nowhere.csv"),
            ("compare record.csv --from 1e6", "at least 16 are needed"),
            (
                "compare record.csv --frequency -1",
                "must be a positive number",
            ),
            (
                "compare record.csv --frequency 1 --ratio 1",
                "cannot be used with",
            ),
            (
                "compare record.csv --transient 600",
                "give --cycles more than 600",
            ),
        ],
    );
}
