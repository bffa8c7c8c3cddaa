//! `host-sim contact`.

use shared::model::contact::LAWS;

use crate::support::{
    Folder, answer, assert_refused, assert_svg_shows, csv_rows, number, png_size,
};

#[test]
fn the_rigs_own_contact_is_the_closed_form_and_alone_would_pull() {
    let rows = answer("contact --speed 0.08");
    let rows = rows.as_array().expect("rows");
    assert_eq!(rows.len(), LAWS.len());
    let dashpot = &rows[0];
    assert_eq!(dashpot["law"], "spring-dashpot");
    // 0.298 kg, Table 3.1: 0.570751 ms and 0.316902.
    assert!((number(dashpot, "contact_time_ms") / 0.570751 - 1.0).abs() < 2e-6);
    assert!((number(dashpot, "restitution") / 0.316902 - 1.0).abs() < 2e-6);
    for row in rows {
        assert_eq!(number(row, "pull_share") > 0.0, row == dashpot, "{row}");
        assert!(number(row, "energy_imbalance").abs() < 1e-9, "{row}");
    }
}

#[test]
fn figure_3_3_and_its_files() {
    let folder = Folder::new();
    let ran = folder
        .run("contact --figure-3-3 --out o --format csv --quiet")
        .well();
    let rows = csv_rows(&ran.out);
    assert_eq!(rows.len(), 5);
    // Slow blows lose (2/3) λ v.
    let first = 1.0 - number(&rows[0], "restitution");
    assert!(
        (first / (2.0 / 3.0 * 0.6 * 0.1) - 1.0).abs() < 0.05,
        "{first}"
    );
    assert_eq!(folder.ends("o/contact"), [".csv", ".json", ".png", ".svg"]);
    assert_svg_shows(
        &folder.read_made("o/contact", ".svg"),
        &["indentation, µm", "contact force, N", "0.5"],
    );
    png_size(&std::fs::read(folder.made("o/contact", ".png")).expect("a picture"));
    let text = folder.run("contact").well().out;
    assert!(
        text.contains("would pull") && text.contains("never"),
        "{text}"
    );
}

#[test]
fn bad_input_is_one_line_and_nothing_is_written() {
    assert_refused(
        &Folder::new(),
        [
            (
                "contact --speed 0:1:0.1",
                "is not a speed from 1e-6 to 100 m/s",
            ),
            ("contact --speed 0", "0.0 m/s is not a speed"),
            ("contact --speed x", "write FROM:TO:STEP, or one number"),
            ("contact --speed -1:1:0.1", "is not a speed from"),
            // So slow that nothing but NaN came of it.
            ("contact --speed 1e-300", "1e-300 m/s is not a speed from"),
            ("contact --speed 1:nan:1", "finite"),
            ("contact --speed 1e-6:1:1e-5", "more than 10000"),
            ("contact --gap 1", "unexpected argument '--gap'"),
            ("contact --engine switch", "unexpected argument '--engine'"),
            ("contact --set mass_kg=-1", "mass_kg"),
            ("contact --figure-3-3 --law own", "cannot be used with"),
        ]
        .map(|(line, says)| (format!("{line} --out o"), says)),
    );
}
