use super::*;
use crate::engine::{CycleRecorder, Start, machine, observe};
use shared::model::cart::{ASSUMED_SHAKER, CartDrive};
use shared::model::params::{BEAM_170, WIRES};

const PLAN: Plan = Plan {
    cycles: 320,
    transient: 300,
};

/// A record made by the reference itself, 20 kHz, its clock begun `lead_s` after a drive phase 0.
fn made(
    params: &RigParams,
    frequency_hz: f64,
    lead_s: f64,
    spoil: impl Fn(usize) -> f64,
) -> Signal {
    made_from(Start::Rest, params, frequency_hz, lead_s, spoil)
}

fn made_from(
    start: Start,
    params: &RigParams,
    frequency_hz: f64,
    lead_s: f64,
    spoil: impl Fn(usize) -> f64,
) -> Signal {
    recorded(20e3, start, params, frequency_hz, lead_s, spoil)
}

fn recorded(
    rate_hz: f64,
    start: Start,
    params: &RigParams,
    frequency_hz: f64,
    lead_s: f64,
    spoil: impl Fn(usize) -> f64,
) -> Signal {
    let mut hammer = machine(Engine::Event, params, frequency_hz, start).unwrap();
    let mut recorder = CycleRecorder {
        samples_per_period: (rate_hz / frequency_hz) as usize,
        ..CycleRecorder::default()
    };
    observe(hammer.as_mut(), PLAN, &mut recorder).unwrap();
    let begin = f64::from(PLAN.transient) / frequency_hz + lead_s;
    let kept: Vec<_> = recorder
        .samples
        .iter()
        .filter(|s| s.time_s >= begin)
        .collect();
    Signal {
        name: "made up".into(),
        time_s: kept.iter().map(|s| s.time_s - begin).collect(),
        displacement_mm: Some(
            kept.iter()
                .enumerate()
                .map(|(i, s)| s.displacement_mm + spoil(i))
                .collect(),
        ),
        force_n: Some(kept.iter().map(|s| s.force_n).collect()),
        cart_mm: None,
    }
}

fn question(frequency_hz: Option<f64>) -> ComparisonRequest {
    ComparisonRequest {
        params: WIRES,
        engine: Engine::Event,
        start: Start::Rest,
        frequency_hz,
        plan: PLAN,
        frame: MeasuredFrame::Fixed,
    }
}

#[test]
fn a_record_made_by_the_model_lies_on_it_with_its_phase_found() {
    let hz = 1.5 * 1.82;
    let signal = made(&WIRES, hz, 0.1234, |_| 0.0);
    let seen = compare(&signal, &question(Some(hz))).unwrap().errors;
    assert!(seen.regime.is(1, 1));
    // Interpolated between samples 50 µs apart; the velocity jumps by 0.1 m/s within a contact.
    assert!(seen.displacement_rms_mm.unwrap() < 1e-3, "{seen:?}");
    assert!((seen.shift_s - 0.1234).abs() < 2e-5, "{seen:?}");
    assert!(seen.force_peak_percent.unwrap().abs() < 2.0, "{seen:?}");
    assert!((seen.measured_contacts_per_period.unwrap() - 1.0).abs() < 0.06);
    let (over, true_ms) = (
        seen.measured_contact_time_ms.unwrap(),
        seen.simulated_contact_time_ms.unwrap(),
    );
    // Counted in samples of 50 µs.
    assert!((over - true_ms).abs() < 0.06, "{over} {true_ms}");
}

/// What a converter makes of the model's own force, at even instants, in either cart: the same contact time and impulse on both
/// sides, however coarse.
#[test]
fn sampled_evenly_it_has_its_own_contact_time_and_impulse() {
    let recoils = RigParams {
        cart: CartDrive::Loop(ASSUMED_SHAKER),
        ..WIRES
    };
    for params in [WIRES, recoils] {
        let hz = 1.8 * params.natural_frequency_hz();
        // So fine that the force at any instant is that of the last sample before.
        let mut fine = recorded(1e6, Start::Rest, &params, hz, 0.0, |_| 0.0);
        let whole = ComparisonRequest {
            params,
            ..question(Some(hz))
        };
        let dense = fine.time_s.clone();
        let [force, displacement] =
            [&fine.force_n, &fine.displacement_mm].map(|c| c.clone().unwrap());
        for sample_s in [1e-4, 5e-5, 2e-5] {
            let count = (dense[dense.len() - 1] / sample_s) as usize;
            fine.time_s = (1..count).map(|k| k as f64 * sample_s).collect();
            let held = |values: &[f64]| {
                let at = |t: &f64| values[dense.partition_point(|s| s <= t) - 1];
                fine.time_s.iter().map(at).collect::<Vec<_>>()
            };
            (fine.force_n, fine.displacement_mm) = (Some(held(&force)), Some(held(&displacement)));
            let seen = compare(&fine, &whole).unwrap();
            let e = &seen.errors;
            let [measured, simulated] =
                [e.measured_contact_time_ms, e.simulated_contact_time_ms].map(Option::unwrap);
            let off = |a: f64, b: f64| (a / b - 1.0).abs();
            assert!(off(measured, simulated) < 0.05, "{sample_s} {e:?}");
            let sum = |force: fn(&ComparedSample) -> f64| seen.rows.iter().map(force).sum::<f64>();
            let impulses = (
                sum(|r| r.measured_force_n.unwrap()),
                sum(|r| r.simulated_force_n),
            );
            assert!(
                off(impulses.0, impulses.1) < 0.02,
                "{sample_s} {impulses:?}"
            );
            assert!(
                e.force_peak_percent.unwrap().abs() < 2.0,
                "{sample_s} {e:?}"
            );
        }
    }
}

