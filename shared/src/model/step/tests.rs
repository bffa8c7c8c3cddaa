//! One Runge–Kutta step against closed forms, and what each stepper records.

use super::*;
use crate::model::contact::{LAWS, Law, TABLE_3_1};
use crate::model::contacts::Contact;
use crate::model::drive::TURN;
use crate::model::params::{BEAM_170, RigParams, SupportParams, WIRES};
use crate::model::switch::Band;
use core::f64::consts::TAU;

const MASS_KG: f64 = 0.298;

/// A hammer on linear beams.
fn linear(natural_frequency_hz: f64, damping_ratio: f64, gap_m: f64) -> RigParams {
    RigParams {
        support: SupportParams::Beams {
            natural_frequency_hz,
            damping_ratio,
            cubic_stiffness_n_per_m3: Some(0.0),
        },
        mass_kg: MASS_KG,
        gap_m,
        contact: TABLE_3_1,
        ..BEAM_170
    }
}

/// x″ + 2ζω x′ + ω² x = `push` sin(Ωt + φ): x and x′ after `t`.
fn oscillator(
    (omega, zeta): (f64, f64),
    (push, drive_omega, phase): (f64, f64, f64),
    (x0, v0): (f64, f64),
    t: f64,
) -> (f64, f64) {
    // The particular solution a sin + b cos.
    let (p, r) = (
        omega * omega - drive_omega * drive_omega,
        2.0 * zeta * omega * drive_omega,
    );
    let scale = push / (p * p + r * r);
    let (a, b) = (scale * p, -scale * r);
    let part = |t: f64| {
        let (sin, cos) = (drive_omega * t + phase).sin_cos();
        (a * sin + b * cos, drive_omega * (a * cos - b * sin))
    };
    let (at_start, at_end) = (part(0.0), part(t));
    let damped = omega * (1.0 - zeta * zeta).sqrt();
    let (c, d) = (x0 - at_start.0, v0 - at_start.1);
    let s = (d + zeta * omega * c) / damped;
    let ((sin, cos), fall) = ((damped * t).sin_cos(), (-zeta * omega * t).exp());
    let x = fall * (c * cos + s * sin);
    let v = fall * (damped * (s * cos - c * sin) - zeta * omega * (c * cos + s * sin));
    (x + at_end.0, v + at_end.1)
}

/// Errors of coordinate and rate after one step over the last three quarters of a tick of `tick_s` s.
fn error_in_flight(tick_s: f64) -> (f64, f64) {
    let params = linear(5.0, 0.05, 20e-3);
    let rig = Rig::<f64>::new(&params).unwrap();
    let mut drive = Drive::<f64>::new(7.0, tick_s).unwrap();
    // 20 ms on: the drive stands somewhere within its period.
    while f64::from(drive.now().phase) / TURN < 0.139 {
        drive.advance();
    }
    let (x, v) = (1e-3, 0.05);
    let drive_omega = drive.angular_frequency();
    let span = Span {
        drive: &drive,
        drive_acceleration: params.amplitude_m * drive_omega * drive_omega,
        cart: None,
        from: 0.25,
        to: 1.0,
    };
    let mut state = HammerState::new(&rig, x - params.gap_m, v);
    Corrected.advance(&rig, &span, &mut state, &mut Ledger::default());
    let phase = TAU * f64::from(drive.now().phase) / TURN + 0.25 * tick_s * drive_omega;
    let driven = (span.drive_acceleration, drive_omega, phase);
    let known = oscillator((5.0 * TAU, 0.05), driven, (x, v), 0.75 * tick_s);
    (state.q.hi + params.gap_m - known.0, state.v.hi - known.1)
}

#[test]
fn a_step_in_flight_is_of_fourth_order() {
    let (coarse, fine) = (error_in_flight(2e-3), error_in_flight(1e-3));
    let ratios = (coarse.0 / fine.0, coarse.1 / fine.1);
    // The error of one step goes with the fifth power of its length: 32.
    assert!((24.0..44.0).contains(&ratios.0), "{ratios:?}");
    assert!((24.0..44.0).contains(&ratios.1), "{ratios:?}");
}

/// A hammer that practically nothing but the surface acts on.
fn free() -> RigParams {
    RigParams {
        amplitude_m: 1e-6,
        ..linear(1e-3, 0.0, 0.0)
    }
}

