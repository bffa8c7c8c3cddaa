//! The observer against hammers whose motion is known.

use super::*;
use crate::model::contact::Law;
use crate::model::params::{BEAM_170, WIRES};
use crate::settings::TICK_S;
use core::f64::consts::TAU;
use std::vec::Vec;

/// Ticks since the contact, true displacement and rate, estimated ones.
type Point = (u32, (f64, f64), (f32, f32));

/// A hammer that bounces, its natural frequency `factor` times what is believed.
fn bounce(factor: f64, detected: bool) -> Vec<Point> {
    let omega = core::f64::consts::TAU * 1.82;
    let drive = 1.5 * omega;
    let mut observer = Observer::new(&Settings::for_rig(&WIRES), TICK_S as f32);
    let (mut x, mut v, mut since) = (-1e-3_f64, 0.0_f64, 0);
    let mut seen = Vec::new();
    let mut seed = 1_u32;
    for k in 0..60_000 {
        let inertial = 0.89e-3 * drive * drive * (drive * f64::from(k) * TICK_S).sin();
        v += TICK_S * (inertial - factor * factor * omega * omega * x);
        x += TICK_S * v;
        since += 1;
        let strikes = x > 0.0 && v > 0.0;
        if strikes {
            v *= -0.317;
            since = 0;
        }
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        // Uniform, standard deviation 2 % of 4 mm.
        let noise = (f64::from(seed >> 8) / 8_388_608.0 - 1.0) * 0.08e-3 * 3.0_f64.sqrt();
        observer.tick((x + noise) as f32, inertial as f32);
        if strikes && detected {
            observer.contact(0.0);
        }
        if k > 20_000 {
            seen.push((since, (x, v), observer.relative()));
        }
    }
    seen
}

fn worst(seen: &[Point], after: u32) -> (f64, f64) {
    let late = seen.iter().filter(|(since, ..)| *since > after);
    late.fold((0.0, 0.0), |(dx, dv), (_, truth, found)| {
        (
            (f64::from(found.0) - truth.0).abs().max(dx),
            (f64::from(found.1) - truth.1).abs().max(dv),
        )
    })
}

#[test]
fn follows_between_contacts_with_a_natural_frequency_ten_percent_off() {
    for factor in [0.9, 1.0, 1.1] {
        // 50 ms after a contact: displacement within a third of the noise, rate within 5 % of 0.04 m/s.
        let (dx, dv) = worst(&bounce(factor, true), 1_000);
        assert!(dx < 0.03e-3, "{factor}: {dx}");
        assert!(dv < 2e-3, "{factor}: {dv}");
    }
}

#[test]
fn a_contact_nobody_told_it_of_is_survived() {
    let (_, dv) = worst(&bounce(1.0, false), 3_000);
    assert!(dv < 6e-3, "{dv}");
}

#[test]
fn sensors_out_of_family_show_in_the_innovation_and_a_bad_number_does_not_stay() {
    let settings = Settings::for_rig(&WIRES);
    let mut observer = Observer::new(&settings, TICK_S as f32);
    for _ in 0..4_000 {
        observer.tick(0.0, 0.0);
    }
    assert!(observer.health() < 1.0);
    for k in 0..4_000 {
        let jumps = if (k / 100) % 2 == 0 { 2e-3 } else { -2e-3 };
        observer.tick(jumps, 0.0);
    }
    assert!(observer.health() > 3.0, "{}", observer.health());
    observer.tick(f32::NAN, 0.0);
    for _ in 0..4_000 {
        observer.tick(1e-3, 0.0);
    }
    let (x, v) = observer.relative();
    assert!((x - 1e-3).abs() < 1e-4 && v.abs() < 1e-3, "{x} {v}");
}

/// An observer of a hammer on beams that swings at 6 Hz with a tenth of critical damping, at ticks of `tick_s` s.
fn on_beams(tick_s: f32) -> Observer {
    let mut rig = BEAM_170;
    rig.support = SupportParams::Beams {
        natural_frequency_hz: 6.0,
        damping_ratio: 0.1,
        cubic_stiffness_n_per_m3: Some(0.0),
    };
    Observer::new(&Settings::for_rig(&rig), tick_s)
}

