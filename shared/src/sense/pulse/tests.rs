//! The contact detector on made-up signals.

use super::*;
use std::vec::Vec;

const DETECTION: Detection = Detection {
    on_n: 14.0,
    off_n: 7.0,
    refractory_s: 1.5e-3,
};

/// A contact of Table 3.1 at 0.08 m/s, as a half sine of 96 N and 0.57 ms from sample `at`, with ringing of a share of
/// it at 3 kHz that decays with 1 ms.
fn contact(signal: &mut [f32], at: usize, peak_n: f32, ringing: f32) {
    for (k, value) in signal.iter_mut().skip(at).enumerate() {
        let t = k as f32 * 50e-6;
        if t < 0.57e-3 {
            *value += peak_n * libm::sinf(core::f32::consts::PI * t / 0.57e-3);
        }
        let wave = libm::sinf(core::f32::consts::TAU * 3_000.0 * t);
        *value += ringing * peak_n * libm::expf(-t / 1e-3) * wave;
    }
}

fn detect(signal: &[f32]) -> (Vec<RawPulse>, u32) {
    let mut detector = PulseDetector::new(&DETECTION, 50e-6);
    let mut began = 0;
    let mut pulses = Vec::new();
    for sample in signal {
        match detector.tick(*sample) {
            PulseEdge::None => {}
            PulseEdge::Began { ago } => {
                assert!((1.0..=2.0).contains(&ago), "{ago}");
                began += 1;
            }
            PulseEdge::Ended(raw) => pulses.push(raw),
        }
    }
    assert_eq!(began, pulses.len());
    (pulses, detector.glitches())
}

#[test]
fn a_ringing_contact_is_one_and_keeps_its_duration() {
    let above = |ringing: f32| {
        let mut signal = [0.0; 400];
        contact(&mut signal, 50, 96.0, ringing);
        let (pulses, _) = detect(&signal);
        assert_eq!(pulses.len(), 1);
        pulses[0].first_fall + pulses[0].crossed_before
    };
    let plain = above(0.0);
    for ringing in [0.5, -0.2] {
        let rung = above(ringing);
        assert!((rung - plain).abs() < 0.7, "{ringing}: {rung} {plain}");
    }
}

#[test]
fn what_merges_and_what_does_not() {
    // Onsets 6 ms apart: ringing below 7 N after 2 ms, then the refractory time.
    for (apart, expected) in [(120, 2), (90, 2), (40, 1), (15, 1)] {
        let mut signal = [0.0; 600];
        contact(&mut signal, 50, 96.0, 0.5);
        contact(&mut signal, 50 + apart, 60.0, 0.5);
        assert_eq!(detect(&signal).0.len(), expected, "{apart}");
    }
}

#[test]
fn chatter_counts_down_to_hops_of_the_refractory_time() {
    // Ten contacts, each hop 0.8 of the one before, from 30 ms on.
    let mut signal = [0.0; 4_000];
    let (mut at, mut hop, mut peak, mut apart) = (100.0_f32, 600.0_f32, 96.0_f32, 0);
    for _ in 0..12 {
        contact(&mut signal, at as usize, peak, 0.5);
        apart += usize::from(peak >= 20.0);
        at += hop;
        hop *= 0.8;
        peak *= 0.8;
    }
    // Peaks from 20 N on are seen, all of them more than 5 ms apart.
    let (pulses, _) = detect(&signal);
    assert!(
        pulses.len() >= apart && pulses.len() <= apart + 2,
        "{}",
        pulses.len()
    );
}

#[test]
fn a_lone_sample_is_a_disturbance() {
    let mut signal = [0.0; 400];
    signal[50] = 80.0;
    signal[200] = 80.0;
    assert_eq!(detect(&signal), (Vec::new(), 2));
}

#[test]
fn impulse_is_the_sum_from_before_the_crossing_to_after_the_last_fall() {
    let mut signal = [0.0; 400];
    for (k, value) in signal.iter_mut().skip(50).take(12).enumerate() {
        *value = 50.0 * libm::sinf(core::f32::consts::PI * (k as f32 + 0.5) / 12.0);
    }
    let (pulses, _) = detect(&signal);
    let whole: f32 = signal.iter().sum();
    assert!((pulses[0].sum_n / whole - 1.0).abs() < 1e-5);
}