/// One step of `tick_s` s within a contact: impulse and work, and what they must be.
fn balances_in_contact(tick_s: f64) -> [(f64, f64); 2] {
    let rig = Rig::<f64>::new(&free()).unwrap();
    let drive = Drive::<f64>::new(0.1, tick_s).unwrap();
    let span = Span {
        drive: &drive,
        drive_acceleration: 0.0,
        cart: None,
        from: 0.0,
        to: 1.0,
    };
    let before = HammerState::new(&rig, 2e-6, 0.07);
    assert_eq!(before.mode, SwitchMode::Contact);
    let mut after = before;
    let mut ledger = Ledger::default();
    ledger.onset(drive.now(), 0.08);
    Corrected.advance(&rig, &span, &mut after, &mut ledger);
    assert_eq!(after.mode, SwitchMode::Contact);
    ledger.release(drive.now(), 0.0);
    let seen = ledger.take_finished().unwrap();
    let lost = 0.5 * MASS_KG * (before.v.hi * before.v.hi - after.v.hi * after.v.hi);
    [
        (seen.impulse, MASS_KG * (before.v.hi - after.v.hi)),
        (seen.energy_lost, lost),
    ]
}

#[test]
fn impulse_is_the_momentum_given_and_work_the_energy_given() {
    let [impulse, coarse] = balances_in_contact(20e-6);
    assert!((impulse.0 / impulse.1 - 1.0).abs() < 1e-9, "{impulse:?}");
    let [_, fine] = balances_in_contact(10e-6);
    let errors = (coarse.0 - coarse.1, fine.0 - fine.1);
    assert!((errors.0 / coarse.1).abs() < 1e-7, "{coarse:?}");
    assert!(errors.0 / errors.1 > 24.0, "{errors:?}");
}

#[test]
fn what_rounding_dropped_from_the_rate_still_moves_the_hammer() {
    let rig = Rig::<f32>::new(&RigParams {
        gap_m: 1e-3,
        ..free()
    })
    .unwrap();
    let drive = Drive::<f32>::new(0.1, 50e-6).unwrap();
    let span = Span {
        drive: &drive,
        drive_acceleration: 0.0,
        cart: None,
        from: 0.0,
        to: 1.0,
    };
    let mut state = HammerState::new(&rig, -1e-3, 0.0);
    // A sixtieth of what f32 resolves beside the rate of 0.
    state.v.lo = 0.02;
    Corrected.advance(&rig, &span, &mut state, &mut Ledger::default());
    let moved = f64::from(state.q.hi) + f64::from(state.q.lo) + 1e-3;
    assert!((moved / 1e-6 - 1.0).abs() < 1e-3, "{moved}");
}

#[test]
fn a_hammer_at_rest_stays_there() {
    for gap_m in [-0.5e-3, 0.0, 2e-3] {
        for params in [WIRES, BEAM_170] {
            let rig = Rig::<f64>::new(&RigParams { gap_m, ..params }).unwrap();
            let drive = Drive::<f64>::new(1.0, 50e-6).unwrap();
            let span = Span {
                drive: &drive,
                drive_acceleration: 0.0,
                cart: None,
                from: 0.0,
                to: 1.0,
            };
            let rest = HammerState::at_rest(&rig);
            let pressed = gap_m < 0.0;
            assert_eq!(rest.mode == SwitchMode::Contact, pressed, "{gap_m}");
            let mut state = rest;
            for _ in 0..100 {
                Corrected.advance(&rig, &span, &mut state, &mut Ledger::default());
            }
            assert_eq!(state.mode, rest.mode);
            assert!((state.q.hi - rig.rest()).abs() < 1e-12, "{gap_m}");
            let force = Corrected.force(&rig, &state);
            assert_eq!(force > 0.0, pressed, "{gap_m}: {force}");
        }
    }
}

/// The free hammer meets the surface at 0.08 m/s, `ticks` ticks after the start: its contact as recorded, and when it
/// began, in ticks.
fn contact(stepper: impl Stepper<f64>, tick_s: f64, ticks: f64) -> (f64, Contact<f64>) {
    contact_of(TABLE_3_1, stepper, tick_s, ticks)
}

fn contact_of(
    law: Law<f64>,
    stepper: impl Stepper<f64>,
    tick_s: f64,
    ticks: f64,
) -> (f64, Contact<f64>) {
    let rig = Rig::<f64>::new(&RigParams {
        contact: law,
        ..free()
    })
    .unwrap();
    let mut drive = Drive::<f64>::new(100.0, tick_s).unwrap();
    let mut state = HammerState::new(&rig, -0.08 * tick_s * ticks, 0.08);
    let mut ledger = Ledger::default();
    let start = drive.now();
    for _ in 0..100_000 {
        let span = Span {
            drive: &drive,
            drive_acceleration: 0.0,
            cart: None,
            from: 0.0,
            to: 1.0,
        };
        stepper.advance(&rig, &span, &mut state, &mut ledger);
        drive.advance();
        if let Some(contact) = ledger.take_finished() {
            let onset = contact.onset.turns_since(start) / (100.0 * tick_s);
            assert_eq!(state.mode, SwitchMode::Flight);
            assert_eq!(stepper.force(&rig, &state).max(0.0), 0.0);
            return (onset, contact);
        }
    }
    panic!("the hammer does not rebound");
}

