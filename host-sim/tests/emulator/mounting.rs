//! Friction, end stops, tilt, an armature with a mode of its own and the shaker's impedance: each against a closed form,
//! and all of them together against the balance of energy.

use emulator::bodies::BodiesState;
use emulator::cart::{Friction, Mounting, Stops};
use emulator::plant::{Plant, ShakerDrive};
use emulator::shaker::{ArmatureParams, SetPointPath, ShakerParams};
use shared::model::contact::TABLE_3_1;
use shared::model::params::{BEAM_150, GRAVITY_M_PER_S2, RigParams, SupportParams, WIRES};
use std::f64::consts::TAU;

use crate::support::{TICK_S, sine};

/// A shaker that is not there while it is off.
fn loose() -> ShakerParams {
    ShakerParams {
        suspension_hz: 1e-6,
        suspension_damping_ratio: 0.0,
        ..ShakerParams::default()
    }
}

/// A hammer that nothing holds.
pub fn free_hammer() -> RigParams {
    RigParams {
        support: SupportParams::Beams {
            natural_frequency_hz: 1e-6,
            damping_ratio: 0.0,
            cubic_stiffness_n_per_m3: Some(0.0),
        },
        contact: TABLE_3_1,
        ..BEAM_150
    }
}

/// A cart that moves at `speed` past a hammer that stands still, far from its surface.
fn alone(speed: f64) -> BodiesState {
    BodiesState {
        q: -0.2,
        v: -speed,
        w: speed,
        ..BodiesState::default()
    }
}

fn plant(params: &RigParams, shaker: ShakerParams, mounting: Mounting, tick_s: f64) -> Plant {
    Plant::mounted(params, &ShakerDrive::Shaker(shaker), &mounting, tick_s).unwrap()
}

/// Energy that came in, less what was taken and what is there, J.
pub fn missing_j(plant: &Plant, before_j: f64) -> f64 {
    let totals = plant.totals();
    let taken = totals.contact_work + totals.damping_work + totals.cart_work;
    totals.shaker_work - taken - (plant.bodies().energy_j(plant.state()) - before_j)
}

#[test]
fn a_sliding_cart_slows_down_by_coulomb_friction_and_stays() {
    let friction = Friction {
        coulomb_n: 5.0,
        static_n: 5.0,
        viscous_n_s_per_m: 0.0,
    };
    let mounting = Mounting {
        friction: Some(friction),
        ..Mounting::default()
    };
    let params = free_hammer();
    let mut plant = plant(&params, loose(), mounting, TICK_S);
    let (speed, mass) = (0.05, params.cart_mass_kg);
    // Sliding already: the bristles are bent as far as they go.
    plant.set_state(BodiesState {
        p: 20e-6,
        ..alone(speed)
    });
    let before = plant.bodies().energy_j(plant.state());
    let stops_s = mass * speed / 5.0;
    let half = (0.5 * stops_s / TICK_S) as u64;
    for k in 0..20_000 {
        plant.tick(SetPointPath::default(), false);
        if k + 1 == half {
            let t = half as f64 * TICK_S;
            let (want, way) = (speed - 5.0 * t / mass, speed * t - 2.5 * t * t / mass);
            assert!((plant.state().w / want - 1.0).abs() < 1e-9);
            assert!((plant.cart_m() / way - 1.0).abs() < 1e-9);
        }
    }
    let way = 0.5 * mass * speed * speed / 5.0;
    assert!((plant.cart_m() - way).abs() < 30e-6, "{}", plant.cart_m());
    let off = missing_j(&plant, before) / (0.5 * mass * speed * speed);
    assert!(off.abs() < 1e-6, "{off:.1e}");
}

#[test]
fn a_tilted_cart_sticks_below_its_static_friction_and_slides_above_it() {
    let params = RigParams {
        gap_m: 3e-3,
        ..WIRES
    };
    let tilt_rad = 0.5_f64.to_radians();
    let mass = params.cart_mass_kg + params.mass_kg;
    let pull = mass * GRAVITY_M_PER_S2 * tilt_rad.sin();
    let slid = |coulomb: f64, fixed: f64, time_s: f64| {
        let mounting = Mounting {
            friction: Some(Friction {
                coulomb_n: coulomb * pull,
                static_n: fixed * pull,
                viscous_n_s_per_m: 0.0,
            }),
            stops: None,
            tilt_rad,
        };
        let mut plant = plant(&params, loose(), mounting, TICK_S);
        let hangs = *plant.state();
        // The bristles, which give way over 20 µm, hold it already.
        plant.set_state(BodiesState {
            q: hangs.q,
            p: 20e-6 / fixed.max(1.0),
            ..BodiesState::default()
        });
        for _ in 0..(time_s / TICK_S) as u64 {
            plant.tick(SetPointPath::default(), false);
        }
        plant.cart_m()
    };
    let stuck = slid(0.6, 1.1, 10.0);
    assert!(stuck.abs() < 1e-9, "{stuck}");
    let free = slid(0.6, 0.7, 2.0);
    let want = 0.5 * 0.4 * pull / mass * 4.0;
    assert!((free / want - 1.0).abs() < 0.02, "{free} against {want}");
}

