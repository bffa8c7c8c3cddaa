//! The same with a cart that recoils.

use shared::model::cart::{ASSUMED_SHAKER, CartDrive, LoopParams};
use shared::model::params::{BEAM_170, RigParams, SupportParams, Torque, WIRES};
use shared::model::rig::Rig;

use super::{at, rock};
use crate::drill::DrillSetting;
use crate::drill::blow::Feed;
use crate::drill::march::Drill;
use crate::drill::orbit;
use crate::orbit::{shoot, shoot_at};

fn recoiling(params: RigParams) -> RigParams {
    RigParams {
        cart: CartDrive::Loop(ASSUMED_SHAKER),
        ..params
    }
}

/// Ground that never gives way is the surface of the reference: same orbit, cart and multipliers.
#[test]
fn with_a_threshold_out_of_reach_it_is_the_reference() {
    for (params, hz) in [(WIRES, 3.66), (BEAM_170, 9.0)] {
        let params = recoiling(params);
        let seen = at(&params, 1e6, Feed::Cart, hz / params.natural_frequency_hz());
        let rigid = shoot_at(&params, hz, seen.guess(), 1).unwrap();
        let here = orbit::shoot(
            &params,
            &DrillSetting::new(rock(1e6), None, Feed::Cart),
            hz,
            rigid.at(),
        )
        .unwrap();
        let units =
            Drill::<f64>::through(&params, &DrillSetting::new(rock(1e6), None, Feed::Cart), hz)
                .unwrap()
                .all_units();
        for (i, unit) in units.iter().enumerate() {
            let apart = (here.section[i] - rigid.at()[i]).abs();
            assert!(apart < 1e-8 * unit, "{hz} {i}: {apart}");
        }
        let (a, b) = (here.multipliers().modulus(), rigid.multipliers().modulus());
        assert!((a - b).abs() < 1e-6, "{a} {b}");
        assert!((seen.force_n / rigid.force_n - 1.0).abs() < 1e-6);
        // The cart makes the difference: the prescribed one is another orbit.
        let prescribed = RigParams {
            cart: CartDrive::Prescribed,
            ..params
        };
        let other = shoot(&prescribed, hz, rigid.section).unwrap();
        assert!(rigid.force_n < 0.95 * other.force_n);
    }
}

/// A cart of a hundred tonnes does not recoil: it drills what a prescribed cart drills.
#[test]
fn a_heavy_cart_is_a_prescribed_one() {
    let known = at(&WIRES, 25.0, Feed::Cart, 2.04).rate_m_per_s;
    let mut last = f64::INFINITY;
    for cart_mass_kg in [10.0, 100.0, 1000.0] {
        let params = RigParams {
            cart_mass_kg,
            ..recoiling(WIRES)
        };
        let rate = at(&params, 25.0, Feed::Cart, 2.04).rate_m_per_s;
        let apart = (rate / known - 1.0).abs();
        assert!(apart < 0.12 * last, "{cart_mass_kg} kg: {apart} {last}");
        last = apart;
    }
    assert!(last < 2e-3, "{last}");
}

