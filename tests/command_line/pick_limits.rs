//! `host-sim pick` with limits and other uncertainties.

use serde_json::Value;

use crate::support::{Folder, answer, number};

fn limit<'a>(answer: &'a Value, name: &str) -> &'a Value {
    let limits = answer["limits"].as_array().expect("limits");
    let found = limits.iter().find(|limit| limit["name"] == name);
    found.unwrap_or_else(|| panic!("{name} is not named in {answer}"))
}

/// The limit `name` = `value` is respected by the quantity `used`, to a hair reached by it, and named.
fn assert_decides(answer: &Value, name: &str, value: f64, used: f64) {
    assert!(
        used <= value * (1.0 + 1e-9) && used > 0.999 * value,
        "{name}: {used} of {value}"
    );
    let said = limit(answer, name);
    assert_eq!(
        (&said["limit"], &said["binds"]),
        (&value.into(), &true.into())
    );
    let why = answer["why"].as_str().expect("a sentence");
    assert!(why.contains(name), "{why}");
    assert!(number(answer, "force_n") < 0.99 * 96.0);
    assert_eq!(answer["regime"], "1/1");
}

#[test]
fn a_force_limit_is_kept() {
    let a = answer("pick --nominal --max-force-n 70");
    assert_decides(&a, "max_force_n", 70.0, number(&a, "force_n"));
}

#[test]
fn a_force_limit_is_kept_by_every_rig_within_the_uncertainty() {
    let a = answer("pick --samples 0 --max-force-n 70");
    let weight = number(&a, "force_n") / number(&a, "force_ratio");
    let largest = number(&a, "force_ratio_largest") * weight;
    assert_decides(&a, "max_force_n", 70.0, largest);
    assert!(number(&a, "force_n") < 0.9 * 70.0);
}

#[test]
fn a_frequency_limit_is_kept() {
    let a = answer("pick --nominal --max-frequency-hz 3");
    assert_decides(
        &a,
        "max_frequency_hz",
        3.0,
        number(&a, "operating_frequency_hz"),
    );
    let [low, high] = [0, 1].map(|i| a["safe_band_hz"][i].as_f64().expect("a number"));
    assert!(low < 3.0 && high <= 3.0, "{low} to {high}");
}

#[test]
fn the_safe_band_keeps_a_force_limit_for_every_rig_within_the_uncertainty() {
    let a = answer("pick --max-force-n 70 --samples 8");
    let hz = a["safe_band_hz"][1].as_f64().expect("a number");
    // At its upper end the strongest rig of the default uncertainty is at the limit, the nominal below.
    assert!((hz - number(&a, "operating_frequency_hz")).abs() < 1e-5 * hz);
    let weight = number(&a, "force_n") / number(&a, "force_ratio");
    let largest = number(&a, "force_ratio_largest") * weight;
    assert!(largest <= 70.0 && largest > 69.99, "{largest}");
}

#[test]
fn a_drive_force_limit_is_kept() {
    let a = answer("pick --nominal --cart prescribed --max-shaker-force-n 2");
    assert_decides(
        &a,
        "max_shaker_force_n",
        2.0,
        number(&a["shaker"], "force_n"),
    );
}

#[test]
fn of_three_limits_the_one_that_decides_is_named_and_the_loose_ones_do_not_bind() {
    let a =
        answer("pick --nominal --max-frequency-hz 3.2 --max-force-n 500 --max-shaker-force-n 50");
    assert_eq!(number(&a, "operating_frequency_hz"), 3.2);
    assert_eq!(limit(&a, "max_frequency_hz")["binds"], true);
    for loose in ["max_force_n", "max_shaker_force_n"] {
        assert_eq!(limit(&a, loose)["binds"], false, "{loose}");
    }
}

#[test]
fn nominal_takes_the_parameters_as_exact() {
    let a = answer("pick --nominal");
    assert_eq!(a["uncertainty"], Value::Null);
    assert_eq!(a["force_ratio_worst"], a["force_ratio"]);
    assert_eq!(a["operating_frequency_hz"], a["nominal_optimum_hz"]);
    assert_eq!(a["robust_band_hz"], a["stable_one_one_hz"]);
    assert_eq!(a["safe_band_hz"], a["band_hz"]);
}

#[test]
fn a_large_gap_is_told_for_what_it_is() {
    let a = answer("pick --gap 2.4 --samples 8");
    assert_eq!(a["jump_free"], false);
    // The choice is against the edge of what every rig of the uncertainty can do, and is said to be.
    let uncertainty = &a["limits"][0];
    assert_eq!(uncertainty["name"], "the uncertainty");
    assert_eq!(uncertainty["binds"], true);
    // It keeps a reserve from that edge.
    assert_eq!(limit(&a, "the reserve of 1 %")["binds"], true);
    let top = a["robust_band_hz"][1].as_f64().expect("a number");
    assert!((0.99 * top - number(&a, "operating_frequency_hz")).abs() < 1e-5 * top);
    // Where the band is too narrow for that, it says so, and runs in the middle.
    let narrow = answer("pick --gap 2.5 --natural-frequency-percent 21 --samples 0");
    assert_eq!(limit(&narrow, "a reserve of less than 1 %")["binds"], true);
    let band = |i: usize| narrow["robust_band_hz"][i].as_f64().expect("a number");
    let middle = 0.5 * (band(0) + band(1));
    assert!((number(&narrow, "operating_frequency_hz") - middle).abs() < 1e-6 * middle);
    assert!(band(1) < 1.02 * band(0));
    // Not every corner of a cart that does not recoil gets there from rest: 31 of 32.
    let not_reaching =
        |a: &Value| number(a, "corners") - number(a, "corners_reaching_one_one_from_rest");
    assert_eq!(not_reaching(&a), 0.0);
    let prescribed = answer("pick --gap 2.4 --samples 0 --cart prescribed");
    assert_eq!(not_reaching(&prescribed), 1.0);
}

