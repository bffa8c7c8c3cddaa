//! `host-sim poincare`.

use crate::support::{
    Folder, answer, assert_refused, assert_svg_shows, csv_rows, number, png_size,
};

const CHAOS: &str = "poincare --gap 1 --ratio 2.7 --cart prescribed --transient 100";

#[test]
fn chaos_has_a_positive_exponent_and_a_periodic_motion_a_negative_one() {
    let chaos = answer(&format!("{CHAOS} --points 400 --lyapunov"));
    assert_eq!(chaos["regime"], "aperiodic");
    assert_eq!(chaos["meaning"], "chaotic");
    let exponent = &chaos["lyapunov"];
    // 0.31 per period over 10,000; five standard errors of 400.
    let per_period = number(exponent, "largest_per_period");
    assert!((0.2..0.4).contains(&per_period), "{per_period}");
    let steady = answer("poincare --gap 1 --ratio 1.8 --points 60 --transient 300 --lyapunov");
    assert_eq!(
        (&steady["regime"], &steady["meaning"]),
        (&"1/1".into(), &"contracting".into())
    );
}

#[test]
fn few_points_do_not_make_a_motion_aperiodic() {
    let line = "poincare --ratio 2 --points 5 --transient 0";
    assert_eq!(answer(line)["regime"], "unsettled");
    let told = Folder::new().run(line).well().out;
    assert!(
        told.contains("unsettled: it does not repeat in the 5 drive periods recorded"),
        "{told}"
    );
}

#[test]
fn sections_at_several_phases_come_with_pictures_and_tables() {
    let folder = Folder::new();
    folder
        .run(&format!(
            "{CHAOS} --points 70 --phase 0.25 --phase 0 --out a --quiet"
        ))
        .well();
    assert_eq!(folder.ends("a/"), [".csv", ".json", ".png", ".svg"]);
    let rows = csv_rows(&folder.read_made("a/poincare", ".csv"));
    let phases: Vec<_> = rows.iter().map(|r| number(r, "phase_turns")).collect();
    assert_eq!(phases, [vec![0.0; 70], vec![0.25; 70]].concat());
    for row in &rows {
        // At phase 0 the cart passes its middle; a quarter turn later it is A0 away.
        let cart = number(row, "displacement_mm") - number(row, "relative_displacement_mm");
        let wanted = if number(row, "phase_turns") == 0.0 {
            0.0
        } else {
            0.89
        };
        assert!((cart - wanted).abs() < 1e-9, "{row}");
    }
    assert_svg_shows(
        &folder.read_made("a/poincare", ".svg"),
        &["Section at drive phase 0.25 turns"],
    );
    assert!(
        png_size(&std::fs::read(folder.made("a/poincare", ".png")).expect("a picture")).0 >= 1200
    );
}

#[test]
fn the_smoothing_is_held_against_the_switch() {
    let rows = answer(&format!(
        "{CHAOS} --points 60 --against smoothed --epsilon-m 1e-6"
    ));
    let rows = rows.as_array().expect("rows").clone();
    let models: Vec<_> = rows
        .iter()
        .map(|r| r["model"].as_str().expect("a name"))
        .collect();
    assert_eq!(models, ["switch", "switch, another start", "smoothed"]);
    assert_eq!(number(&rows[0], "carried"), 0.0);
    assert!(number(&rows[2], "carried") > number(&rows[1], "carried"));
    assert!(number(&rows[2], "steps_per_period") > number(&rows[0], "steps_per_period"));
}

#[test]
fn bad_input_gets_one_line() {
    let folder = Folder::new();
    assert_refused(
        &folder,
        [
            ("", "required"),
            ("--ratio nan", "must be a positive number"),
            ("--ratio 1.5 --points 0", "--points is 0"),
            ("--ratio 1.5 --phase 1", "--phase is 1"),
            ("--ratio 1.5 --phase nan", "--phase is NaN"),
            ("--ratio 1.5 --points 5 --lyapunov", "too few"),
            ("--ratio 1.5 --epsilon-m 1e-6", "--against"),
            ("--ratio 1.5 --against smoothed", "use --cart prescribed"),
            (
                "--ratio 1.5 --points 40 --cart prescribed --against smoothed --epsilon-m 0",
                "must be a positive number",
            ),
            (
                "--ratio 1.5 --cart prescribed --against smoothed --phase 0.5",
                "leave --phase out",
            ),
            (
                "--ratio 1.5 --engine switch",
                "unexpected argument '--engine'",
            ),
        ]
        .map(|(options, said)| (format!("poincare {options} --quiet"), said)),
    );
}