#[test]
fn an_end_stop_gives_back_what_its_closed_form_says() {
    let (speed, damping): (f64, f64) = (0.5, 1.0);
    let stops = Stops {
        at_m: 5e-3,
        stiffness_n_per_m: 1e6,
        damping_s_per_m: damping,
    };
    let params = free_hammer();
    let rebound = |tick_s: f64| {
        let mounting = Mounting {
            stops: Some(stops),
            ..Mounting::default()
        };
        let mut plant = plant(&params, loose(), mounting, tick_s);
        plant.set_state(alone(speed));
        let before = plant.bodies().energy_j(plant.state());
        while plant.state().w > 0.0 || plant.cart_m() > stops.at_m {
            plant.tick(SetPointPath::default(), false);
        }
        let off = missing_j(&plant, before) / (0.5 * params.cart_mass_kg * speed * speed);
        assert!(off.abs() < 1e-4, "{off:.1e}");
        -plant.state().w
    };
    // v dv/(1 + λ v) integrates to the same on the way in and out; by bisection on the speed out.
    let level = |v: f64| damping * v - (damping * v).ln_1p();
    let (mut low, mut high) = (0.0, speed);
    for _ in 0..60 {
        let out = 0.5 * (low + high);
        if level(-out) < level(speed) {
            low = out;
        } else {
            high = out;
        }
    }
    let errors = [TICK_S, 0.25 * TICK_S].map(|tick_s| (rebound(tick_s) / low - 1.0).abs());
    println!("end stop: {errors:?}");
    assert!(
        errors[0] < 1e-4 && errors[1] < 0.3 * errors[0],
        "{errors:?}"
    );
}

#[test]
fn a_tilted_pendulum_hangs_in_the_tilt_and_swings_as_before() {
    let tilt_rad = 2.0_f64.to_radians();
    let mounting = Mounting {
        tilt_rad,
        ..Mounting::default()
    };
    let params = RigParams {
        gap_m: 3e-3,
        ..WIRES
    };
    let SupportParams::Wires { length_m, .. } = params.support else {
        panic!("wires");
    };
    let mut plant = Plant::mounted(&params, &ShakerDrive::Prescribed, &mounting, TICK_S).unwrap();
    let rest = length_m * tilt_rad.sin();
    for _ in 0..20_000 {
        plant.tick(SetPointPath::default(), false);
    }
    assert!(
        (plant.hammer_m() - rest).abs() < 1e-12,
        "{}",
        plant.hammer_m()
    );
    // The field is as strong as before, only its direction is another.
    plant.push(1e-3);
    let mut rises = Vec::new();
    let mut last = 0.0;
    for k in 0..80_000 {
        plant.tick(SetPointPath::default(), false);
        let past = plant.hammer_m() - rest;
        if last < 0.0 && past >= 0.0 {
            rises.push((f64::from(k) + last / (last - past)) * TICK_S);
        }
        last = past;
    }
    let period = (rises[5] - rises[0]) / 5.0;
    let want = TAU * (length_m / GRAVITY_M_PER_S2).sqrt();
    assert!(
        (period / want - 1.0).abs() < 1e-6,
        "{period} against {want}"
    );
}

#[test]
fn beams_and_a_cart_on_its_suspension_sag_in_a_tilt() {
    let tilt_rad = -1.5_f64.to_radians();
    let mounting = Mounting {
        tilt_rad,
        ..Mounting::default()
    };
    let shaker = ShakerParams::default();
    let mut plant = plant(&BEAM_150, shaker, mounting, TICK_S);
    for _ in 0..100_000 {
        plant.tick(SetPointPath::default(), false);
    }
    let along = GRAVITY_M_PER_S2 * tilt_rad.sin();
    let both = BEAM_150.cart_mass_kg + BEAM_150.mass_kg;
    let cart = along * both / (BEAM_150.cart_mass_kg * (TAU * shaker.suspension_hz).powi(2));
    assert!((plant.cart_m() / cart - 1.0).abs() < 1e-9);
    // ω² x + (k3/m) x³ = g sin α, where k3 is the stiffness where it is not given.
    let omega2 = (TAU * BEAM_150.natural_frequency_hz()).powi(2);
    let x = plant.hammer_m() - plant.cart_m();
    let cubic = match BEAM_150.support {
        SupportParams::Beams {
            cubic_stiffness_n_per_m3: Some(k3),
            ..
        } => k3 / BEAM_150.mass_kg,
        _ => omega2,
    };
    assert!(((omega2 * x + cubic * x.powi(3)) / along - 1.0).abs() < 1e-9);
}

