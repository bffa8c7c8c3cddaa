//! Momentum and energy of both bodies: what goes in comes out.

use emulator::bodies::BodiesState;
use emulator::plant::Plant;
use emulator::shaker::{SetPointPath, ShakerParams};
use shared::model::contact::{LAWS, Law, TABLE_3_1};
use shared::model::params::{BEAM_150, PRESETS, RigParams, SupportParams, Torque, WIRES};

use crate::support::{TICK_S, shaken, sine};

/// Horizontal momentum of both bodies, fixed frame, kg·m/s.
fn momentum_of(plant: &Plant) -> f64 {
    let (bodies, state) = (plant.bodies(), plant.state());
    let at = bodies.kinematics(state);
    let m = bodies.rig.mass();
    (bodies.cart_mass_kg + m) * state.w + m * at.rate
}

/// A shaker that is not there.
fn no_shaker() -> ShakerParams {
    ShakerParams {
        suspension_hz: 1e-6,
        suspension_damping_ratio: 0.0,
        ..ShakerParams::default()
    }
}

/// Hammer and cart that nothing but the surface acts on.
fn free(contact: Law<f64>) -> RigParams {
    RigParams {
        support: SupportParams::Beams {
            natural_frequency_hz: 1e-6,
            damping_ratio: 0.0,
            cubic_stiffness_n_per_m3: Some(0.0),
        },
        contact,
        ..BEAM_150
    }
}

#[test]
fn one_blow_between_free_bodies_moves_the_momentum_it_says() {
    for (name, law) in LAWS {
        let params = free(law);
        let mut plant = shaken(&params, &no_shaker(), TICK_S);
        let speed = 0.08;
        plant.set_state(BodiesState {
            q: -0.37 * TICK_S * speed,
            v: speed,
            ..BodiesState::default()
        });
        let (m, cart) = (params.mass_kg, params.cart_mass_kg);
        let before = (m * speed, 0.0);
        let mut blows = Vec::new();
        for _ in 0..40 {
            plant.tick(SetPointPath::default(), false);
            blows.extend_from_slice(plant.finished());
        }
        let [blow] = blows[..] else {
            panic!("{name}: {} contacts", blows.len());
        };
        let state = plant.state();
        let (hammer, moved) = (m * (state.w + state.v), cart * state.w);
        let error = |change: f64| (change / blow.impulse_n_s - 1.0).abs();
        println!(
            "{name}: {:.1e} {:.1e}",
            error(before.0 - hammer),
            error(moved)
        );
        assert!(error(before.0 - hammer) < 1e-9, "{name}: hammer");
        assert!(error(moved) < 1e-9, "{name}: cart");
        let kinetic = 0.5 * m * (speed.powi(2) - (hammer / m).powi(2)) - 0.5 * moved.powi(2) / cart;
        // A work is quadratic in the motion and not kept exactly; δ^1.5 is not smooth at the onset.
        let lost = (kinetic - blow.energy_lost_j).abs() / (0.5 * m * speed.powi(2));
        assert!(lost < 2e-6, "{name}: energy off by {lost:.1e}");
    }
}

#[test]
fn two_free_bodies_meet_as_their_reduced_mass_does_a_wall() {
    let params = free(TABLE_3_1);
    let mut plant = shaken(&params, &no_shaker(), TICK_S);
    plant.set_state(BodiesState {
        q: -1e-6,
        v: 0.08,
        ..BodiesState::default()
    });
    while plant.finished().is_empty() {
        plant.tick(SetPointPath::default(), false);
    }
    let blow = plant.finished()[0];
    let reduced = params.mass_kg * params.cart_mass_kg / (params.mass_kg + params.cart_mass_kg);
    let omega = (5.5e6 / reduced).sqrt();
    let zeta = 1.2e3 / (2.0 * reduced * omega);
    let root = (1.0 - zeta * zeta).sqrt();
    // F falls to zero at ω_d t = π − ... : tan(ω_d t) = −2 ζ √(1−ζ²)/(1 − 2ζ²), as for a single mass.
    let turn = (2.0 * zeta * root).atan2(2.0 * zeta * zeta - 1.0);
    let duration = turn / (omega * root);
    let restitution = (-zeta / root * turn).exp();
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-8, "{a} against {b}");
    close(blow.duration_s, duration);
    close(
        blow.rebound_speed_m_per_s / blow.approach_speed_m_per_s,
        restitution,
    );
}

#[test]
fn energy_and_momentum_balance_while_the_shaker_drives() {
    let mut rigs: Vec<_> = PRESETS.to_vec();
    let mut corrected = WIRES;
    if let SupportParams::Wires { torque, .. } = &mut corrected.support {
        *torque = Torque::Cosine;
    }
    rigs.push(("wires, F l cos", corrected));
    for (name, params) in rigs {
        let hz = 1.9 * params.natural_frequency_hz();
        let mut plant = shaken(&params, &ShakerParams::default(), TICK_S);
        let energy = plant.bodies().energy_j(plant.state());
        let momentum = momentum_of(&plant);
        let mut blows = 0;
        for k in 0..(30.0 / hz / TICK_S) as u64 {
            plant.tick(sine(&params, hz, TICK_S, k), true);
            blows += plant.finished().len();
        }
        assert!(blows > 15, "{name}: {blows}");
        let totals = plant.totals();
        let stored = plant.bodies().energy_j(plant.state()) - energy;
        let balance = totals.shaker_work - totals.contact_work - totals.damping_work - stored;
        let gained = momentum_of(&plant) - momentum;
        let energy_off = balance.abs() / totals.contact_work;
        let momentum_off = (gained - totals.shaker_impulse).abs() / totals.impulse;
        println!("{name}: energy {energy_off:.1e}, momentum {momentum_off:.1e}");
        // RK4 at a fortieth of the loop's time constant.
        assert!(energy_off < 1e-7, "{name}: {energy_off:.1e}");
        assert!(momentum_off < 1e-9, "{name}: {momentum_off:.1e}");
    }
}

#[test]
fn a_blow_changes_the_carts_speed_by_up_to_a_quarter() {
    let hz = 2.0 * WIRES.natural_frequency_hz();
    let mut plant = shaken(&WIRES, &ShakerParams::default(), TICK_S);
    let mut impulse = 0.0_f64;
    for k in 0..(60.0 / hz / TICK_S) as u64 {
        plant.tick(sine(&WIRES, hz, TICK_S, k), true);
        for blow in plant.finished() {
            impulse = impulse.max(blow.impulse_n_s);
        }
    }
    let speed = WIRES.amplitude_m * std::f64::consts::TAU * hz;
    let share = impulse / WIRES.cart_mass_kg / speed;
    assert!((0.15..0.35).contains(&share), "{share}");
}

#[test]
fn a_push_changes_the_hammers_speed_and_an_idle_cart_comes_to_rest() {
    let params = RigParams {
        gap_m: 2.4e-3,
        ..WIRES
    };
    let mut plant = shaken(&params, &ShakerParams::default(), TICK_S);
    let momentum = momentum_of(&plant);
    plant.push(0.05);
    let gained = momentum_of(&plant) - momentum;
    assert!((gained - params.mass_kg * 0.05).abs() < 1e-15);
    let mut plant = shaken(&WIRES, &ShakerParams::default(), TICK_S);
    for k in 0..40_000 {
        plant.tick(sine(&WIRES, 3.6, TICK_S, k), k < 20_000);
    }
    assert!(plant.cart_m().abs() < 2e-5, "{}", plant.cart_m());
}