/// A force at which the rig's own amplitude can be run at no frequency: the amplitude is lowered until its strongest
/// frequency can be, and the answer says so.
#[test]
fn a_drive_force_limit_that_no_frequency_keeps_lowers_the_amplitude() {
    let a = answer("pick --nominal --cart prescribed --max-shaker-force-n 0.5");
    assert_eq!(a["amplitude_lowered"], true);
    let amplitude = number(&a, "amplitude_mm");
    assert!(amplitude < 0.3, "{amplitude}");
    let drive = number(&a["shaker"], "force_n");
    assert!(drive <= 0.5 && drive > 0.4, "{drive}");
    let [_, high] = [0, 1].map(|i| a["safe_band_hz"][i].as_f64().expect("a number"));
    assert!(high > 1.03 * number(&a, "operating_frequency_hz"), "{a}");
    // At no gap forces go with the amplitude, but for what a pendulum differs from a spring (0.1 %).
    let whole = answer("pick --nominal --cart prescribed");
    assert_eq!(whole["amplitude_lowered"], false);
    let [lower, full] = [&a, &whole].map(|a| number(a, "force_n") / number(a, "amplitude_mm"));
    assert!((lower / full - 1.0).abs() < 2e-3, "{lower} {full}");
    let text = Folder::new()
        .run("pick --nominal --cart prescribed --max-shaker-force-n 0.5")
        .well()
        .out;
    assert!(
        text.contains("lowered: at the rig's amplitude no frequency keeps"),
        "{text}"
    );
}

/// The loop of the assumed shaker gives some 17 N at the wires, most of it against the recoil.
#[test]
fn what_the_shaker_can_give_limits_the_answer_and_lowers_the_amplitude_where_it_must() {
    let free = answer("pick --nominal");
    let needed = number(&free["shaker"], "loop_force_n");
    assert!(
        needed > 2.0 * number(&free["shaker"], "force_n"),
        "{needed}"
    );
    let loose = limit(&free, "shaker_max_force_n");
    assert_eq!(
        (&loose["limit"], &loose["binds"]),
        (&200.0.into(), &false.into())
    );
    let with = |share: f64| {
        let most = share * needed;
        let a = answer(&format!("pick --nominal --set shaker_max_force_n={most}"));
        assert!(
            number(&a["shaker"], "loop_force_n") <= most * (1.0 + 1e-6),
            "{a}"
        );
        a
    };
    let less = with(0.8);
    assert_eq!(limit(&less, "shaker_max_force_n")["binds"], true);
    assert_eq!(less["amplitude_lowered"], false);
    let [moved, best] = [&less, &free].map(|a| number(a, "operating_frequency_hz"));
    assert!((moved / best - 1.0).abs() > 0.02, "{moved} {best}");
    let little = with(0.1);
    assert_eq!(little["amplitude_lowered"], true);
    assert!(number(&little, "amplitude_mm") < 0.2);
    // The option says the same, and whether that shaker can do it.
    for (share, same, said) in [
        (
            2.0,
            &free,
            "shaker enough      yes, for the nominal rig: it needs ",
        ),
        (0.8, &less, "shaker enough      no, not at "),
        (
            0.1,
            &little,
            "shaker enough      no, not at the rig's amplitude",
        ),
    ] {
        let folder = Folder::new();
        let line = format!("pick --nominal --max-shaker-force-n {}", share * needed);
        let text = folder.run(&line).well().out;
        let a: Value = serde_json::from_str(&folder.read_made("out/", ".json")).unwrap();
        for key in ["operating_frequency_hz", "amplitude_mm", "force_n"] {
            assert_eq!(a[key], same[key], "{share}: {key}");
        }
        assert!(text.contains(said), "{text}");
        // A lowered stroke is said first, and that the shaker decided it.
        let lowered =
            text.contains("lower the stroke to ") && text.contains(": decides, by the stroke");
        assert_eq!(lowered, share == 0.1, "{text}");
    }
    // 200 N are assumed for a preset: nobody gave them.
    let text = Folder::new().run("pick --nominal").well().out;
    assert!(!text.contains("shaker_max_force_n"), "{text}");
    // The same 200 N stated in a rig file are no assumption.
    let mine = "preset = \"wires\"\nshaker_max_force_n = 200\n";
    let mine = Folder::new().with("mine.toml", mine);
    let text = mine.run("pick --nominal --rig mine.toml").well().out;
    assert!(text.contains("shaker enough      yes"), "{text}");
    assert!(
        text.contains("shaker_max_force_n = 200: does not decide"),
        "{text}"
    );
}

