//! A cell whose hammer cannot be followed is a row that says so; the others go on.

use serde_json::Value;

use crate::support::{Folder, csv_rows, number};

/// Hertz's contact loses no energy: on wires in a prescribed cart the hammer goes over the top.
const HERTZ: &str = "--gap 0.5 --cart prescribed --set contact_law=hertz --set contact_stiffness_n_per_m=2.51502e9 --set contact_exponent=1.5";

/// What a row that failed says.
const WHY: &str = "failed: the hammer leaves the model's range";

/// `command` has rows some of which say failed and have no force, and notes it; what it printed.
fn some_fail(command: &str, note: &str) -> String {
    let folder = Folder::new();
    let ran = folder.run(&format!("{command} {HERTZ} --out out")).well();
    assert!(ran.err.contains(note), "{}", ran.err);
    let rows = csv_rows(&folder.read_made("out/", ".csv"));
    let (failed, others): (Vec<_>, Vec<_>) = rows.iter().partition(|r| r["regime"] == "failed");
    assert!(!failed.is_empty() && !others.is_empty(), "{rows:?}");
    for row in failed {
        assert!(row["force_n"].is_null() || row["force_n"] == "", "{row:?}");
    }
    let json: Value = serde_json::from_str(&folder.read_made("out/", ".json")).unwrap();
    assert!(json.to_string().contains("failed"));
    assert!(!ran.out.contains("NaN"), "{}", ran.out);
    ran.out
}

#[test]
fn a_sweep_goes_on_behind_a_run_that_fails() {
    let text = some_fail("sweep --ratio 0.8:4:0.2", "their rows give the reason");
    assert!(text.contains(WHY), "{text}");
}

#[test]
fn a_diagram_goes_on_behind_a_run_that_fails() {
    some_fail(
        "bifurcation --ratio 3.4:4:0.2 --direction all",
        "their rows say failed",
    );
}

#[test]
fn a_sweep_over_a_parameter_says_why_a_row_failed_and_no_sweep_shows_nan() {
    let folder = Folder::new();
    let line = format!("sweep --ratio 3.8 {HERTZ} --over amplitude_mm=0.05,0.89 --quiet");
    let text = folder.run(&line).well().out;
    assert!(text.contains(WHY) && !text.contains("NaN"), "{text}");
    let line =
        "sweep --gap 0.5 --ratio 1,2 --engine switch --cart prescribed".replace("1,2", "1:3:1");
    let law = "--set contact_law=hertz --set contact_stiffness_n_per_m=2.51502e9 --set contact_exponent=1.5";
    let ran = folder.run(&format!("{line} {law} --tick-us 200"));
    assert!(!ran.out.contains("NaN"), "{ran:?}");
}

/// Starts of up to 2 m/s carry a hammer on wires of 75 mm over the top.
#[test]
fn basins_go_on_behind_a_start_that_fails() {
    let folder = Folder::new();
    let line = "basins --ratio 2 --gap 0.5 --velocity -2:0.1 --grid 8x6 --cycles 60 --recorded 30 --samples 0 --until 60";
    let ran = folder.run(&format!("{line} --out out")).well();
    assert!(ran.err.contains("16 starts of the grid"), "{}", ran.err);
    let rows = csv_rows(&folder.read_made("out/", ".csv"));
    let (failed, others): (Vec<_>, Vec<_>) = rows.iter().partition(|r| r["regime"] == "failed");
    assert_eq!((failed.len(), others.len()), (16, 32));
    for row in failed {
        assert_eq!(row["impact"], false, "{row:?}");
        for unknown in ["impacts", "force_ratio", "settled_after_cycles"] {
            assert!(
                row[unknown].is_null() || row[unknown] == "",
                "{unknown}: {row:?}"
            );
        }
        // Only the fastest of them.
        assert!(number(row, "velocity_m_per_s") < -1.0, "{row:?}");
    }
    let json: Value = serde_json::from_str(&folder.read_made("out/", ".json")).unwrap();
    assert_eq!(number(&json, "failed"), 16.0);
    let text = ran.out;
    assert!(text.contains("failed") && !text.contains("NaN"), "{text}");
}

#[test]
fn where_every_run_fails_the_command_says_why() {
    let folder = Folder::new();
    for command in ["sweep --ratio 3.8", "bifurcation --ratio 3.8"] {
        let ran = folder.run(&format!("{command} {HERTZ} --quiet"));
        assert!(ran.err.contains("leaves the model's range"), "{}", ran.err);
    }
}
