//! What the tests share.

use std::f64::consts::TAU;

use emulator::bodies::BodiesState;
use emulator::cart::Mounting;
use emulator::plant::{Plant, ShakerDrive};
use emulator::record::TrueContact;
use emulator::shaker::{SetPointPath, ShakerParams};
use shared::model::params::RigParams;
use shared::model::rig::Rig;

/// The controller's tick, s.
pub const TICK_S: f64 = 50e-6;

/// At rest, moved by `shaker`.
pub fn shaken(params: &RigParams, shaker: &ShakerParams, tick_s: f64) -> Plant {
    let drive = ShakerDrive::Shaker(*shaker);
    Plant::mounted(params, &drive, &Mounting::default(), tick_s).unwrap()
}

/// At rest, the cart moved along the set-point whatever force that takes.
pub fn prescribed(params: &RigParams, tick_s: f64) -> Plant {
    let mounting = Mounting::default();
    Plant::mounted(params, &ShakerDrive::Prescribed, &mounting, tick_s).unwrap()
}

/// The cart's course y = A0 sin Ωt over tick `k` of `tick_s`.
pub fn sine(params: &RigParams, frequency_hz: f64, tick_s: f64, k: u64) -> SetPointPath {
    let (amplitude, omega) = (params.amplitude_m, TAU * frequency_hz);
    let at = |k: u64| {
        let turns = (k as f64 * tick_s * frequency_hz).fract();
        let (sin, cos) = (TAU * turns).sin_cos();
        (amplitude * sin, amplitude * omega * cos)
    };
    SetPointPath::new(tick_s, at(k), at(k + 1))
}

/// On the sine at phase 0, with the hammer at coordinate `q` and rate `v` relative to the cart.
pub fn on_the_sine(params: &RigParams, frequency_hz: f64, q: f64, v: f64) -> BodiesState {
    BodiesState {
        q,
        v,
        y: 0.0,
        w: params.amplitude_m * TAU * frequency_hz,
        ..BodiesState::default()
    }
}

/// The hammer's coordinate at rest.
pub fn rest(params: &RigParams) -> f64 {
    Rig::<f64>::new(params).unwrap().rest()
}

/// Contacts of `plant` driven along the sine for `time_s`.
pub fn contacts(
    plant: &mut Plant,
    params: &RigParams,
    frequency_hz: f64,
    tick_s: f64,
    time_s: f64,
) -> Vec<TrueContact> {
    let mut contacts = Vec::new();
    for k in 0..(time_s / tick_s).round() as u64 {
        plant.tick(sine(params, frequency_hz, tick_s, k), true);
        contacts.extend_from_slice(plant.finished());
    }
    contacts
}
