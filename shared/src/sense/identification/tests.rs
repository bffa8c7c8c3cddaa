//! Identification on made-up flights and contacts.

use super::*;
use crate::model::params::WIRES;

/// The hammer swinging freely in a cart that moves as it likes.
fn swing(identification: &mut Identification, natural_hz: f64, seconds: f64) {
    let omega = std::f64::consts::TAU * natural_hz;
    let h = TICK_S;
    let (mut x, mut v) = (2e-3_f64, 0.0_f64);
    for k in 0..(seconds / h) as u32 {
        let t = f64::from(k) * h;
        let y = 0.9e-3 * (17.0 * t).sin() + 0.2e-3 * (41.0 * t).cos();
        v -= h * omega * omega * (x - y);
        x += h * v;
        let sample = Sample {
            force_n: 0.0,
            hammer_m: (x + 1e-4) as f32,
            cart_m: y as f32,
        };
        identification.flight(&sample, false);
    }
}

#[test]
fn natural_frequency_ten_percent_off_is_found_whatever_the_cart_does() {
    let settings = Settings::for_rig(&WIRES);
    for factor in [0.9, 1.0, 1.1] {
        let mut identification = Identification::new(&settings);
        swing(&mut identification, factor * 1.82, 10.0);
        let found = identification.estimates().natural_hz.unwrap();
        // The integrator above is of first order: 5e-5 relative at this step.
        let off = f64::from(found.value) / (factor * 1.82) - 1.0;
        assert!(off.abs() < 1e-3, "{factor}: {found:?}");
        assert_eq!(identification.refused(), 0);
    }
}

#[test]
fn a_rig_that_changes_is_followed_and_an_implausible_one_is_not_reported() {
    let settings = Settings::for_rig(&WIRES);
    let mut identification = Identification::new(&settings);
    swing(&mut identification, 1.82, 10.0);
    swing(&mut identification, 2.0, 60.0);
    let found = identification.estimates().natural_hz.unwrap();
    assert!((found.value - 2.0).abs() < 0.01, "{found:?}");
    assert!(identification.refused() > 0);
    let mut identification = Identification::new(&settings);
    swing(&mut identification, 2.6, 10.0);
    assert_eq!(identification.estimates().natural_hz, None);
}

#[test]
fn implausible_contacts_are_refused_and_counted() {
    let settings = Settings::for_rig(&WIRES);
    let mut identification = Identification::new(&settings);
    let good = Pulse {
        peak_n: 96.0,
        approach_m_per_s: 0.08,
        rebound_m_per_s: 0.025,
        duration_s: 520e-6,
        relative_m: 1e-5,
        ..Pulse::default()
    };
    for _ in 0..10 {
        identification.pulse(&good);
    }
    let before = identification.estimates();
    assert!(before.stiffness.is_some() && before.damping.is_some());
    assert_eq!(identification.refused(), 0);
    for bad in [
        Pulse {
            relative_m: -5e-3,
            ..good
        },
        Pulse {
            rebound_m_per_s: 0.2,
            ..good
        },
        Pulse {
            duration_s: 0.0,
            ..good
        },
        Pulse {
            relative_m: f32::NAN,
            ..good
        },
        Pulse {
            rebound_m_per_s: f32::NAN,
            ..good
        },
    ] {
        identification.pulse(&bad);
    }
    assert_eq!(identification.refused(), 5);
    assert_eq!(identification.estimates().stiffness, before.stiffness);
}
