//! `host-sim trials`.

use crate::support::{Folder, answer, assert_refused, assert_svg_shows, csv_rows, number};

#[test]
fn rigs_drawn_at_random_are_held_soon_and_at_their_optimum() {
    let folder = Folder::new();
    let ran = folder
        .run("trials --count 4 --seconds 25 --seed 2 --out o --format csv --quiet")
        .well();
    let rows = csv_rows(&ran.out);
    assert_eq!(rows.len(), 4);
    for row in &rows {
        assert_eq!(row["held"], true, "{row}");
        assert!(row["faults"].is_null(), "{row}");
        // Over 200 trials the last held after 11.6 s, and the least share was 0.9965.
        assert!(number(row, "hold_s") < 20.0, "{row}");
        let share = number(row, "force_share_at_amplitude");
        assert!((0.98..1.02).contains(&share), "{row}");
    }
    assert_eq!(folder.ends("o/trials"), [".csv", ".json", ".png", ".svg"]);
    assert_svg_shows(
        &folder.read_made("o/trials", ".svg"),
        &["wires", "beam-135", "10 s"],
    );
}

#[test]
fn a_trial_can_be_shown_and_run_by_itself() {
    let all = answer("trials --count 1 --seconds 20 --rig beam-135");
    let one = &all["trials"][0];
    let folder = Folder::new();
    let shown = folder
        .run("trials --show 0 --seconds 20 --rig beam-135")
        .well();
    let folder = folder.with("one.toml", &shown.out);
    let verdict = folder.run("emulate one.toml --no-log --format json").json();
    assert_eq!(number(&verdict, "time_to_hold_s"), number(one, "hold_s"));
    assert_eq!(number(&verdict, "force_share"), number(one, "force_share"));
}

#[test]
fn what_cannot_be_run_is_refused() {
    let lines = [
        ("trials --count 0", "--count is 0"),
        ("trials --seconds 5", "--seconds is 5"),
        ("trials --seconds NaN", "--seconds is NaN"),
        ("trials --rig beam-13", "beam-135"),
    ];
    assert_refused(&Folder::new(), lines);
}
