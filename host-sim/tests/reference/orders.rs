//! How the steppers' errors fall with the tick.

use numerics::engine::{Machine, Switch};
use numerics::orbit::{Orbit, shoot};
use numerics::reference::Reference;
use shared::model::contact::TABLE_3_1;
use shared::model::drive::Drive;
use shared::model::params::{BEAM_150, RigParams};
use shared::model::step::{Banded, Corrected, Smoothed, Stepper};
use shared::model::switch::Band;

use crate::support::{close, stepped_contact};

const MASS_KG: f64 = 0.298;
const APPROACH: f64 = 0.08;
const RESTITUTION: f64 = 0.316_901_786_787_166;

/// Root mean square of the relative error of the rebound of a free mass, over onsets anywhere in a tick.
fn rebound_error(stepper: impl Stepper<f64> + Copy, tick_s: f64) -> f64 {
    const ONSETS: u32 = 50;
    let squares = (0..ONSETS).map(|k| {
        let onset = 2.0 + (f64::from(k) + 0.5) / f64::from(ONSETS);
        let case = (MASS_KG, TABLE_3_1, APPROACH);
        let seen = stepped_contact::<f64, _>(stepper, case, tick_s, onset);
        (seen.rebound_speed / (RESTITUTION * APPROACH) - 1.0).powi(2)
    });
    (squares.sum::<f64>() / f64::from(ONSETS)).sqrt()
}

/// Orders between successive halvings.
fn orders(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|w| (w[0] / w[1]).log2()).collect()
}

#[test]
fn the_corrected_stepper_is_of_fourth_order_across_a_contact() {
    let errors = [100e-6, 50e-6, 25e-6, 12.5e-6, 6.25e-6].map(|h| rebound_error(Corrected, h));
    let found = orders(&errors);
    println!("{errors:?} {found:?}");
    assert!(found.iter().all(|p| *p > 3.5), "{errors:?} {found:?}");
}

#[test]
fn without_correction_it_is_of_first_order_at_best() {
    let band = Band::new(1e-12, 0.0);
    let errors = [50e-6, 25e-6, 12.5e-6, 6.25e-6].map(|h| rebound_error(Banded { band }, h));
    let found = orders(&errors);
    println!("{errors:?} {found:?}");
    assert!(
        found.iter().all(|p| (0.5..1.6).contains(p)),
        "{errors:?} {found:?}"
    );
}

fn params() -> RigParams {
    RigParams {
        gap_m: 1e-3,
        ..BEAM_150
    }
}

/// The shortest tick below, s; the others are its multiples.
const FINEST_S: f64 = 6.25e-6 / 32.0;

/// The settled orbit at the frequency a drive with the finest tick really runs at, which all share.
fn orbit() -> Orbit {
    let asked = 1.5 * params().natural_frequency_hz();
    let frequency_hz = Drive::<f64>::new(asked, FINEST_S).unwrap().frequency_hz();
    let mut hammer = Reference::<f64>::at_rest(&params(), frequency_hz).unwrap();
    for _ in 0..200 {
        hammer.run_period(&mut ());
    }
    shoot(&params(), frequency_hz, hammer.state().into()).expect("a 1/1 orbit")
}

/// Largest relative error of the peak force over some periods, started on the orbit.
fn orbit_error(orbit: &Orbit, stepper: impl Stepper<f64>, tick_s: f64, periods: u32) -> f64 {
    let (params, section) = (params(), orbit.section);
    let mut stepped =
        Switch::<f64, _>::new(stepper, (&params, orbit.frequency_hz, tick_s, section)).unwrap();
    close(
        "frequency",
        stepped.frequency_hz(),
        orbit.frequency_hz,
        1e-13,
    );
    let errors = (0..periods).map(|_| stepped.period(None).peak_force / orbit.force_n - 1.0);
    errors.fold(0.0, |max, e| max.max(e.abs()))
}

#[test]
fn the_corrected_stepper_is_of_fourth_order_on_an_orbit() {
    let orbit = orbit();
    let errors = [400e-6, 200e-6, 100e-6, 50e-6, 25e-6, 12.5e-6]
        .map(|tick_s| orbit_error(&orbit, Corrected, tick_s, 100));
    let found = orders(&errors);
    println!("{errors:?} {found:?}");
    let overall = (errors[0] / errors[5]).log2() / 5.0;
    assert!(overall > 3.5, "{errors:?} {found:?}");
}

#[test]
fn the_reference_does_not_depend_on_its_own_steps() {
    // The same orbit cut into more pieces: stop and restart at every section, where steps begin anew.
    let orbit = orbit();
    let mut whole = Reference::<f64>::new(
        &params(),
        orbit.frequency_hz,
        orbit.section[0],
        orbit.section[1],
    )
    .unwrap();
    let mut pieces = whole;
    for _ in 0..20 {
        whole.run_period(&mut ());
        pieces.run_period(&mut ());
        let (q, v) = pieces.state();
        pieces = Reference::new(&params(), orbit.frequency_hz, q, v).unwrap();
    }
    let (a, b) = (whole.state(), pieces.state());
    assert!((a.0 - b.0).abs() < 1e-13, "{:e}", a.0 - b.0);
    assert!((a.1 - b.1).abs() < 1e-12, "{:e}", a.1 - b.1);
}

#[test]
fn the_smoothing_method_converges_on_a_periodic_point_if_the_step_follows() {
    let orbit = orbit();
    let at = |epsilon_m: f64, tick_s: f64| {
        let smoothed = Smoothed {
            epsilon_alpha: epsilon_m,
            epsilon_beta: epsilon_m * 1e7,
        };
        orbit_error(&orbit, smoothed, tick_s, 4)
    };
    let errors = [1e-6, 2.5e-7, 6.25e-8].map(|epsilon_m| at(epsilon_m, FINEST_S));
    println!("{errors:?} coarse {}", at(6.25e-8, 50e-6));
    assert!(errors[0] > 1.5 * errors[1], "{errors:?}");
    assert!(errors[1] > 1.5 * errors[2], "{errors:?}");
    let coarse = at(6.25e-8, 50e-6);
    assert!(coarse > 20.0 * errors[2], "{coarse:e} at 50 µs, {errors:?}");
}
