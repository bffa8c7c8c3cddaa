//! What the tests share.

use numerics::reference::{LocatedContact, Reference};
use shared::model::contact::Law;
use shared::model::drive::Drive;
use shared::model::params::{BEAM_170, RigParams, SupportParams};
use shared::model::rig::Rig;
use shared::model::scalar::Real;
use shared::model::step::{HammerState, Stepper};
use shared::model::twin::Twin;

/// Drive frequency of [`free_mass`], Hz: so slow that nothing happens during a contact.
pub const STANDSTILL_HZ: f64 = 0.1;

/// A mass that nothing but the surface acts on: beams so soft and a drive so small and slow that their
/// accelerations stay below 1e-12 of a contact's.
pub fn free_mass(mass_kg: f64, contact: Law<f64>) -> RigParams {
    RigParams {
        support: SupportParams::Beams {
            natural_frequency_hz: 1e-3,
            damping_ratio: 0.0,
            cubic_stiffness_n_per_m3: Some(0.0),
        },
        mass_kg,
        amplitude_m: 1e-6,
        gap_m: 0.0,
        contact,
        ..BEAM_170
    }
}

/// One contact of a free mass, by the reference.
pub fn reference_contact(mass_kg: f64, law: Law<f64>, approach: f64) -> LocatedContact {
    let params = free_mass(mass_kg, law);
    let q = -1e-4 * approach;
    let mut hammer = Reference::<f64>::new(&params, STANDSTILL_HZ, q, approach).unwrap();
    let mut contacts = Vec::new();
    hammer.run_period(&mut contacts);
    assert_eq!(contacts.len(), 1);
    contacts[0]
}

/// One contact of a free mass, by a stepper of `shared`, `onset_ticks` ticks after the start.
pub fn stepped_contact<R: Real, S: Stepper<R>>(
    stepper: S,
    (mass_kg, law, approach): (f64, Law<f64>, f64),
    tick_s: f64,
    onset_ticks: f64,
) -> shared::model::contacts::Contact<R> {
    let rig = Rig::<R>::new(&free_mass(mass_kg, law)).unwrap();
    let q = -approach * tick_s * onset_ticks;
    let state = HammerState::new(&rig, R::from_f64(q), R::from_f64(approach));
    let drive = Drive::new(STANDSTILL_HZ, tick_s).unwrap();
    let mut twin = Twin::new(rig, drive, stepper, state);
    (0..1_000_000)
        .find_map(|_| twin.tick().contact)
        .expect("the mass rebounds")
}

/// Asserts |a − b| ≤ relative·|b|.
#[track_caller]
pub fn close(what: &str, a: f64, b: f64, relative: f64) {
    let error = (a - b).abs() / b.abs();
    assert!(
        error <= relative,
        "{what}: {a} against {b}, off by {error:.2e}"
    );
}
