//! One contact of a free mass through the spring-dashpot: known in closed form.

use std::f64::consts::{PI, TAU};

use shared::model::contact::TABLE_3_1;
use shared::model::drive::Drive;
use shared::model::rig::Rig;
use shared::model::step::{Banded, Corrected, HammerState};
use shared::model::switch::Band;
use shared::model::twin::Twin;

use crate::support::{STANDSTILL_HZ, close, free_mass, reference_contact, stepped_contact};

const MASS_KG: f64 = 0.298;
const KI: f64 = 5.5e6;
const CI: f64 = 1.2e3;
const APPROACH: f64 = 0.08;

/// δ(t) = (v/ω_d) exp(−ζω₀t) sin ω_d t until F = −m δ̈ falls to 0. With cos φ = ζ:
/// δ̇ ∝ −sin(ω_d t − φ), F ∝ −sin(ω_d t − 2φ), Ḟ ∝ −sin(ω_d t − 3φ).
struct ClosedForm {
    frequency_hz: f64,
    zeta: f64,
    duration_s: f64,
    restitution: f64,
    peak_n: f64,
    peak_at_s: f64,
}

fn closed_form() -> ClosedForm {
    let omega = (KI / MASS_KG).sqrt();
    let zeta = CI / (2.0 * (KI * MASS_KG).sqrt());
    let root = (1.0 - zeta * zeta).sqrt();
    let phi = zeta.acos();
    let damped = omega * root;
    let peak_at_s = (3.0 * phi - PI) / damped;
    ClosedForm {
        frequency_hz: omega / TAU,
        zeta,
        duration_s: 2.0 * phi / damped,
        restitution: (-2.0 * zeta / root * (root / zeta).atan()).exp(),
        peak_n: MASS_KG * APPROACH * omega * (-zeta * omega * peak_at_s).exp(),
        peak_at_s,
    }
}

#[test]
fn the_formulas_give_the_known_figures() {
    let known = closed_form();
    close("frequency", known.frequency_hz, 684.0, 1e-3);
    close("damping ratio", known.zeta, 0.469, 1e-3);
    close("duration", known.duration_s, 0.571e-3, 1e-3);
    close("restitution", known.restitution, 0.317, 1e-3);
}

#[test]
fn the_reference_agrees_to_ten_digits() {
    let known = closed_form();
    let seen = reference_contact(MASS_KG, TABLE_3_1, APPROACH);
    close("duration", seen.duration_s, known.duration_s, 1e-10);
    let restitution = seen.rebound_speed_m_per_s / seen.approach_speed_m_per_s;
    close("restitution", restitution, known.restitution, 1e-10);
    close("peak", seen.peak_force_n, known.peak_n, 1e-10);
    let peak_at = seen.peak_at_s - seen.onset_s;
    close("time of peak", peak_at, known.peak_at_s, 1e-4);
    close("onset", seen.onset_s, 1e-4, 1e-10);
    let impulse = MASS_KG * APPROACH * (1.0 + known.restitution);
    close("impulse", seen.impulse_n_s, impulse, 1e-10);
    let lost = 0.5 * MASS_KG * APPROACH * APPROACH * (1.0 - known.restitution.powi(2));
    close("energy lost", seen.energy_lost_j, lost, 1e-10);
}

/// Largest relative errors of (duration, restitution, peak) over onsets anywhere in the tick.
fn worst_corrected<R: shared::Real>(tick_s: f64) -> [f64; 3] {
    let known = closed_form();
    let mut worst = [0.0_f64; 3];
    for k in 0..20 {
        let case = (MASS_KG, TABLE_3_1, APPROACH);
        let seen = stepped_contact::<R, _>(Corrected, case, tick_s, f64::from(k) / 20.0 + 2.01);
        let restitution = seen.rebound_speed.to_f64() / seen.approach_speed.to_f64();
        let errors = [
            seen.duration_s.to_f64() / known.duration_s,
            restitution / known.restitution,
            seen.peak_force.to_f64() / known.peak_n,
        ];
        for (worst, ratio) in worst.iter_mut().zip(errors) {
            *worst = worst.max((ratio - 1.0).abs());
        }
    }
    worst
}

#[test]
fn the_corrected_stepper_agrees_wherever_in_the_tick_the_onset_falls() {
    let bounds = [
        // tick, f64 bound, f32 bound
        (10e-6, 1e-7, 4e-7),
        (50e-6, 6e-5, 6e-5),
    ];
    for (tick_s, fine, coarse) in bounds {
        let double = worst_corrected::<f64>(tick_s);
        let single = worst_corrected::<f32>(tick_s);
        println!("{tick_s}: f64 {double:?} f32 {single:?}");
        assert!(double.iter().all(|e| *e < fine), "{tick_s}: {double:?}");
        assert!(single.iter().all(|e| *e < coarse), "{tick_s}: {single:?}");
    }
}

/// Crossing the band, the damper alone takes 2 η_α ci/m of speed. Half of that, below the surface, is also
/// taken in truth; the half above it is what the band adds.
#[test]
fn the_band_takes_two_eta_ci_over_m_of_speed_half_of_it_unduly() {
    let known = closed_form();
    for eta in [1e-6, 1e-7, 1e-8] {
        let band = Band::<f64>::new(eta, 0.0);
        let case = (MASS_KG, TABLE_3_1, APPROACH);
        let lead_ticks = (2.0 * eta / (APPROACH * 2e-9)).ceil();
        let seen = stepped_contact(Banded { band }, case, 2e-9, lead_ticks);
        let unduly = APPROACH - seen.rebound_speed / known.restitution;
        let expected = eta * CI / MASS_KG;
        println!("{eta}: {unduly} {expected}");
        close("speed taken", unduly, expected, 0.05);
    }
}

/// It also traps rebounds slower than ki η_α/ci, since on the way out Σα's damper pulls wherever F > 0.
#[test]
fn the_band_traps_a_slow_hammer() {
    let eta = 1e-6;
    let band = Band::<f64>::new(eta, 0.0);
    let crossing = 2.0 * eta * CI / MASS_KG;
    for (times, trapped) in [(0.95, true), (1.05, true), (4.0, false)] {
        let rig = Rig::<f64>::new(&free_mass(MASS_KG, TABLE_3_1)).unwrap();
        let state = HammerState::new(&rig, -1.1 * eta, times * crossing);
        let drive = Drive::new(STANDSTILL_HZ, 1e-7).unwrap();
        let mut twin = Twin::new(rig, drive, Banded { band }, state);
        let rebounds = (0..100_000).any(|_| twin.tick().contact.is_some());
        assert_eq!(rebounds, !trapped, "at {times} of what crossing takes");
    }
}