/// Figure 3.52 a: from rest 1/1, but the motion that never touches is stable, too. Without contact the beams are a
/// linear oscillator: A0 r²/(1 − r²) sin Ωt, which stays short of the gap of 1.6 A0.
#[test]
fn of_two_motions_at_one_frequency_the_start_chooses() {
    let params = RigParams {
        gap_m: 1.6 * BEAM_170.amplitude_m,
        ..BEAM_170
    };
    let ratio = 1.8_f64;
    let hz = ratio * params.natural_frequency_hz();
    let omega = std::f64::consts::TAU * hz;
    let swing = params.amplitude_m * ratio.powi(2) / (1.0 - ratio.powi(2));
    let start = Start::Moving(0.0, swing * omega);
    let signal = made_from(start, &params, hz, 0.05, |_| 0.0);
    let seen = |start| {
        let question = ComparisonRequest {
            params,
            start,
            ..question(Some(hz))
        };
        compare(&signal, &question).unwrap().errors
    };
    let (same, other) = (seen(start), seen(Start::Rest));
    assert_eq!(same.regime, Regime::None);
    assert!(other.regime.is(1, 1));
    assert!(same.displacement_rms_mm.unwrap() < 1e-3, "{same:?}");
    assert!(other.displacement_rms_mm.unwrap() > 0.3, "{other:?}");
    // Relative 1.446 A0 against the cart's A0: 0.446 A0 in the fixed frame, both ways.
    let travel = 2.0 * 1e3 * (swing.abs() - params.amplitude_m);
    assert!(
        (same.measured_peak_to_peak_mm.unwrap() / travel - 1.0).abs() < 0.02,
        "{same:?}"
    );
}

/// By the force alone a contact of 0.6 ms must be laid over one of the simulation's, which a search in steps of some
/// milliseconds passes over.
#[test]
fn by_its_force_alone_a_record_finds_its_place() {
    for ratio in [1.5, 1.83, 3.8] {
        let hz = ratio * 1.82;
        let signal = Signal {
            displacement_mm: None,
            ..made(&WIRES, hz, 0.1234, |_| 0.0)
        };
        let seen = compare(&signal, &question(Some(hz))).unwrap().errors;
        let period = f64::from(seen.regime.periods().unwrap_or(1)) / hz;
        let turns = (seen.shift_s - 0.1234) / period;
        let off_s = (turns - turns.round()) * period;
        assert!(off_s.abs() < 2e-5, "{off_s} {seen:?}");
    }
}

/// Between two samples of a coarse record may lie a whole contact.
#[test]
fn a_simulation_at_its_own_instants_has_every_contact() {
    let hz = 1.8 * 1.82;
    let simulated = compare(&made(&WIRES, hz, 0.0, |_| 0.0), &question(Some(hz)));
    let simulated = simulated.unwrap().simulated;
    let period_s = 1.0 / hz;
    for k in [-3.0, 0.0, 4.5] {
        let between = (k * period_s, (k + 1.0) * period_s);
        let motion = simulated.between(between, MeasuredFrame::Relative);
        assert!(motion.is_sorted_by(|a, b| a.0 <= b.0));
        let largest = motion.iter().map(|(_, at)| at.force_n).fold(0.0, f64::max);
        // The peak itself is between two of its samples.
        assert!(
            (largest / simulated.force_n - 1.0).abs() < 1e-3,
            "{largest}"
        );
    }
}

/// Recorded finely where its own contacts are, and coarsely where those of another rig would be.
#[test]
fn the_simulated_contact_time_does_not_depend_on_the_records_instants() {
    let hz = 1.8 * 1.82;
    let signal = made(&WIRES, hz, 0.0, |_| 0.0);
    let stiffer = RigParams {
        gap_m: 0.3e-3,
        ..WIRES
    };
    let whole = ComparisonRequest {
        params: stiffer,
        ..question(Some(hz))
    };
    let seen = compare(&signal, &whole).unwrap().errors;
    let own = made(&stiffer, hz, 0.0, |_| 0.0);
    let alone = compare(&own, &whole).unwrap().errors;
    let [with, without] = [seen, alone].map(|e| e.simulated_contact_time_ms.unwrap());
    assert!((with / without - 1.0).abs() < 0.01, "{with} {without}");
}

