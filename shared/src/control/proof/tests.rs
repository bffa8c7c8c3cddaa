//! The proof on rigs that answer as told.

use super::*;
use crate::model::drive::Drive;
use crate::model::params::WIRES;
use crate::settings::TICK_S;

/// How a rig answers: cart over command, hammer over cart, and what its sensors make of that.
#[derive(Clone, Copy)]
struct Rig {
    cart: f32,
    hammer: f32,
    /// Of a hammer that swings free: its natural frequency over the one believed, and its swing, m.
    free: Option<(f64, f64)>,
    /// Gains of hammer's and cart's sensor.
    gains: (f32, f32),
}

const PRESSED: Rig = Rig {
    cart: 1.0,
    hammer: 1.0,
    free: None,
    gains: (1.0, 1.0),
};

fn settings(min_ratio: f32) -> Settings {
    let mut settings = Settings::for_rig(&WIRES);
    settings.limits.min_frequency_hz = min_ratio * WIRES.natural_frequency_hz() as f32;
    settings
}

/// Makes the motion as the controller does, in blocks of ten ticks. What it proves, after how long, s, and the
/// largest motion of the cart, m.
fn prove(settings: &Settings, swing_m: f32, rig: &Rig) -> (Result<Proven, Trip>, f64, f32) {
    let zero = Zero {
        swing_m,
        ..Zero::default()
    };
    let mut proof = Proof::new(Mode::Automatic, settings, &zero, (1.0, 1e-3));
    let mut drive = Drive::<f32>::new(1.0, TICK_S).unwrap();
    let natural = core::f64::consts::TAU * WIRES.natural_frequency_hz();
    let (mut x, mut v) = (rig.free.map_or(0.0, |(_, swing_m)| swing_m), 0.0);
    let (mut amplitude_m, mut largest_m) = (0.0, 0.0_f32);
    for tick in 0..2_000_000_u32 {
        if tick % 10 == 0 {
            if let Some(hz) = proof.begin() {
                drive = Drive::new(f64::from(hz), TICK_S).unwrap();
            }
            amplitude_m = proof.amplitude_m() * proof.envelope();
        }
        let command_m = amplitude_m * drive.sin();
        let cart_m = rig.cart * command_m;
        let mut hammer_m = rig.hammer * cart_m;
        if let Some((off, _)) = rig.free {
            let omega = natural * off;
            v -= TICK_S * omega * omega * (x - f64::from(cart_m));
            x += TICK_S * v;
            hammer_m = x as f32;
        }
        largest_m = largest_m.max(libm::fabsf(cart_m));
        let sample = Sample {
            force_n: 0.0,
            hammer_m: 1e-3 + rig.gains.0 * hammer_m,
            cart_m: -0.2e-3 + rig.gains.1 * cart_m,
        };
        if let Some(end) = proof.tick(&sample, command_m) {
            return (end, f64::from(tick) * TICK_S, largest_m);
        }
        drive.advance();
    }
    panic!("the proof never ends");
}

fn origin(rig: &Rig) -> Option<Origin> {
    let (end, ..) = prove(&settings(0.3), 0.0, rig);
    end.err().map(|trip| trip.origin)
}

#[test]
fn a_healthy_rig_is_proven_by_one_short_motion() {
    let (end, seconds, largest_m) = prove(&settings(0.3), 0.0, &PRESSED);
    let Proven { cart, hammer } = end.unwrap();
    assert!((cart - 1.0).abs() < 1e-4 && (hammer.unwrap() - 1.0).abs() < 1e-4);
    // Three natural periods of 0.546 s, three tenths of A0.
    assert!((1.60..1.66).contains(&seconds), "{seconds}");
    assert!((0.2e-3..0.3e-3).contains(&largest_m), "{largest_m}");
}

