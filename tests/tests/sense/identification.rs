//! What the rig tells of itself, with true parameters that differ from what is believed.

use shared::model::contact::Law;
use shared::model::params::{BEAM_150, RigParams, WIRES};
use shared::sense::identification::{Estimates, OnlineEstimate};
use shared::settings::Settings;

use crate::rig::{REAL, Ring, Sensors};
use crate::watch;

fn off(estimate: Option<OnlineEstimate>, truth: f64) -> f64 {
    f64::from(estimate.expect("told").value) / truth - 1.0
}

fn contact_scaled(rig: &RigParams, factor: f64) -> RigParams {
    RigParams {
        contact: Law::SpringDashpot {
            stiffness: 5.5e6 * factor,
            damping: 1.2e3 * factor,
        },
        ..*rig
    }
}

fn identified(rig: &RigParams, believed: &RigParams, ratio: f64, ring: Ring) -> Estimates {
    let settings = Settings::for_rig(believed);
    let seen = watch(&settings, rig, ratio, &Sensors { ring, ..REAL });
    assert_eq!(seen.identify.refused(), 0);
    seen.identify.estimates()
}

#[test]
fn natural_frequency_is_within_two_percent() {
    for rig in [WIRES, BEAM_150] {
        for (factor, ratio) in [(0.9, 1.6), (1.1, 1.5), (1.1, 2.4)] {
            let truth = rig.with_natural_frequency_scaled(factor);
            let found = identified(&truth, &rig, ratio, Ring::Late);
            let off = off(found.natural_hz, truth.natural_frequency_hz());
            assert!(off.abs() < 0.02, "{factor} {ratio}: {off}");
        }
    }
    // At the large strokes of 1/2 (7 mm on wires of 75 mm) the pendulum's period is longer.
    let found = identified(&WIRES, &WIRES, 3.8, Ring::Late);
    assert!(off(found.natural_hz, 1.82).abs() < 0.02);
}

/// Contacts too weak to be detected fall into the flights: the frequency is then not told, rather than told
/// wrong.
#[test]
fn natural_frequency_is_not_told_if_flights_hide_contacts() {
    let settings = Settings::for_rig(&WIRES);
    let seen = watch(&settings, &WIRES, 1.1, &REAL);
    assert_eq!(seen.identify.estimates().natural_hz, None);
}

#[test]
fn stiffness_and_damping_thirty_percent_off_are_found_as_well_as_stated() {
    for factor in [0.7, 1.3] {
        let truth = contact_scaled(&WIRES, factor);
        for (ring, stiffness, damping) in [
            (Ring::None, 0.15, 0.08),
            (Ring::Late, 0.15, 0.08),
            (Ring::Mode, 0.4, 0.2),
            (Ring::Sine, 0.3, 0.15),
        ] {
            let found = identified(&truth, &WIRES, 2.3, ring);
            let k = off(found.stiffness, 5.5e6 * factor);
            let c = off(found.damping, 1.2e3 * factor);
            assert!(k.abs() < stiffness, "{factor} {ring:?}: stiffness {k}");
            assert!(c.abs() < damping, "{factor} {ring:?}: damping {c}");
        }
    }
}

#[test]
fn a_gap_a_tenth_of_a_millimetre_off_is_found() {
    for gap_m in [-0.1e-3, 0.0, 0.1e-3] {
        let truth = RigParams { gap_m, ..WIRES };
        let found = identified(&truth, &WIRES, 1.5, Ring::Late).gap_m.unwrap();
        assert!(
            (f64::from(found.value) - gap_m).abs() < 0.01e-3,
            "{found:?}"
        );
    }
}
