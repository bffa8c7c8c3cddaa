//! A cell whose hammer cannot be followed is a row that says so; the others go on.

use serde_json::Value;

use crate::support::{Folder, csv_rows};

/// Hertz's contact loses no energy: on wires the hammer goes over the top.
const HERTZ: &str = "--gap 0.5 --set contact_law=hertz --set contact_stiffness_n_per_m=2.51502e9 --set contact_exponent=1.5";

/// `command` prints rows, some of which say failed and have no force; and notes it.
fn some_fail(command: &str, note: &str) {
    let folder = Folder::new();
    let ran = folder
        .run(&format!("{command} {HERTZ} --format csv --out out"))
        .well();
    assert!(ran.err.contains(note), "{}", ran.err);
    let rows = csv_rows(&ran.out);
    let (failed, others): (Vec<_>, Vec<_>) = rows.iter().partition(|r| r["regime"] == "failed");
    assert!(!failed.is_empty() && !others.is_empty(), "{rows:?}");
    for row in failed {
        assert!(row["force_n"].is_null() || row["force_n"] == "", "{row:?}");
    }
    let json = folder
        .run(&format!("{command} {HERTZ} --format json --quiet"))
        .well();
    let json: Value = serde_json::from_str(&json.out).unwrap();
    assert!(json.to_string().contains("failed"));
    folder.run(&format!("{command} {HERTZ} --quiet")).well();
}

#[test]
fn a_sweep_goes_on_behind_a_run_that_fails() {
    some_fail("sweep --ratio 0.8:4:0.2", "their rows say failed");
}

#[test]
fn a_diagram_goes_on_behind_a_run_that_fails() {
    some_fail(
        "bifurcation --ratio 0.8:4:0.2 --direction all",
        "their rows say failed",
    );
}

#[test]
fn where_every_run_fails_the_command_says_why() {
    let folder = Folder::new();
    for command in ["sweep --ratio 3.8", "bifurcation --ratio 3.8"] {
        let ran = folder.run(&format!("{command} {HERTZ} --quiet"));
        assert!(
            ran.err.contains("leaves what the model describes"),
            "{}",
            ran.err
        );
    }
}
