//! `host-sim drill`.

use crate::support::{Folder, answer, assert_refused, assert_svg_shows, csv_rows, number};

/// A narrow range: a dozen runs and the corners.
const NARROW: &str = "--ratio 1.96:2.12:0.04 --settle 120";

#[test]
fn it_says_where_the_rate_is_largest_and_what_the_rigid_pick_has_of_it() {
    let told = answer(&format!(
        "drill --threshold-n 25 {NARROW} --cart prescribed"
    ));
    let advice = &told["advice"];
    let best = &advice["best"];
    let rate = number(best, "rate_of_penetration_um_per_s");
    // An independent sketch has 77.7 µm/s at a ratio of 2.04 to 2.08.
    assert!((rate / 77.7 - 1.0).abs() < 0.01, "{rate}");
    let ratio = number(best, "frequency_ratio");
    assert!((2.04..2.10).contains(&ratio), "{ratio}");
    assert_eq!(best["regime"], "1/1");
    let share = number(advice, "rigid_share");
    assert!((0.97..0.99).contains(&share), "{share}");
    assert!((number(advice, "rigid_frequency_ratio") - 2.013).abs() < 2e-3);
    assert!((number(best, "force_n") - 25.0).abs() < 1e-9);
    let feed = 1e3 * number(best, "feed_needed_mm_per_s");
    assert!((feed / rate - 1.0).abs() < 1e-9);
    assert_eq!(advice["corners"].as_array().map(Vec::len), Some(4));
    assert_eq!(told["cart"], "prescribed");
    let recoil = number(advice, "recoil_rate_um_per_s");
    assert!((0.83..0.86).contains(&(recoil / rate)), "{recoil} {rate}");
}

#[test]
fn the_cart_recoils_where_its_shaker_is_known() {
    let told = answer(&format!("drill --threshold-n 25 {NARROW}"));
    let advice = &told["advice"];
    assert_eq!(told["cart"], "recoil");
    let rate = number(&advice["best"], "rate_of_penetration_um_per_s");
    assert_eq!(number(advice, "recoil_rate_um_per_s"), rate);
    let prescribed = number(advice, "prescribed_rate_um_per_s");
    // The sketch's, with a prescribed cart.
    assert!((prescribed / 77.7 - 1.0).abs() < 0.01, "{prescribed}");
    assert!((0.83..0.86).contains(&(rate / prescribed)), "{rate}");
}

#[test]
fn more_gaps_give_a_map_and_a_row_each() {
    let folder = Folder::new();
    let line = format!("drill --threshold-n 25 --gap 0:1:1 {NARROW} --format csv --out out");
    let rows = csv_rows(&folder.run(&line).well().out);
    assert_eq!(rows.len(), 10);
    let (near, far) = (&rows[2], &rows[7]);
    assert_eq!(number(far, "gap_mm"), 1.0);
    let rate = |row| number(row, "rate_of_penetration_um_per_s");
    // At the frequency that is best at 0 mm, a gap of 1 mm drills far less.
    assert!(rate(far) < 0.5 * rate(near), "{near} {far}");
    let ends = ["-map.png", "-map.svg", ".csv", ".json", ".png", ".svg"];
    assert_eq!(folder.ends("out/drill"), ends);
    assert_svg_shows(
        &folder.read_made("out/drill", ".svg"),
        &["rate of penetration, µm/s", "no force passes it"],
    );
    assert_svg_shows(
        &folder.read_made("out/drill", "-map.svg"),
        &["progress per cycle, µm"],
    );
}

#[test]
fn the_published_oscillator_repeats_after_two_periods_where_its_authors_say_so() {
    let told = answer("drill --published --static-force 0.09:0.11:0.005");
    let rows = told["rows"].as_array().unwrap();
    let there = rows.iter().find(|r| number(r, "b") == 0.1).unwrap();
    assert_eq!(there["periods"], 2);
}

#[test]
fn the_points_of_the_published_diagram_are_a_table() {
    let folder = Folder::new();
    let line = "drill --published --static-force 0.14:0.15:0.01 --settle 50 --out out";
    folder.run(line).well();
    let made = folder.read_made("out/drill", "-points.csv");
    let rows = csv_rows(&made);
    assert_eq!(rows.len(), 2 * 64);
    assert!(number(&rows[0], "b") == 0.14 && number(&rows[127], "b") == 0.15);
    // One period: one point.
    let apart = number(&rows[0], "p") - number(&rows[63], "p");
    assert!(apart.abs() < 1e-3, "{apart}");
}