#[test]
fn a_force_that_stays_or_is_no_number_ends_nothing_early_and_breaks_nothing() {
    let mut detector = PulseDetector::new(&DETECTION, 50e-6);
    let ended = (0..2 * LONGEST).filter(|_| matches!(detector.tick(30.0), PulseEdge::Ended(_)));
    assert_eq!(ended.count(), 1);
    for _ in 0..100 {
        assert!(!matches!(detector.tick(f32::NAN), PulseEdge::Ended(_)));
    }
}

/// A contact that rises to 50 N within a tick, stays, and falls along a ramp of 4 N per tick from sample `ramp` on; `ringing`
/// N of 3 kHz on top until it ends.
fn trapezoid(ramp: usize, ringing: f32) -> [f32; 120] {
    core::array::from_fn(|i| match i {
        8 => 1.0,
        9 => 5.0,
        10.. => {
            let fallen = 4.0 * i.saturating_sub(ramp) as f32;
            let wave = libm::sinf(core::f32::consts::TAU * 3_000.0 * 50e-6 * i as f32);
            let force = 50.0 - fallen + ringing * wave;
            if fallen < 50.0 { force } else { 0.0 }
        }
        _ => 0.0,
    })
}

#[test]
fn threshold_crossings_lie_between_samples_and_ringing_does_not_move_them() {
    for ringing in [0.0, 4.0, -4.0] {
        for ramp in [20, 31] {
            let signal = trapezoid(ramp, ringing);
            let (pulses, glitches) = detect(&signal);
            assert_eq!((pulses.len(), glitches), (1, 0));
            let pulse = pulses[0];
            let rise = signal[10] - signal[9];
            let before = (signal[10] - DETECTION.on_n) / rise;
            assert!((pulse.crossed_before - before).abs() < 1e-6, "{pulse:?}");
            // The ramp passes 14 N nine ticks after its start.
            let fall = (ramp - 10) as f32 + 9.0;
            assert!(
                (pulse.first_fall - fall).abs() < 1e-3,
                "{ringing} {fall}: {pulse:?}"
            );
        }
    }
}

#[test]
fn the_sum_begins_three_samples_before_the_crossing_and_ends_two_after_the_last_fall() {
    let mut signal = [0.0_f32; 120];
    // Lead, contact, a fall, a rise within the refractory time, the last fall and what no longer belongs to it.
    signal[6..14].copy_from_slice(&[100.0 / 8.0, 1.0, 2.0, 3.0, 14.0, 60.0, 7.0, 6.5]);
    signal[14..20].copy_from_slice(&[0.5, 0.5, 0.5, 20.0, 6.0, 5.0]);
    signal[20..23].copy_from_slice(&[4.0, 3.0, 2.0]);
    let (pulses, _) = detect(&signal);
    let [pulse] = pulses[..] else {
        panic!("{pulses:?}");
    };
    let wanted: f32 = signal[7..20].iter().sum();
    assert_eq!(pulse.sum_n, wanted);
    assert_eq!(pulse.last_fall, 8);
    // 1.5 ms from the last fall on.
    assert_eq!(pulse.age, 8 + 30 - 1);
}

#[test]
fn a_sample_at_a_threshold_is_above_it() {
    let mut detector = PulseDetector::new(&DETECTION, 50e-6);
    assert_eq!(detector.tick(14.0), PulseEdge::None);
    assert!(detector.is_open());
    assert!(matches!(detector.tick(7.0), PulseEdge::Began { .. }));
    assert!(detector.is_open());
    detector.reset();
    assert!(!detector.is_open());
    // After a reset the sample before counts as nothing, so this is a rise.
    detector.tick(20.0);
    assert!(detector.is_open());
    detector.tick(0.0);
    assert_eq!((detector.is_open(), detector.glitches()), (false, 1));
}

#[test]
fn a_dip_of_the_first_samples_is_not_the_fall() {
    let mut signal = trapezoid(20, 0.0);
    let plain = detect(&signal).0[0].first_fall;
    signal[11] = 8.0;
    let dipped = detect(&signal).0[0].first_fall;
    assert_eq!(dipped, plain);
}