#[test]
fn gains_beyond_the_thresholds_are_found_and_those_within_a_tenth_of_them_are_not() {
    let (cart, hammer) = (Some(Origin::Cart), Some(Origin::Hammer));
    for (rig, gains, expected) in [
        // Cart over command, 0.7.
        (0.69, (1.0, 1.0), cart),
        (0.71, (1.0, 1.0), None),
        (-1.0, (1.0, 1.0), cart),
        // Hammer over cart, 0.75 and 1.52.
        (1.0, (0.74, 1.0), hammer),
        (1.0, (0.76, 1.0), None),
        (1.0, (1.50, 1.0), None),
        (1.0, (1.54, 1.0), hammer),
        (1.0, (-1.0, 1.0), hammer),
        (1.0, (f32::NAN, 1.0), hammer),
        (1.0, (1.0, f32::NAN), cart),
        // Of a cart that goes further than its command by 1.3, 0.88.
        (1.0, (1.0, 1.15), cart),
        (1.0, (1.0, 1.12), None),
    ] {
        let strong = if gains.1 > 1.0 { 1.2 } else { rig };
        let rig = Rig {
            cart: strong,
            gains,
            ..PRESSED
        };
        assert_eq!(origin(&rig), expected, "{} {gains:?}", rig.cart);
    }
}

#[test]
fn a_free_hammer_goes_further_and_its_own_swing_hardly_matters() {
    for (off, gains) in [
        (0.9, (1.05, 0.95)),
        (1.0, (1.05, 0.95)),
        (1.1, (0.95, 1.05)),
    ] {
        let rig = |swing_m| Rig {
            free: Some((off, swing_m)),
            gains,
            ..PRESSED
        };
        // At rest up to 0.35 A0; the largest travel allowed is 9 mm.
        for swing_m in [0.0_f64, 0.3e-3, -0.3e-3, 3e-3, -3e-3] {
            let (end, ..) = prove(&settings(0.3), swing_m.abs() as f32, &rig(swing_m));
            assert!(end.is_ok(), "{off} {swing_m}: {end:?}");
        }
        let reversed = Rig {
            gains: (-1.0, 1.0),
            ..rig(3e-3)
        };
        assert!(prove(&settings(0.3), 3e-3, &reversed).0.is_err());
    }
}

#[test]
fn where_the_limits_forbid_so_low_a_frequency_the_lowest_allowed_proves_what_it_can() {
    for min_ratio in [0.4, 0.5, 0.599] {
        for off in [0.9, 1.1] {
            let free = |gains| Rig {
                free: Some((off, 0.0)),
                gains,
                ..PRESSED
            };
            let (end, ..) = prove(&settings(min_ratio), 0.0, &free((1.05, 0.95)));
            assert!(end.unwrap().hammer.is_some(), "{min_ratio} {off}");
            for gains in [(-1.0, 1.0), (0.3, 1.0), (0.0, 1.0), (1.0, -1.0)] {
                let (end, ..) = prove(&settings(min_ratio), 0.0, &free(gains));
                assert!(end.is_err(), "{min_ratio} {off} {gains:?}");
            }
        }
    }
    let (end, _, largest_m) = prove(&settings(0.61), 0.0, &PRESSED);
    assert_eq!(end.unwrap().hammer, None);
    assert!(largest_m < 0.2 * 0.89e-3, "{largest_m}");
    let reversed = Rig {
        cart: -1.0,
        ..PRESSED
    };
    assert!(prove(&settings(0.61), 0.0, &reversed).0.is_err());
}

#[test]
fn a_slow_slew_makes_the_motion_longer_and_not_too_small() {
    let mut settings = settings(0.3);
    settings.drive.amplitude_slew_m_per_s = 0.02e-3;
    let (end, seconds, largest_m) = prove(&settings, 0.0, &PRESSED);
    assert!(end.is_ok());
    assert!((26.7..28.4).contains(&seconds), "{seconds}");
    assert!(largest_m > 0.28 * 0.89e-3, "{largest_m}");
}

#[test]
fn a_knock_during_the_motion_is_forgiven_once() {
    let settings = settings(0.3);
    let mut proof = Proof::new(Mode::Automatic, &settings, &Zero::default(), (1.0, 1e-3));
    let mut ends = std::vec::Vec::new();
    for motion in 0..3 {
        assert_eq!(proof.begin().is_some(), motion == 0, "{motion}");
        for tick in 0..40_000 {
            let command_m = 1e-4 * libm::sinf(1.9e-4 * tick as f32);
            let known = if motion == 0 { -1.0 } else { 1.0 };
            let sample = Sample {
                hammer_m: known * command_m,
                cart_m: command_m,
                ..Sample::default()
            };
            ends.extend(proof.tick(&sample, command_m));
        }
    }
    assert!(matches!(ends[..], [Ok(_)]), "{ends:?}");
    assert!(proof.over().is_some());
}