#[test]
fn between_corrections_it_swings_by_the_equation_of_motion() {
    // x″ + 2ζω x′ + ω² x = f from rest at x₀: about x = f/ω², with x₀ − f/ω² as amplitude.
    let (omega, zeta, force, x0) = (TAU * 6.0, 0.1_f64, 10.0_f64, -3e-3_f64);
    let mut observer = on_beams(1e-3);
    for _ in 0..DECIMATION - 1 {
        observer.tick(x0 as f32, force as f32);
    }
    let t = 1e-3 * f64::from(DECIMATION - 1);
    let (root, off) = ((1.0 - zeta * zeta).sqrt(), x0 - force / (omega * omega));
    let (sin, cos) = (omega * root * t).sin_cos();
    let fall = (-zeta * omega * t).exp();
    let x = force / (omega * omega) + off * fall * (cos + zeta / root * sin);
    let v = -off * fall * omega / root * sin;
    let (found_x, found_v) = observer.relative();
    // Of first order: a tick is 0.04 rad.
    assert!((f64::from(found_x) / x - 1.0).abs() < 2e-3, "{found_x} {x}");
    assert!((f64::from(found_v) / v - 1.0).abs() < 2e-2, "{found_v} {v}");
}

/// Fails if the matrix that carries the covariance on is not the motion that carries the state on.
#[test]
fn covariance_and_state_follow_the_same_motion() {
    for axis in 0..3 {
        let mut observer = on_beams(TICK_S as f32);
        let mut unit = Vector3::zeros();
        unit[axis] = 1.0;
        observer.state = unit;
        for _ in 0..DECIMATION {
            observer.predict(0.0);
        }
        let wanted = observer.step * unit;
        for i in 0..3 {
            let (found, wanted) = (observer.state[i], wanted[i]);
            let off = (found - wanted).abs();
            assert!(off <= 0.02 * wanted.abs(), "{axis} {i}: {found} {wanted}");
        }
    }
}

#[test]
fn a_contact_turns_the_rate_of_its_onset_round() {
    let mut observer = on_beams(1e-3);
    for _ in 0..DECIMATION - 1 {
        observer.tick(-3e-3, 10.0);
    }
    let (x, v) = observer.relative();
    let before = observer.covariance;
    let ago = 0.7e-3;
    let approach = observer.contact(ago);
    // The prediction ran on for 0.7 ms at some 10 m/s² and more.
    let gained = f64::from(v - approach);
    assert!((gained / (10.0 * 0.7e-3) - 1.0).abs() < 0.35, "{gained}");
    assert_eq!(observer.relative(), (x - v * ago, -RESTITUTION * approach));
    assert_eq!(observer.rebound(), (RESTITUTION * approach, 0));
    // How fast it leaves is unknown by as much as it came with, at least.
    let opened = observer.covariance - before;
    assert!(opened.m22 > approach * approach && opened.m22 < 2.0 * approach * approach);
    // And where it is, by as much as it comes in the time that the sensors may be late by.
    let place = libm::sqrtf(opened.m11) / (approach * LATE_S);
    assert!((0.9..1.1).contains(&place), "{place}");
}

#[test]
fn samples_during_a_contact_are_ignored_and_the_flight_is_timed_from_its_end() {
    let mut observer = on_beams(TICK_S as f32);
    for _ in 0..20 * DECIMATION {
        observer.tick(0.0, 0.0);
    }
    assert!(observer.rebound().1 > 1_000_000, "no contact yet");
    observer.contact(0.0);
    // Table 3.1: 0.57 ms, which is 11 ticks, and a margin of 5.
    for k in 0..16 {
        assert_eq!(observer.rebound().1, 5_u32.saturating_sub(16 - k));
        observer.tick(1.0, 0.0);
    }
    let (x, v) = observer.relative();
    assert!(x.abs() < 1e-6 && v.abs() < 1e-3, "{x} {v}");
    assert_eq!((observer.rebound().1, observer.seen), (5, 0));
    observer.tick(0.0, 0.0);
    assert_eq!((observer.rebound().1, observer.seen), (6, 1));
}

#[test]
fn it_looks_away_for_as_long_as_the_believed_contact_lasts() {
    let ticks = |stiffness: f64| {
        let mut rig = BEAM_170;
        rig.contact = Law::SpringDashpot {
            stiffness,
            damping: 1.2e3,
        };
        Observer::new(&Settings::for_rig(&rig), TICK_S as f32).hold_ticks - MARGIN
    };
    // 11.4 ticks in Table 3.1; a sixteenth of the stiffness makes it four times as long.
    assert_eq!([5.5e6, 5.5e6 / 16.0].map(ticks), [11, 45]);
}

