//! `host-sim modes`.

use crate::support::{Folder, answer, assert_refused, assert_svg_shows, csv_rows, number};

const SHORT: &str = "--cycles 120 --transient 90";

#[test]
fn one_mode_of_a_light_beam_is_what_simulate_says() {
    // A beam of a thousandth of the hammer's mass: its one mode has 1.0004 times the hammer's mass.
    let told = answer(&format!(
        "modes --rig beam-150 --modes 1 --springs-mass 0.001 --ratio 1.8 {SHORT}"
    ));
    let alone = answer(&format!("simulate --rig beam-150 --ratio 1.8 {SHORT}"));
    let row = &told["rows"][0];
    assert_eq!(row["regime"], alone["regime"]);
    let (force, known) = (number(row, "force_n"), number(&alone, "force_n"));
    assert!(
        (force / known - 1.0).abs() < 2e-3,
        "{force} against {known}"
    );
}

#[test]
fn tables_and_picture_are_written_with_units() {
    let folder = Folder::new();
    let line = "modes --rig beam-170 --modes 1,3 --ratio 1.7:1.9:0.1 --format csv --out out";
    let rows = csv_rows(&folder.run(&format!("{line} {SHORT}")).well().out);
    assert_eq!(rows.len(), 6);
    for key in ["frequency_hz", "force_n", "swing_mm"] {
        assert!(number(&rows[0], key) > 0.0, "{key}");
    }
    assert_eq!(number(&rows[0], "higher_energy_share"), 0.0);
    assert!(number(&rows[1], "higher_energy_share") > 0.0);
    assert_eq!(folder.ends("out/modes"), [".csv", ".json", ".png", ".svg"]);
    assert_svg_shows(
        &folder.read_made("out/modes", ".svg"),
        &["swing, mm", "3 modes"],
    );
}

#[test]
fn what_cannot_be_is_refused_in_one_line() {
    assert_refused(
        &Folder::new(),
        [
            ("modes --ratio 1.8", "beam-170"),
            ("modes --rig beam-170 --ratio 0", "not a positive value"),
            ("modes --rig beam-170 --ratio 2:1:0.1", "swap them"),
            ("modes --rig beam-170 --ratio 1.8 --modes 0", "from 1 to 8"),
            ("modes --rig beam-170 --ratio 1.8 --modes 9", "from 1 to 8"),
            (
                "modes --rig beam-170 --ratio 1.8 --modes 2,1,2",
                "names 2 twice",
            ),
            (
                "modes --rig beam-170 --ratio 1.8 --springs-mass nan",
                "mass is NaN",
            ),
            (
                "modes --rig beam-170 --ratio 1.8 --springs-mass -1",
                "mass is -1",
            ),
            ("modes --rig beam-170 --ratio 1.8 --gap -1", "gap_mm is -1"),
            (
                "modes --rig beam-170 --ratio 1.8 --engine switch",
                "unexpected argument '--engine'",
            ),
        ]
        .map(|(line, says)| (format!("{line} {SHORT} --out out"), says)),
    );
}
