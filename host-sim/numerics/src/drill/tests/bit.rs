//! A bit between hammer and ground.

use shared::model::bit::Bit;
use shared::model::cart::{ASSUMED_SHAKER, CartDrive};
use shared::model::params::{BEAM_170, RigParams, SupportParams, Torque, WIRES};
use shared::model::rig::Rig;
use shared::model::slider::Slider;

use super::{PLAN, rock};
use crate::drill::blow::Feed;
use crate::drill::body::FreeMass;
use crate::drill::flow::Energies;
use crate::drill::march::Drill;
use crate::drill::orbit;
use crate::drill::run::{DrillSetting, run};

/// A bit that is struck like the rig's own surface and pressed on by its weight.
pub(super) fn bit(mass: f64) -> Bit<f64> {
    Bit {
        mass,
        stiffness: 5.5e6,
        damping: 1.2e3,
        feed_force: Bit::weight_n(mass),
    }
}

const HZ: f64 = 2.05 * 1.82;

/// A bit without mass is a spring-dashpot on a spring-dashpot: with the same time constant, one of half the stiffness. What
/// the mass changes halves with it.
#[test]
fn a_light_bit_is_softer_ground() {
    let (ground, soft) = (
        rock(25.0),
        Slider {
            stiffness: 2.75e6,
            damping: 600.0,
            threshold: 25.0,
        },
    );
    let setting = DrillSetting {
        ground: soft,
        bit: None,
        feed: Feed::Cart,
    };
    let seen = run(&WIRES, &setting, HZ, PLAN).unwrap();
    let massless = orbit::shoot(
        &WIRES,
        &DrillSetting::new(soft, None, Feed::Cart),
        HZ,
        seen.guess(),
    )
    .unwrap();
    let mut last = None;
    for mass in [0.04, 0.02, 0.01, 0.005] {
        let bit = bit(mass);
        let found = orbit::shoot(
            &WIRES,
            &DrillSetting::new(ground, Some(bit), Feed::Cart),
            HZ,
            massless.section,
        )
        .unwrap();
        let apart = found.progress_m / massless.progress_m - 1.0;
        println!("{mass} kg: {apart}");
        if let Some(last) = last {
            let ratio: f64 = apart / last;
            assert!(
                (ratio - 0.5).abs() < 0.05,
                "{mass} kg: {apart} after {last}"
            );
        }
        last = Some(apart);
    }
    assert!(last.unwrap().abs() < 0.02, "{last:?}");
}

/// A heavy bit on ground that hardly gives by itself, struck once without damping: the collision has a closed form (a linear
/// spring between two free masses, one of them held back by Pf − W), and the bit then goes m_b w²/2 = (Pf − W) s.
#[test]
fn one_blow_is_the_closed_form() {
    let (mass, speed, stiffness) = (0.298, 0.08, 1e9_f64);
    for (bit_mass, threshold, feed_force) in [(0.596, 25.0, 1.0), (0.4, 10.0, 0.0)] {
        let stiff = Slider {
            stiffness: 1e12,
            damping: 1e7,
            threshold,
        };
        let bit = Bit {
            mass: bit_mass,
            stiffness,
            damping: 0.0,
            feed_force,
        };
        let free = FreeMass {
            mass,
            static_force: 0.0,
            amplitude: 0.0,
        };
        let drill = Drill::<f64>::free(free, 1e-5, &stiff, 250.0).unwrap();
        let mut drill = drill.with_bit(&bit, &stiff).unwrap();
        drill.place([-1e-5, speed, 0.0]);
        drill.run_period(&mut Vec::new());
        // The bit holds until the contact has risen to what the ground bears beside the feed.
        let hold = threshold - feed_force;
        let x1 = hold / stiffness;
        let v1 = (speed * speed - stiffness * x1 * x1 / mass).sqrt();
        // Then x swings about `middle` until it is 0 again.
        let (both, back) = (mass + bit_mass, hold / bit_mass);
        let reduced = mass * bit_mass / both;
        let (omega, middle) = ((stiffness / reduced).sqrt(), reduced * back / stiffness);
        let size = (x1 - middle).hypot(v1 / omega);
        let first = (v1 / omega).atan2(x1 - middle);
        let angle = first + (-middle / size).acos();
        let time = angle / omega;
        let parting = -size * omega * (angle - first).sin();
        let moved = (mass * (v1 * time + x1) - 0.5 * hold * time * time) / both;
        let after = (mass * (v1 - parting) - hold * time) / both;
        let exact = moved + 0.5 * bit_mass * after * after / hold;
        let apart = drill.drift_m() / exact - 1.0;
        assert!(apart.abs() < 1e-4, "{threshold} N: {apart}");
        // The collision alone, as if the ground did not press meanwhile.
        let split = 2.0 * mass / both * speed;
        let simple = 0.5 * bit_mass * split * split / hold;
        assert!((exact / simple - 1.0).abs() < 0.05, "{exact} {simple}");
        println!("{threshold} N: {apart}, simple {}", exact / simple - 1.0);
    }
}

fn with_cosine(mut params: RigParams) -> RigParams {
    // Force times speed is the power only with the moment F l cos θ.
    if let SupportParams::Wires { torque, .. } = &mut params.support {
        *torque = Torque::Cosine;
    }
    params
}