/// The contact of Table 3.1 at 0.08 m/s in closed form: duration, rebound speed, peak force. With cos ψ = ζ the force
/// goes with −sin(ωt − 2ψ) under a decaying exponential.
fn known() -> (f64, f64, f64) {
    let Law::SpringDashpot { stiffness, damping } = TABLE_3_1 else {
        panic!("Table 3.1 has a spring-dashpot");
    };
    let omega = (stiffness / MASS_KG).sqrt();
    let psi = (0.5 * damping / (stiffness * MASS_KG).sqrt()).acos();
    let damped = omega * psi.sin();
    let peak_at = (3.0 * psi - core::f64::consts::PI) / damped;
    (
        2.0 * psi / damped,
        0.08 * (-2.0 * psi / psi.tan()).exp(),
        MASS_KG * 0.08 * omega * (-psi.cos() * omega * peak_at).exp(),
    )
}

/// Asserts that a contact is the known one within a share `within`.
fn is_known(what: &str, found: &Contact<f64>, within: f64) {
    let (duration, rebound, peak) = known();
    let lost = 0.5 * MASS_KG * (0.08 * 0.08 - rebound * rebound);
    for (quantity, value, wanted) in [
        ("duration", found.duration_s, duration),
        ("approach", found.approach_speed, 0.08),
        ("rebound", found.rebound_speed, rebound),
        ("peak", found.peak_force, peak),
        ("impulse", found.impulse, MASS_KG * (0.08 + rebound)),
        ("energy", found.energy_lost, lost),
    ] {
        let off = value / wanted - 1.0;
        assert!(
            off.abs() <= within,
            "{what}, {quantity}: {value}, {wanted}, {off:e}"
        );
    }
}

#[test]
fn a_corrected_contact_is_that_of_the_closed_form_wherever_in_a_tick_it_begins() {
    for ticks in [1.05, 1.3, 1.5, 1.7, 1.95] {
        let (onset, found) = contact(Corrected, 50e-6, ticks);
        assert!((onset - ticks).abs() < 1e-6, "{onset} for {ticks}");
        is_known("corrected", &found, 1e-3);
        let length = found.release.turns_since(found.onset) / 100.0;
        assert!((length / found.duration_s - 1.0).abs() < 1e-6, "{length}");
    }
}

#[test]
fn a_thin_band_and_a_narrow_transition_approach_the_closed_form() {
    let tick_s = 0.05e-6;
    let band = Band::new(1e-11, 1e-6);
    let (onset, found) = contact(Banded { band }, tick_s, 1.5);
    assert_eq!(onset.round(), 2.0, "recorded at the end of its tick");
    is_known("banded", &found, 2e-3);
    let smoothed = Smoothed {
        epsilon_alpha: 1e-10,
        epsilon_beta: 1e-3,
    };
    let (onset, found) = contact(smoothed, tick_s, 1.5);
    assert_eq!(onset.round(), 2.0, "recorded at the end of its tick");
    is_known("smoothed", &found, 2e-3);
}

#[test]
fn the_smoothed_force_rises_by_arctangents_of_penetration_and_force() {
    let smoothed = Smoothed::<f64> {
        epsilon_alpha: 2e-6,
        epsilon_beta: 8.0,
    };
    let close = |found: f64, wanted: f64| {
        assert!((found / wanted - 1.0).abs() < 1e-12, "{found}, {wanted}");
    };
    // ½ + atan(0)/π = ½, ½ + atan(1)/π = ¾, ½ + atan(−1)/π = ¼.
    close(smoothed.blended(0.0, 8.0), 8.0 * 0.5 * 0.75);
    close(smoothed.blended(2e-6, 8.0), 8.0 * 0.75 * 0.75);
    close(smoothed.blended(-2e-6, -8.0), -8.0 * 0.25 * 0.25);
    let rig = Rig::<f64>::new(&free()).unwrap();
    let state = HammerState::new(&rig, 2e-6, 0.01);
    let law = 2e-6 * 5.5e6 + 0.01 * 1.2e3;
    close(smoothed.force(&rig, &state), smoothed.blended(2e-6, law));
}

