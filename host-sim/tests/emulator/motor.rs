//! The motor drive: in the limit of a heavy flywheel the cart's motion is prescribed; it slips by its load; energy
//! balances.

use emulator::bodies::BodiesState;
use emulator::cart::{Friction, Mounting};
use emulator::motor::MotorParams;
use emulator::plant::{Plant, ShakerDrive};
use emulator::shaker::SetPointPath;
use shared::model::params::{BEAM_150, RigParams, WIRES};
use std::f64::consts::TAU;

use crate::mounting::{free_hammer, missing_j};
use crate::support::{TICK_S, on_the_sine, prescribed, rest, sine};

fn plant(params: &RigParams, motor: &MotorParams, mounting: &Mounting) -> Plant {
    Plant::mounted(params, &ShakerDrive::Motor(*motor), mounting, TICK_S).unwrap()
}

#[test]
fn a_heavy_flywheel_prescribes_the_motion() {
    for params in [WIRES, BEAM_150] {
        let hz = 2.0 * params.natural_frequency_hz();
        let motor = MotorParams {
            inertia_kg_m2: 1e6,
            ..MotorParams::for_cart(params.amplitude_m, 5.7)
        };
        let mut turned = plant(&params, &motor, &Mounting::default());
        turned.set_motor_hz(hz);
        let start = on_the_sine(&params, hz, rest(&params), 0.0);
        turned.set_state(BodiesState {
            u: TAU * hz,
            ..start
        });
        let mut led = prescribed(&params, TICK_S);
        led.set_state(start);
        let (mut a, mut b) = (Vec::new(), Vec::new());
        for k in 0..(10.0 / hz / TICK_S) as u64 {
            turned.tick(SetPointPath::default(), true);
            led.tick(sine(&params, hz, TICK_S, k), true);
            a.extend_from_slice(turned.finished());
            b.extend_from_slice(led.finished());
        }
        assert!(a.len() > 5 && a.len() == b.len());
        for (a, b) in a.iter().zip(&b) {
            assert!(
                (a.peak_force_n / b.peak_force_n - 1.0).abs() < 1e-6,
                "{a:?} {b:?}"
            );
            assert!((a.onset_s - b.onset_s).abs() < 1e-8);
        }
    }
}

#[test]
fn it_slips_by_its_load() {
    let params = free_hammer();
    let motor = MotorParams {
        crank_m: 0.01,
        rod_ratio: 0.0,
        inertia_kg_m2: 0.5,
        slip_hz_per_n_m: 0.5,
        torque_n_m: 10.0,
        lag_s: 0.1,
        coast_s: 0.5,
    };
    let friction = Friction {
        coulomb_n: 0.0,
        static_n: 0.0,
        viscous_n_s_per_m: 100.0,
    };
    let mounting = Mounting {
        friction: Some(friction),
        ..Mounting::default()
    };
    let mut plant = plant(&params, &motor, &mounting);
    plant.set_motor_hz(4.0);
    let speed = 0.01 * TAU * 4.0;
    plant.set_state(BodiesState {
        q: -0.2,
        v: -speed,
        w: speed,
        u: TAU * 4.0,
        ..BodiesState::default()
    });
    let before = plant.bodies().energy_j(plant.state());
    for _ in 0..300_000 {
        plant.tick(SetPointPath::default(), true);
    }
    // Ten turns and more: a hundred seconds would not change the fourth digit.
    let from = plant.state().z;
    for _ in 0..100_000 {
        plant.tick(SetPointPath::default(), true);
    }
    let hz = (plant.state().z - from) / TAU / 5.0;
    // Mean torque b r² Ω/2, and what it costs in speed.
    let per_hz = 0.5 * 100.0 * 0.01 * 0.01 * TAU;
    let want = 4.0 / (1.0 + 0.5 * per_hz);
    assert!((hz / want - 1.0).abs() < 5e-4, "{hz} against {want}");
    let off = missing_j(&plant, before).abs() / plant.totals().shaker_work;
    assert!(off < 1e-9, "{off:.1e}");
    // Without power it runs down.
    for _ in 0..100_000 {
        plant.tick(SetPointPath::default(), false);
    }
    assert!(plant.state().u.abs() < 2e-3, "{}", plant.state().u);
}

#[test]
fn energy_balances_while_it_hammers_on_a_rod_and_the_cart_keeps_to_its_crank() {
    for params in [WIRES, BEAM_150] {
        let hz = 1.9 * params.natural_frequency_hz();
        let motor = MotorParams {
            rod_ratio: 0.25,
            ..MotorParams::for_cart(params.amplitude_m, params.cart_mass_kg + params.mass_kg)
        };
        let mut plant = plant(&params, &motor, &Mounting::default());
        plant.set_motor_hz(hz);
        let before = plant.bodies().energy_j(plant.state());
        let (mut blows, mut largest) = (0, 0.0_f64);
        for _ in 0..(40.0 / hz / TICK_S) as u64 {
            plant.tick(SetPointPath::default(), true);
            blows += plant.finished().len();
            largest = largest.max(plant.cart_m().abs());
        }
        assert!(blows > 10, "{blows}");
        assert!(largest < 1.2 * params.amplitude_m, "{largest}");
        // What the fast flow takes and gives is far more than what stays.
        let scale = plant.totals().shaker_work + plant.totals().contact_work;
        let off = missing_j(&plant, before).abs() / scale;
        println!("motor: {off:.1e}");
        assert!(off < 1e-6, "{off:.1e}");
        // Speed set-point less slip.
        let turning = plant.state().u / TAU;
        assert!((turning / hz - 1.0).abs() < 0.1, "{turning} of {hz}");
    }
}