#[test]
fn contacts_of_few_samples_are_said_to_be_coarse() {
    let hz = 1.5 * 1.82;
    let mut signal = made(&WIRES, hz, 0.0, |_| 0.0);
    let count = (signal.time_s[signal.time_s.len() - 1] / 2e-4) as usize;
    let at = |k: usize| signal.time_s.partition_point(|t| *t < k as f64 * 2e-4);
    let kept: Vec<usize> = (0..count).map(at).collect();
    signal.force_n = signal.force_n.map(|f| kept.iter().map(|i| f[*i]).collect());
    signal.displacement_mm = None;
    signal.time_s = (0..count).map(|k| k as f64 * 2e-4).collect();
    let notes = compare(&signal, &question(Some(hz))).unwrap().errors.notes;
    let coarse = |n: &Note| matches!(n, Note::CoarseContacts { samples } if *samples < 4.0);
    assert!(notes.iter().any(coarse), "{notes:?}");
}

#[test]
fn a_period_two_orbit_finds_its_drive_and_its_place() {
    // 0.0 mm, 3.8: 1/2. The strongest pitch is half the drive.
    let hz = 3.8 * 1.82;
    let signal = made(&WIRES, hz, 0.02, |_| 0.0);
    let seen = compare(&signal, &question(None)).unwrap().errors;
    assert!(seen.regime.is(1, 2));
    assert!((seen.frequency_hz / hz - 1.0).abs() < 1e-3, "{seen:?}");
    assert!(seen.displacement_rms_percent.unwrap() < 2.0, "{seen:?}");
}

/// What is tried of a record of minutes stands so far apart that a faster motion looks the same.
#[test]
fn the_pitch_of_a_long_record_is_no_faster_one() {
    let times: Vec<f64> = (0..434_000).map(|k| f64::from(k) * 5e-4).collect();
    for hz in [2.73, 3.677, 6.9] {
        let swing = |t: &f64| (std::f64::consts::TAU * hz * t).sin();
        let values: Vec<f64> = times.iter().map(|t| 2.0 * swing(t)).collect();
        let (found, explained) = pitch(&times, &values, (0.1365, 21.84));
        assert!(
            (found - hz).abs() < 1e-5 && explained > 0.999,
            "{hz} {found}"
        );
    }
}

#[test]
fn what_is_wrong_with_a_record_shows_in_the_errors() {
    let hz = 1.5 * 1.82;
    // An offset of 0.2 mm and noise of ±0.1 mm in turn.
    let spoil = |i: usize| 0.2 + if i.is_multiple_of(2) { 0.1 } else { -0.1 };
    let signal = made(&WIRES, hz, 0.0, spoil);
    let seen = compare(&signal, &question(Some(hz))).unwrap().errors;
    assert!(
        (seen.displacement_mean_mm.unwrap() + 0.2).abs() < 1e-3,
        "{seen:?}"
    );
    let expected = (0.2_f64.powi(2) + 0.1_f64.powi(2)).sqrt();
    assert!(
        (seen.displacement_rms_mm.unwrap() - expected).abs() < 1e-3,
        "{seen:?}"
    );
}

#[test]
fn the_carts_motion_gives_frequency_and_phase() {
    let hz = 1.5 * 1.82;
    let mut signal = made(&WIRES, hz, 0.05, |_| 0.0);
    let phase = std::f64::consts::TAU * hz;
    let cart = signal
        .time_s
        .iter()
        .map(|t| 0.89 * (phase * (t + 0.05)).sin());
    signal.cart_mm = Some(cart.collect());
    let seen = compare(&signal, &question(None)).unwrap().errors;
    assert_eq!(seen.frequency_from, FrequencySource::Cart);
    assert!((seen.frequency_hz / hz - 1.0).abs() < 1e-5, "{seen:?}");
    assert!((seen.shift_s - 0.05).abs() < 1e-5, "{seen:?}");
    assert!((seen.cart_amplitude_mm.unwrap() / 0.89 - 1.0).abs() < 1e-4);
}

#[test]
fn a_cart_whose_frequency_moves_is_refused_and_one_that_stands_still_is_passed_over() {
    let hz = 1.5 * 1.82;
    let mut signal = made(&WIRES, hz, 0.05, |_| 0.0);
    let turns = |t: f64| hz * t * (1.0 + 0.05 * t);
    let cart = signal
        .time_s
        .iter()
        .map(|t| 0.89 * (std::f64::consts::TAU * turns(*t)).sin());
    signal.cart_mm = Some(cart.collect());
    let refused = compare(&signal, &question(None)).unwrap_err();
    assert_eq!(refused, signal.lacks(RecordError::UnsteadyCart));
    // Told the frequency, it says that the cart's phase is not used.
    let seen = compare(&signal, &question(Some(hz))).unwrap().errors;
    assert!(seen.notes.contains(&Note::CartUnused), "{seen:?}");
    signal.cart_mm = Some(vec![0.001; signal.time_s.len()]);
    let seen = compare(&signal, &question(None)).unwrap().errors;
    assert_eq!(seen.frequency_from, FrequencySource::Record);
}