#[test]
fn with_every_law_the_steppers_agree_and_the_corrected_one_finds_the_onset() {
    for (name, law) in LAWS {
        let mut onsets = [1.05, 1.5, 1.95].map(|ticks| {
            let (onset, _) = contact_of(law, Corrected, 50e-6, ticks);
            (onset - ticks).abs()
        });
        onsets.sort_by(f64::total_cmp);
        assert!(onsets[2] < 1e-6, "{name}: {onsets:?}");
        let tick_s = 0.05e-6;
        let (_, wanted) = contact_of(law, Corrected, tick_s, 1.5);
        let band = Band::new(1e-11, 1e-6);
        let smoothed = Smoothed {
            epsilon_alpha: 1e-10,
            epsilon_beta: 1e-3,
        };
        for (_, found) in [
            contact_of(law, Banded { band }, tick_s, 1.5),
            contact_of(law, smoothed, tick_s, 1.5),
        ] {
            for (found, wanted) in [
                (found.impulse, wanted.impulse),
                (found.rebound_speed, wanted.rebound_speed),
                (found.peak_force, wanted.peak_force),
            ] {
                assert!(
                    (found / wanted - 1.0).abs() < 5e-3,
                    "{name}: {found}, {wanted}"
                );
            }
        }
    }
}

#[test]
fn the_force_of_the_band_s_model_is_that_of_its_subspace() {
    let rig = Rig::<f64>::new(&free()).unwrap();
    let banded = Banded {
        band: Band::new(1e-6, 0.0),
    };
    let force = |q, v| banded.force(&rig, &HammerState::new(&rig, q, v));
    assert_eq!(force(2e-6, 0.01), 2e-6 * 5.5e6 + 0.01 * 1.2e3);
    assert_eq!(force(0.0, 0.08), 96.0);
    assert_eq!(force(-2e-6, 0.08), 0.0);
}

/// Laws that strike as softly as the presets', and up to a hundred times harder.
fn nonlinear_laws() -> impl Iterator<Item = Law<f64>> {
    [1e8, 1e9, 1e10].into_iter().flat_map(|stiffness| {
        let exponent = 1.5;
        [
            Law::Hertz {
                stiffness,
                exponent,
            },
            Law::HuntCrossley {
                stiffness,
                exponent,
                damping_ratio: 4.0,
            },
            Law::HuntCrossley {
                stiffness,
                exponent: 1.7,
                damping_ratio: 36.0,
            },
            Law::LankaraniNikravesh {
                stiffness,
                exponent,
                restitution: 0.5,
            },
        ]
    })
}

#[test]
fn a_nonlinear_contact_at_50_us_is_that_of_a_fine_tick() {
    for law in nonlinear_laws() {
        let (_, wanted) = contact_of(law, Corrected, 0.5e-6, 1.5);
        for ticks in [1.01, 1.3, 1.5, 1.7, 1.99] {
            let (_, found) = contact_of(law, Corrected, 50e-6, ticks);
            for (what, found, wanted) in [
                ("peak", found.peak_force, wanted.peak_force),
                ("rebound", found.rebound_speed, wanted.rebound_speed),
                ("impulse", found.impulse, wanted.impulse),
                ("duration", found.duration_s, wanted.duration_s),
            ] {
                let off = found / wanted - 1.0;
                assert!(off.abs() < 2e-4, "{law:?} {ticks} {what}: {off:.1e}");
            }
        }
    }
}

#[test]
fn a_contact_too_hard_for_the_tick_is_noted_with_a_tick_that_suits_it() {
    let law = |stiffness| Law::Hertz {
        stiffness,
        exponent: 1.5,
    };
    let needed = |stiffness: f64, tick_s: f64| {
        let rig = Rig::<f64>::new(&RigParams {
            contact: law(stiffness),
            ..free()
        })
        .unwrap();
        let drive = Drive::<f64>::new(100.0, tick_s).unwrap();
        let mut twin = crate::model::twin::Twin::new(
            rig,
            drive,
            Corrected,
            HammerState::new(&rig, -0.08 * 60e-6, 0.08),
        );
        for _ in 0..(2e-3 / tick_s) as usize {
            twin.tick();
        }
        twin.tick_needed_s()
    };
    assert_eq!(needed(1e10, 50e-6), None);
    let short = needed(1e14, 50e-6).expect("more pieces than a tick has");
    assert!(short < 50e-6);
    assert_eq!(needed(1e14, 0.9 * short), None);
}