/// At no gap the force goes with the amplitude, but for what a pendulum differs from a spring (0.1 %).
#[test]
fn the_stroke_for_a_force_is_found() {
    let free = answer("pick --nominal");
    let wanted = 1.5 * number(&free, "force_n");
    let a = answer(&format!("pick --nominal --want-force-n {wanted}"));
    assert!((number(&a, "force_n") / wanted - 1.0).abs() < 1e-4, "{a}");
    let times = number(&a, "amplitude_mm") / number(&free, "amplitude_mm");
    assert!((times / 1.5 - 1.0).abs() < 2e-3, "{times}");
    let [at, best] = [&a, &free].map(|a| number(a, "operating_frequency_hz"));
    assert!((at / best - 1.0).abs() < 2e-3, "{at} {best}");
    let folder = Folder::new();
    let text = folder.run("pick --nominal --gap 1 --want-force-n 150 --max-shaker-force-n 5");
    let text = text.well().out;
    assert!(
        text.contains("for 150 N, give it ") && text.contains(" mm of stroke"),
        "{text}"
    );
    assert!(text.contains("force              150.0"), "{text}");
    assert!(text.contains("shaker enough      no: it needs "), "{text}");
    let picture = folder.read_made("out/pick", ".svg");
    assert!(picture.contains(" mm of stroke; the shaker cannot: it needs "));
    // However small, the stroke is not none.
    let tiny = folder.run("pick --nominal --want-force-n 0.001").well().out;
    assert!(tiny.contains("for 0.001 N, give it 0.0000"), "{tiny}");
    let refused = folder.run("pick --want-force-n 150 --max-force-n 100");
    assert_eq!(refused.code, Some(2));
    assert!(refused.err.contains("--max-force-n"), "{refused:?}");
}

/// In the safe band of one mode, five modes have 81 to 82 % of the force at 8.60 and 9.45 Hz (prescribed cart).
#[test]
fn the_safe_band_of_beams_leaves_out_where_several_modes_are_weak() {
    let a = answer("pick --rig beam-170 --cart prescribed --samples 8");
    let band = |key: &str| [0, 1].map(|i| a[key][i].as_f64().expect("a number"));
    let (one, safe) = (band("one_mode_safe_band_hz"), band("safe_band_hz"));
    for hz in [8.60, 9.45] {
        assert!(one[0] < hz && hz < one[1], "{one:?}");
        assert!(hz < safe[0] || safe[1] < hz, "{safe:?}");
    }
    let seen = answer(
        "modes --rig beam-170 --cart prescribed --frequency 8.6:9.45:0.85 --modes 5 --cycles 400 --transient 380",
    );
    let rows = seen["rows"].as_array().expect("rows");
    let at = number(&a, "modes_force_ratio");
    for row in rows {
        let share = number(row, "force_ratio") / at;
        assert!((0.80..0.83).contains(&share), "{share}: {row}");
    }
    // The modes' own engine has the force of the answer, too, within what the modes left out change.
    let hz = number(&a, "operating_frequency_hz");
    let there = answer(&format!(
        "modes --rig beam-170 --cart prescribed --frequency {hz:?} --modes 5 --cycles 400 --transient 380"
    ));
    let five = number(&there["rows"][0], "force_ratio");
    assert!((at / five - 1.0).abs() < 0.01, "{at} {five}");
    // Over the springs' mass the weak frequencies move through the band, and the answer says so.
    assert!(number(&a, "safe_band_force_share_any_springs") < 0.9);
    assert!(number(&a, "modes_force_ratio_worst") < number(&a, "modes_force_ratio"));
}

/// A shaker that decides the frequency: it stands at the lower end of its band, and the carts are compared without it.
#[test]
fn an_edge_below_is_named_and_a_limited_optimum_is_not_compared_with_a_free_one() {
    let line = "pick --nominal --set shaker_max_force_n=6";
    let limited = answer(line);
    assert_eq!(limit(&limited, "shaker_max_force_n")["binds"], true);
    assert!(number(&limited, "margin_below_percent") < 0.5);
    assert!(number(&limited, "margin_above_percent") > 2.0);
    let free = answer("pick --nominal");
    for key in ["recoil_force_ratio", "prescribed_force_ratio"] {
        let apart = number(&limited, key) / number(&free, key) - 1.0;
        assert!(apart.abs() < 1e-6, "{key}: {apart}");
    }
    let text = Folder::new().run(line).well().out;
    assert!(text.contains("no margin below"), "{text}");
    assert!(!text.contains("no margin above"), "{text}");
    assert!(
        text.contains("(+10.6 % of force; both carts nominal and without a limit of the shaker"),
        "{text}"
    );
    let above = Folder::new()
        .run("pick --nominal --max-frequency-hz 3")
        .well()
        .out;
    assert!(
        above.contains("no margin above") && !above.contains("no margin below"),
        "{above}"
    );
}
