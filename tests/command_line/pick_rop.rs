//! `host-sim pick --objective rop`: held to `drill`, which searches runs from rest where this follows orbits.

use serde_json::Value;

use crate::support::{Folder, answer, assert_refused, csv_rows, keys, number, pair};

#[test]
fn it_picks_where_drill_drills_fastest_and_says_what_every_pick_says() {
    let folder = Folder::new();
    let line =
        "pick --objective rop --threshold-n 50 --nominal --cart prescribed --out out --format csv";
    let row = csv_rows(&folder.run(line).well().out);
    let picked: Value = serde_json::from_str(&folder.read_made("out/pick", ".json")).unwrap();
    let ends = ["-curve.csv", ".json", ".png", ".svg"];
    assert_eq!(folder.ends("out/pick"), ends);
    let drilled = answer(
        "drill --threshold-n 50 --cart prescribed --ratio 1.96:2.12:0.04 --settle 120 --threshold-percent 0 --ground-stiffness-percent 0",
    );
    let best = &drilled["advice"]["best"];
    // The rate is flat at its best; the rest moves with the frequency, which `drill` finds to 2e-4.
    for (key, within) in [
        ("rate_of_penetration_um_per_s", 1e-6),
        ("progress_per_blow_um", 2e-4),
        ("energy_per_blow_mj", 2e-4),
        ("share_into_progress", 2e-4),
        ("feed_needed_mm_per_s", 1e-6),
        ("force_n", 1e-9),
        ("frequency_ratio", 2e-4),
    ] {
        let apart = number(&picked, key) / number(best, key) - 1.0;
        assert!(apart.abs() < within, "{key}: {apart}");
        assert_eq!(number(&row[0], key), number(&picked, key), "{key}");
    }
    let rigid = number(&drilled["advice"], "rigid_frequency_hz");
    assert!((number(&picked, "force_optimum_hz") / rigid - 1.0).abs() < 1e-6);
    // Nothing that a pick says is missing.
    let usual = answer("pick --nominal --cart prescribed");
    let (told, usual) = (keys(&picked), keys(&usual));
    let missing: Vec<_> = usual.iter().filter(|key| !told.contains(key)).collect();
    assert!(missing.is_empty(), "{missing:?}");
    let [low, high] = pair(&picked, "safe_band_hz");
    let at = number(&picked, "operating_frequency_hz");
    assert!(low < at && at < high);
    assert_eq!(picked["objective"], "rop");
    assert_eq!(picked["regime"], "1/1");
}

#[test]
fn over_the_uncertainty_of_rig_and_ground_its_bands_and_rates_are_spread() {
    let line =
        "pick --objective rop --threshold-n 25 --samples 4 --gap-tolerance-mm 0 --cart prescribed";
    let a = answer(line);
    assert_eq!(a["corners"], 16);
    let rate = number(&a, "rate_of_penetration_um_per_s");
    let (worst, largest) = (
        number(&a, "rate_worst_um_per_s"),
        number(&a, "rate_largest_um_per_s"),
    );
    // The ground alone makes 63 to 100 of 78 µm/s.
    assert!(
        worst < 0.8 * rate && largest > 1.28 * rate,
        "{worst} {largest}"
    );
    let [safe, band, stable] =
        ["safe_band_hz", "band_hz", "stable_one_one_hz"].map(|k| pair(&a, k));
    assert!(stable[0] <= band[0] && band[0] <= safe[0]);
    assert!(safe[1] <= band[1] && band[1] <= stable[1]);
    assert_eq!(a["rate_sensitivity"][0]["parameter"], "threshold_n");
}

#[test]
fn a_limit_moves_it_and_is_named() {
    let a = answer(
        "pick --objective rop --threshold-n 50 --nominal --cart prescribed --max-frequency-hz 3.6",
    );
    let at = number(&a, "operating_frequency_hz");
    assert!((at - 3.6).abs() < 1e-6, "{at}");
    let limit = &a["limits"][0];
    assert_eq!(limit["name"], "max_frequency_hz");
    assert_eq!(limit["binds"], true);
}

/// 0.7 N cannot move the cart at 0.89 mm at any frequency at which the 1/1 is stable.
#[test]
fn the_amplitude_is_lowered_where_the_shaker_is_too_weak() {
    let line = "pick --objective rop --threshold-n 5 --nominal --cart prescribed";
    let a = answer(&format!("{line} --max-shaker-force-n 0.7"));
    assert_eq!(a["amplitude_lowered"], true);
    assert!(number(&a, "amplitude_mm") < 0.5);
    let needs = a["shaker"]["force_n"].as_f64().unwrap();
    assert!((0.5..=0.7).contains(&needs), "{needs}");
    assert!(number(&a, "rate_of_penetration_um_per_s") > 0.0);
}

#[test]
fn what_cannot_be_is_refused_in_one_line() {
    assert_refused(
        &Folder::new(),
        [
            ("pick --objective rop", "--threshold-n"),
            ("pick --threshold-n 25", "--objective rop"),
            (
                "pick --objective rop --threshold-n 25 --all",
                "--all cannot be used with --objective rop",
            ),
            (
                "pick --objective rop --threshold-n 25 --beside beam-170",
                "--beside cannot be used with --objective rop",
            ),
            (
                "pick --objective rop --threshold-n 25 --gap 0:1:0.5",
                "--objective rop is for one rig at one gap",
            ),
            (
                "pick --objective rop --threshold-n 25 --report r.html",
                "--report cannot be used with --objective rop",
            ),
            (
                "pick --objective rop --threshold-n 25 --rig beam-170 --springs-mass 0.3",
                "one bending mode",
            ),
            (
                "pick --bit-mass-kg 0.1",
                "--bit-mass-kg is for --objective rop",
            ),
            (
                "pick --objective rop --threshold-n 1e6 --nominal --cart prescribed",
                "the ground holds at every frequency",
            ),
            (
                "pick --objective rop --threshold-n 25 --nominal --cart prescribed --max-shaker-force-n 0.1",
                "the nearest that can be kept: max_shaker_force_n = 0.9",
            ),
        ],
    );
}