/// What the shaker puts into both bodies is what support, dashpot and progress take, and what is stored.
#[test]
fn energy_is_accounted_for() {
    let slow = CartDrive::Loop(LoopParams {
        frequency_hz: 12.0,
        damping_ratio: 0.4,
        feed_forward: 0.8,
        ..ASSUMED_SHAKER
    });
    for (params, ratio) in [(WIRES, 2.04), (WIRES, 1.2), (BEAM_170, 2.0)] {
        for cart in [slow, CartDrive::Loop(ASSUMED_SHAKER)] {
            let mut params = RigParams { cart, ..params };
            // Force times speed is the power only with the moment F l cos θ.
            if let SupportParams::Wires { torque, .. } = &mut params.support {
                *torque = Torque::Cosine;
            }
            let hz = ratio * params.natural_frequency_hz();
            let omega = std::f64::consts::TAU * hz;
            let rig = Rig::<f64>::new(&params).unwrap();
            let both_j = |drill: &Drill<f64>| {
                let ([q, v, _], cart) = (drill.section(), drill.cart());
                let at = rig.kinematics(q, v);
                let speed = params.amplitude_m * omega + cart[1];
                let both_kg = params.mass_kg + params.cart_mass_kg;
                drill.energy_now_j().0
                    + params.mass_kg * speed * at.rate
                    + 0.5 * both_kg * speed * speed
            };
            let mut drill = Drill::<f64>::through(
                &params,
                &DrillSetting::new(rock(25.0), None, Feed::Ground),
                hz,
            )
            .unwrap();
            let mut blows = Vec::new();
            for _ in 0..40 {
                drill.run_period(&mut blows);
            }
            let before = (drill.energies(), drill.energy_now_j().1, both_j(&drill));
            let (_, dug) = drill.run_period(&mut blows);
            let after = (drill.energies(), drill.energy_now_j().1, both_j(&drill));
            let of = |f: fn(&crate::drill::flow::Energies) -> f64| f(&after.0) - f(&before.0);
            let taken = of(|e| e.dashpot) + of(|e| e.progress) + after.1 - before.1;
            let into = of(|e| e.ground);
            assert!((taken / into - 1.0).abs() < 1e-9, "{taken} {into}");
            assert!((of(|e| e.progress) - 25.0 * dug).abs() < 1e-15);
            assert!(dug > 1e-6, "{dug}");
            let (shaker, kept) = (of(|e| e.shaker), after.2 - before.2);
            let apart = shaker - of(|e| e.damping) - into - kept;
            assert!(apart.abs() < 1e-9 * into, "{apart} of {into}");
        }
    }
}

/// The derivative from dual numbers against differences, in all four directions.
#[test]
fn the_derivative_of_the_return_map_is_that_of_differences() {
    let (params, ground) = (recoiling(WIRES), rock(25.0));
    let hz = 2.04 * 1.82;
    let seen = at(&params, 25.0, Feed::Cart, 2.04);
    let found = orbit::shoot(
        &params,
        &DrillSetting::new(ground, None, Feed::Cart),
        hz,
        seen.guess(),
    )
    .unwrap();
    assert!(found.is_stable_one_one());
    assert!((found.progress_m / seen.per_cycle_m - 1.0).abs() < 1e-8);
    let drill =
        Drill::<f64>::through(&params, &DrillSetting::new(ground, None, Feed::Cart), hz).unwrap();
    // The cart's ringing adds the errors of many steps, which differences magnify.
    let drill = drill.with_tolerance(1e-14);
    let units = drill.all_units();
    let image = |i: usize, by: f64| {
        let mut x = found.section;
        x[i] += by * units[i];
        let mut drill = drill.clone();
        drill.place_off([x[0], x[1], 0.0], [x[2], x[3]]);
        let (_, dug) = drill.run_period(&mut Vec::new());
        let ([q, v, _], [off, off_rate]) = (drill.section(), drill.cart());
        let end = [q, v, off, off_rate];
        ([0, 1, 2, 3].map(|j| end[j] / units[j]), dug)
    };
    let h = 3e-6;
    for i in 0..4 {
        let (up, down) = (image(i, h), image(i, -h));
        for j in 0..4 {
            let slope = (up.0[j] - down.0[j]) / (2.0 * h);
            let exact = found.monodromy.entry(j, i);
            assert!((slope - exact).abs() < 1e-6, "{i} {j}: {slope} {exact}");
        }
        let slope = (up.1 - down.1) / (2.0 * h);
        let exact = found.progress_slope_m[i];
        let apart = (slope - exact).abs();
        assert!(apart < 1e-5 * exact.abs().max(1e-9), "{i}: {slope} {exact}");
    }
}
