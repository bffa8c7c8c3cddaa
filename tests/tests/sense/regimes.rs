//! The measured regime: right with noise, deaf to one lost contact, quick after a change.

use shared::model::params::{RigParams, WIRES};
use shared::model::regime::Regime;
use shared::settings::Settings;

use crate::rig::{REAL, Sensors};
use crate::watch;

const POINTS: [(f64, (u16, u8)); 3] = [(1.5, (1, 1)), (2.7, (2, 2)), (3.8, (1, 2))];

#[test]
fn regimes_are_told_through_noise_from_the_first_answer_on() {
    let settings = Settings::for_rig(&WIRES);
    for (ratio, (p, n)) in POINTS {
        let seen = watch(&settings, &WIRES, ratio, &REAL);
        // 4 periods for n = 1, 6 for n = 2. The first strobe opens the window, one period passes until the
        // cart is known, and a period is booked a quarter turn after its cut.
        let needed = 4_usize.max(3 * usize::from(n)) + 3;
        for measured in seen.measured.iter().skip(needed) {
            assert!(measured.regime.is(p, n), "{ratio}: {measured:?}");
        }
        assert_eq!(seen.measured.last().unwrap().periods, 16);
    }
}

#[test]
fn one_lost_contact_changes_nothing() {
    let settings = Settings::for_rig(&WIRES);
    for (ratio, (p, n)) in POINTS {
        let sensors = Sensors {
            dropped: Some(25),
            ..REAL
        };
        let seen = watch(&settings, &WIRES, ratio, &sensors);
        assert_eq!(seen.pulses.len() + 1, seen.recording.contacts.len());
        for measured in seen.measured.iter().skip(18) {
            assert!(measured.regime.is(p, n), "{ratio}: {measured:?}");
        }
    }
}

#[test]
fn a_hammer_that_does_not_strike_is_none() {
    let settings = Settings::for_rig(&WIRES);
    let far = RigParams {
        gap_m: 5e-3,
        ..WIRES
    };
    let seen = watch(&settings, &far, 3.0, &REAL);
    assert!(seen.recording.contacts.is_empty());
    for measured in &seen.measured {
        assert_eq!(measured.regime, Regime::None);
    }
}
