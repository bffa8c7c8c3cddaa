//! `host-sim pick` with limits and other uncertainties.

use serde_json::Value;

use crate::support::{answer, number};

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
    let a = answer("pick --nominal --max-drive-force-n 2");
    assert_decides(
        &a,
        "max_drive_force_n",
        2.0,
        number(&a["shaker"], "force_n"),
    );
}

#[test]
fn of_three_limits_the_one_that_decides_is_named_and_the_loose_ones_do_not_bind() {
    let a =
        answer("pick --nominal --max-frequency-hz 3.2 --max-force-n 500 --max-drive-force-n 50");
    assert_eq!(number(&a, "operating_frequency_hz"), 3.2);
    assert_eq!(limit(&a, "max_frequency_hz")["binds"], true);
    for loose in ["max_force_n", "max_drive_force_n"] {
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
    let top = a["safe_band_hz"][1].as_f64().expect("a number");
    assert!((top - number(&a, "operating_frequency_hz")).abs() < 1e-5 * top);
    // Not every corner of it gets there from rest.
    let reaching = number(&a, "corners_reaching_one_one_from_rest");
    assert!(reaching < number(&a, "corners"), "{reaching}");
}