/// Body by body, and all together where a shaker drives them.
#[test]
fn energy_is_accounted_for() {
    let held = CartDrive::Loop(ASSUMED_SHAKER);
    for (params, ratio, cart, mass) in [
        (WIRES, 2.04, CartDrive::Prescribed, 0.1),
        (WIRES, 2.04, held, 0.1),
        (WIRES, 1.8, held, 0.3),
        (BEAM_170, 2.0, held, 0.05),
    ] {
        let params = RigParams {
            cart,
            ..with_cosine(params)
        };
        let bit = bit(mass);
        let hz = ratio * params.natural_frequency_hz();
        let feed = Feed::Ground;
        let mut drill =
            Drill::<f64>::through(&params, &DrillSetting::new(rock(25.0), Some(bit), feed), hz)
                .unwrap();
        let mut blows = Vec::new();
        for _ in 0..10 {
            drill.run_period(&mut blows);
        }
        let rig = Rig::<f64>::new(&params).unwrap();
        let all_j = |drill: &Drill<f64>| {
            let ([q, v, _], [_, w]) = (drill.section(), drill.bit());
            let at = rig.kinematics(q, v);
            let speed = params.amplitude_m * std::f64::consts::TAU * hz + drill.cart()[1];
            let kg = params.mass_kg + params.cart_mass_kg + mass;
            let shared = speed * (params.mass_kg * at.rate + mass * w) + 0.5 * kg * speed * speed;
            drill.energy_now_j().0 + drill.bit_energy_now_j().0 + shared
        };
        let state = |drill: &Drill<f64>| {
            let ((body, ground), (bit, between)) = (drill.energy_now_j(), drill.bit_energy_now_j());
            let now = [body, ground, bit, between, all_j(drill), drill.section()[2]];
            (drill.energies(), now)
        };
        let before = state(&drill);
        let (_, dug) = drill.run_period(&mut blows);
        let after = state(&drill);
        let of = |f: fn(&Energies) -> f64| f(&after.0) - f(&before.0);
        let kept = |i: usize| after.1[i] - before.1[i];
        let contact = of(|e| e.contact);
        let closes = |what: &str, left: f64| {
            println!("{mass} kg {what}: {}", left / contact);
            assert!(left.abs() < 1e-9 * contact, "{what}: {left} of {contact}");
        };
        assert!(dug > 1e-6 && of(|e| e.bit_heat) > 0.0, "{dug}");
        let hammer = of(|e| e.drive) - of(|e| e.damping) - contact;
        closes("hammer", hammer - kept(0));
        closes(
            "contact",
            contact - of(|e| e.bit) - of(|e| e.bit_heat) - kept(3),
        );
        let into = of(|e| e.bit) + of(|e| e.bit_drive);
        closes("bit", into - of(|e| e.ground) - kept(2));
        let spent = of(|e| e.dashpot) + of(|e| e.progress);
        closes("ground", of(|e| e.ground) - spent - kept(1));
        assert!((of(|e| e.progress) - 25.0 * dug).abs() < 1e-15);
        if cart.recoils() {
            // The feed force works between cart and bit.
            let fed = bit.feed_force * (dug + kept(5));
            let lost = of(|e| e.damping) + of(|e| e.bit_heat) + spent;
            let stored = kept(1) + kept(3) + kept(4);
            closes("all", of(|e| e.shaker) + fed - lost - stored);
        }
    }
}

/// The derivative from dual numbers against differences; and where the bit begins does not matter, which is why its own
/// directions are left out.
#[test]
fn the_derivative_of_the_return_map_is_that_of_differences() {
    let (ground, bit) = (rock(25.0), bit(0.1));
    let setting = DrillSetting {
        ground,
        bit: Some(bit),
        feed: Feed::Cart,
    };
    let seen = run(&WIRES, &setting, HZ, PLAN).unwrap();
    let found = orbit::shoot(
        &WIRES,
        &DrillSetting::new(ground, Some(bit), Feed::Cart),
        HZ,
        seen.guess(),
    )
    .unwrap();
    assert!(found.is_stable_one_one());
    assert!((found.progress_m / seen.per_cycle_m - 1.0).abs() < 1e-8);
    let drill = Drill::<f64>::through(
        &WIRES,
        &DrillSetting::new(ground, Some(bit), Feed::Cart),
        HZ,
    )
    .unwrap();
    let units = [drill.units().0, drill.units().1];
    let image = |by: [f64; 2], deeper: f64| {
        let mut drill = drill.clone();
        let [a, b] = [0, 1].map(|i| found.section[i] + by[i] * units[i]);
        drill.place([a, b, 0.0]);
        let [u, w] = drill.bit();
        drill.place_bit([u + deeper, w]);
        let (_, dug) = drill.run_period(&mut Vec::new());
        let [q, v, _] = drill.section();
        [q / units[0], v / units[1], dug]
    };
    let h = 1e-5;
    for (i, by) in [[h, 0.0], [0.0, h]].into_iter().enumerate() {
        let (up, down) = (image(by, 0.0), image(by.map(|x| -x), 0.0));
        for j in 0..2 {
            let slope = (up[j] - down[j]) / (2.0 * h);
            let exact = found.monodromy.entry(j, i);
            assert!((slope - exact).abs() < 1e-6, "{i} {j}: {slope} {exact}");
        }
        let slope = (up[2] - down[2]) / (2.0 * h);
        let exact = found.progress_slope_m[i];
        assert!((slope / exact - 1.0).abs() < 1e-5, "{slope} {exact}");
    }
    // Half as deep again as it rests.
    let (rests, deeper) = (image([0.0; 2], 0.0), image([0.0; 2], 1e-7));
    for j in 0..2 {
        assert!((rests[j] - deeper[j]).abs() < 1e-9, "{j}");
    }
    assert!((rests[2] / deeper[2] - 1.0).abs() < 1e-9);
}

mod another_way;
