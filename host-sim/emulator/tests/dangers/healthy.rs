//! Healthy rigs drawn at random: nothing is told of them, and they hold soon.

use emulator::trials::long::{self, Campaign};
use emulator::trials::{Believed, Distribution, RIGS, run_all};
use numerics::NamedRig;

fn presets() -> Vec<Believed> {
    let rig = |name| Believed::new(&NamedRig::preset(name).unwrap());
    RIGS.map(rig).to_vec()
}

fn least(share: Option<f64>) -> f64 {
    share.unwrap_or(0.0)
}

#[test]
fn random_rigs_hold_within_ten_seconds() {
    let count = super::some(10, 0..200).len();
    let outcomes = run_all(49, count as u32, &presets(), 20.0, &()).unwrap();
    let all = Distribution::of(&outcomes);
    assert_eq!((all.held, all.faults, all.lost), (count, 0, 0), "{all:?}");
    assert!(all.hold_last_s.is_some_and(|s| s <= 10.0), "{all:?}");
    assert!(least(all.share_worst) > 0.98, "{all:?}");
}

/// Ten minutes in which natural frequency, lags and gains drift.
#[test]
fn drifts_of_ten_minutes_are_followed() {
    let count = super::some(20, 0..40).len();
    let rows = long::run_all(49, count as u32, &presets(), 600.0, &()).unwrap();
    let all = Campaign::of(&rows);
    assert_eq!((all.false_trips, all.lost), (0, 0), "{all:?}");
    assert!(least(all.share_worst) > 0.98, "{all:?}");
    assert!(all.largest_force_over_limit < 1.05, "{all:?}");
}