#[test]
fn cart_and_armature_swing_in_their_two_modes() {
    let params = free_hammer();
    let armature = ArmatureParams {
        mass_kg: 0.8,
        hz: 40.0,
        damping_ratio: 0.0,
    };
    let shaker = ShakerParams {
        suspension_hz: 8.0,
        suspension_damping_ratio: 0.0,
        armature: Some(armature),
        ..ShakerParams::default()
    };
    let (cart, inner) = (params.cart_mass_kg, armature.mass_kg);
    let joint = cart * (TAU * 40.0_f64).powi(2);
    let spring = (cart + inner) * (TAU * 8.0_f64).powi(2);
    // cart · inner λ² − (cart (spring + joint) + inner · joint) λ + spring · joint = 0.
    let middle = (cart * (spring + joint) + inner * joint) / (2.0 * cart * inner);
    let root = (middle * middle - spring * joint / (cart * inner)).sqrt();
    for square in [middle - root, middle + root] {
        let off = |tick_s: f64| {
            let mut plant = plant(&params, shaker, Mounting::default(), tick_s);
            plant.set_state(BodiesState {
                y: 1e-4,
                z: 1e-4 * (1.0 - cart * square / joint),
                ..alone(0.0)
            });
            let mut worst = 0.0_f64;
            for k in 1..=(0.2 / tick_s).round() as u32 {
                plant.tick(SetPointPath::default(), false);
                let want = 1e-4 * (square.sqrt() * f64::from(k) * tick_s).cos();
                worst = worst.max((plant.cart_m() - want).abs() / 1e-4);
            }
            worst
        };
        let [coarse, fine] = [4.0 * TICK_S, 2.0 * TICK_S].map(off);
        let order = (coarse / fine).log2();
        println!(
            "{:.1} Hz: {fine:.1e}, order {order:.2}",
            square.sqrt() / TAU
        );
        assert!(
            fine < 1e-3 && (order - 4.0).abs() < 0.2,
            "{fine:.1e} {order}"
        );
    }
}

#[test]
fn a_shaker_that_loses_force_with_speed_comes_to_its_terminal_speed() {
    let shaker = ShakerParams {
        force_n: 50.0,
        impedance_n_s_per_m: 20.0,
        ..ShakerParams::default()
    };
    let params = free_hammer();
    let mut plant = plant(&params, shaker, Mounting::default(), TICK_S);
    plant.set_state(alone(0.0));
    let far = SetPointPath::new(TICK_S, (1e3, 0.0), (1e3, 0.0));
    for k in 1..=10_000 {
        plant.tick(far, true);
        let t = f64::from(k) * TICK_S;
        let want = 2.5 * -(-20.0 * t / params.cart_mass_kg).exp_m1();
        assert!((plant.state().w / want - 1.0).abs() < 1e-9, "{t}");
    }
}

#[test]
fn energy_balances_with_everything_on_the_cart_at_once() {
    for params in [WIRES, BEAM_150] {
        let hz = 1.9 * params.natural_frequency_hz();
        let off = |tick_s: f64| {
            let shaker = ShakerParams {
                impedance_n_s_per_m: 15.0,
                armature: Some(ArmatureParams {
                    mass_kg: 0.6,
                    hz: 60.0,
                    damping_ratio: 0.05,
                }),
                ..ShakerParams::default()
            };
            let mounting = Mounting {
                friction: Some(Friction {
                    coulomb_n: 3.0,
                    static_n: 5.0,
                    viscous_n_s_per_m: 10.0,
                }),
                stops: Some(Stops {
                    at_m: 0.95 * params.amplitude_m,
                    stiffness_n_per_m: 1e6,
                    damping_s_per_m: 1.0,
                }),
                tilt_rad: 0.003,
            };
            let mut plant = plant(&params, shaker, mounting, tick_s);
            let before = plant.bodies().energy_j(plant.state());
            let mut blows = 0;
            for k in 0..(20.0 / hz / tick_s) as u64 {
                plant.tick(sine(&params, hz, tick_s, k), true);
                blows += plant.finished().len();
            }
            assert!(blows > 10, "{blows}");
            let totals = plant.totals();
            assert!(totals.cart_work > 0.02 * totals.shaker_work, "{totals:?}");
            missing_j(&plant, before).abs() / totals.shaker_work
        };
        let [coarse, fine] = [TICK_S, 0.25 * TICK_S].map(off);
        println!("missing of the shaker's work: {coarse:.1e}, {fine:.1e}");
        assert!(
            coarse < 1e-5 && fine < 0.3 * coarse,
            "{coarse:.1e} {fine:.1e}"
        );
    }
}