#[test]
fn what_cannot_be_is_refused_in_one_line() {
    assert_refused(
        &Folder::new(),
        [
            ("drill", "--threshold-n"),
            ("drill --threshold-n 0", "threshold_n is 0"),
            ("drill --threshold-n nan", "threshold_n is NaN"),
            (
                "drill --threshold-n 25 --ground-damping-n-s-per-m -1",
                "ground_damping_n_s_per_m is -1",
            ),
            (
                "drill --threshold-n 25 --threshold-percent 100",
                "from 0 to below 100",
            ),
            ("drill --threshold-n 25 --feed up", "a speed from 0 to 1000"),
            (
                "drill --threshold-n 1e6 --ratio 2:2.1:0.1 --settle 50",
                "the ground holds at every frequency",
            ),
            (
                "drill --threshold-n 25 --set contact_law=hertz --set contact_stiffness_n_per_m=1e9 --set contact_exponent=1.5",
                "--ground-stiffness-n-per-m",
            ),
            (
                "drill --published --static-force 0:0.1:0.1",
                "not between 0 and 1",
            ),
            ("drill --published --threshold-n 3", "cannot be used with"),
            (
                "drill --threshold-n 25 --bit-mass-kg 0",
                "bit_mass_kg is 0, must be a positive number",
            ),
            (
                "drill --threshold-n 25 --bit-feed-force-n 3",
                "give its mass with --bit-mass-kg",
            ),
            (
                "drill --threshold-n 25 --bit-mass-kg 0.1 --bit-feed-force-n 25",
                "bit_feed_force_n is 25",
            ),
        ],
    );
}

#[test]
fn a_bit_between_hammer_and_ground_takes_its_share() {
    let told = answer(
        "drill --rig beam-170 --threshold-n 50 --bit-mass-kg 0.3 --cart prescribed --ratio 2:2.08:0.08 --settle 30 --threshold-percent 0 --ground-stiffness-percent 0",
    );
    let bit = &told["bit"];
    assert_eq!(number(bit, "bit_mass_kg"), 0.3);
    assert!((number(bit, "bit_feed_force_n") - 0.3 * 9.81).abs() < 1e-9);
    let advice = &told["advice"];
    let best = &advice["best"];
    assert_eq!(best["regime"], "1/1");
    // The hammer is struck harder than the ground can press back.
    assert!((number(best, "ground_force_n") - 50.0).abs() < 1e-9);
    assert!(number(best, "force_n") > 100.0);
    let (taken, given) = (
        number(best, "energy_per_blow_mj"),
        number(best, "ground_energy_per_blow_mj"),
    );
    assert!(
        0.3 * taken < given && given < 0.9 * taken,
        "{given} {taken}"
    );
    let (with, without) = (
        number(best, "rate_of_penetration_um_per_s"),
        number(advice, "without_bit_rate_um_per_s"),
    );
    assert!(
        0.3 * without < with && with < 0.8 * without,
        "{with} {without}"
    );
}

/// What is asked for ends before the optimum, on every ground and with every cart.
#[test]
fn an_optimum_at_the_end_of_the_range_is_said_to_be_there() {
    let line = "drill --threshold-n 25 --ratio 1.3:1.5:0.1 --settle 60 --threshold-percent 0 --ground-stiffness-percent 0";
    let told = Folder::new().run(line).well().out;
    for words in [
        "(1.500 times the natural frequency, the end of the range)",
        "34.7 % higher; there the rate is 385.5 % of that here",
        "Hz, outside the range (+",
        "(partly or wholly outside the range)",
    ] {
        assert!(told.contains(words), "{words}: {told}");
    }
}

/// The best of all motions is no less than the best of one of them.
#[test]
fn no_gap_has_less_with_any_motion_than_with_one() {
    let told = answer(
        "drill --threshold-n 25 --gap 0:1:1 --ratio 2:2.5:0.25 --settle 60 --threshold-percent 0 --ground-stiffness-percent 0",
    );
    let rates = |key: &str| {
        let rows = told[key].as_array().expect("rows");
        let rates = rows
            .iter()
            .map(|r| number(r, "rate_of_penetration_um_per_s"));
        rates.collect::<Vec<_>>()
    };
    let (ones, any) = (rates("gaps"), rates("gaps_any_regime"));
    assert!(
        ones.iter().zip(&any).all(|(one, any)| any >= one),
        "{ones:?} {any:?}"
    );
}

#[test]
fn the_fastest_one_one_and_the_fastest_of_all_stand_side_by_side() {
    let folder = Folder::new();
    let line = "drill --threshold-n 25 --ratio 2.05:4:1.95 --settle 60 --threshold-percent 0 --ground-stiffness-percent 0";
    let ran = folder.run(&format!("{line} --out out")).well();
    let head: Vec<&str> = ran.out.lines().take(2).collect();
    assert!(head[0].contains("drills fastest on 1/1 at"), "{head:?}");
    assert!(head[1].starts_with("fastest of all: 1/2 at"), "{head:?}");
    let told = folder.read_made("out/drill", ".json");
    let told: serde_json::Value = serde_json::from_str(&told).unwrap();
    assert_eq!(told["fastest_of_all"]["regime"], "1/2");
    let rate = |row| number(row, "rate_of_penetration_um_per_s");
    assert!(rate(&told["fastest_of_all"]) > 1.5 * rate(&told["advice"]["best"]));
    assert_svg_shows(
        &folder.read_made("out/drill", ".svg"),
        &["fastest 1/1", "fastest of all"],
    );
    // Where nothing is faster it is said once.
    let narrow = folder
        .run(&format!("drill --threshold-n 25 {NARROW}"))
        .well();
    assert!(
        narrow.out.contains("drills fastest of all on 1/1 at"),
        "{narrow:?}"
    );
    assert!(!narrow.out.contains("fastest of all:"), "{narrow:?}");
}