#[test]
fn the_speed_of_the_rebound_is_that_of_the_release_however_long_ago() {
    let mut observer = on_beams(TICK_S as f32);
    for _ in 0..2_000 {
        observer.tick(0.0, 0.0);
    }
    // It comes in at 0.12 m/s, flies off at 0.05 m/s and is slowed by the beams.
    observer.state.y = 0.12;
    observer.contact(0.0);
    let (omega, zeta) = (TAU * 6.0, 0.1_f64);
    let root = (1.0 - zeta * zeta).sqrt();
    for k in 0..500_u32 {
        let t = (f64::from(k) - 11.0).max(0.0) * TICK_S;
        let sin = (omega * root * t).sin() * (-zeta * omega * t).exp();
        observer.tick((-0.05 / (omega * root) * sin) as f32, 0.0);
    }
    let (speed, flown) = observer.rebound();
    assert_eq!(flown, 500 - 11);
    assert!((speed / 0.05 - 1.0).abs() < 0.03, "{speed}");
}

#[test]
fn a_brief_disturbance_moves_it_little_and_a_jump_that_stays_is_followed() {
    let after = |ticks: u32, jump: f32| {
        let mut observer = on_beams(TICK_S as f32);
        for _ in 0..4_000 {
            observer.tick(0.0, 0.0);
        }
        for _ in 0..ticks {
            observer.tick(jump, 0.0);
        }
        observer.relative()
    };
    let brief = after(DECIMATION, 5e-3);
    assert!(brief.0 > 0.0 && brief.0 < 0.1e-3, "{brief:?}");
    // The fourth in a row opens the covariance, and the fifth is believed.
    let four = after(4 * DECIMATION, 5e-3);
    assert!(four.0 < 1e-3, "{four:?}");
    let five = after(5 * DECIMATION, 5e-3);
    assert!((five.0 - 5e-3).abs() < 0.2e-3, "{five:?}");
    // Nothing in it prefers a side.
    for ticks in [DECIMATION, 3 * DECIMATION, 100 * DECIMATION] {
        let (up, down) = (after(ticks, 5e-3), after(ticks, -5e-3));
        assert_eq!(up, (-down.0, -down.1));
    }
}

#[test]
fn the_innovation_is_measured_in_the_noise_that_is_expected() {
    let health = |share: f32| {
        let mut observer = on_beams(TICK_S as f32);
        let (mut seed, mut sum) = (1_u32, 0.0);
        for k in 0..200 * 64 * DECIMATION {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let uniform = (seed >> 8) as f32 / 8_388_608.0 - 1.0;
            let sigma = share * NOISE_PER_AMPLITUDE * BEAM_170.amplitude_m as f32;
            observer.tick(uniform * sigma * libm::sqrtf(3.0), 0.0);
            if k % DECIMATION == 0 {
                sum += observer.health() * observer.health();
            }
        }
        libm::sqrtf(sum / (200.0 * 64.0))
    };
    // Noise of the expected size is most of the innovation; the rest allows for disturbances that are not there.
    let (one, two) = (health(1.0), health(2.0));
    assert!((0.7..1.05).contains(&one), "{one}");
    assert!((two / one - 2.0).abs() < 0.1, "{one} {two}");
}

#[test]
fn a_new_observer_knows_what_the_rig_may_do_and_a_reset_makes_it_new() {
    let new = on_beams(TICK_S as f32);
    let (amplitude, omega) = (BEAM_170.amplitude_m as f32, TAU as f32 * 6.0);
    let rms = |i: usize| libm::sqrtf(new.covariance[(i, i)]);
    let close = |found: f32, wanted: f32| {
        assert!((found / wanted - 1.0).abs() < 0.01, "{found} {wanted}");
    };
    close(rms(0), NOISE_PER_AMPLITUDE * amplitude);
    close(rms(1), amplitude * omega);
    close(rms(2), DISTURBANCE * omega * omega * amplitude);
    let mut observer = new;
    for _ in 0..3 * DECIMATION + 1 {
        observer.tick(1e-3, 1.0);
    }
    observer.contact(1e-5);
    observer.reset();
    assert_eq!(observer, new);
    observer.tick(2e-3, 0.0);
    assert!(
        (observer.relative().0 - 2e-3).abs() < 1e-5,
        "it starts where it is measured"
    );
}
