//! Healthy rigs drawn at random: nothing is told of them, and they hold soon.

use emulator::trials::long::{Campaign, LongTrial};
use emulator::trials::{Believed, Distribution, run_all};
use numerics::NamedRig;
use rayon::prelude::*;

fn presets() -> Vec<Believed> {
    NamedRig::presets().iter().map(Believed::new).collect()
}

fn least(share: Option<f64>) -> f64 {
    share.unwrap_or(0.0)
}

#[test]
fn random_rigs_hold_within_ten_seconds() {
    let count = super::some(20, 0..200).len();
    let outcomes = run_all(49, count as u32, &presets(), 20.0, &()).unwrap();
    let all = Distribution::of(&outcomes);
    assert_eq!((all.held, all.faults, all.lost), (count, 0, 0), "{all:?}");
    assert!(all.hold_last_s.is_some_and(|s| s <= 10.0), "{all:?}");
    assert!(least(all.share_worst) > 0.98, "{all:?}");
}

/// Ten minutes in which natural frequency, lags and gains drift. (Trials 11 and 27 were told false faults: momentum did not allow for
/// displacements 1 ms later than the force, and noise of the hammer's sensor drew away the lag that is learnt.)
#[test]
fn drifts_of_ten_minutes_are_followed() {
    let numbers = if super::is_long() {
        (0..40).collect()
    } else {
        vec![27]
    };
    let rigs = presets();
    let run = |number| LongTrial::draw(49, number, &rigs).run(600.0).unwrap();
    let rows: Vec<_> = numbers.into_par_iter().map(run).collect();
    let all = Campaign::of(&rows);
    assert_eq!((all.false_trips, all.lost), (0, 0), "{all:?}");
    assert!(least(all.share_worst) > 0.98, "{all:?}");
    assert!(all.largest_force_over_limit < 1.05, "{all:?}");
}
