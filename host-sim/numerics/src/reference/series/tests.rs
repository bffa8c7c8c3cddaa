//! The series against the equations of motion themselves, and against Runge–Kutta steps.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use shared::model::cart::{ASSUMED_SHAKER, LoopParams};
use shared::model::params::PRESETS;

use super::*;
use crate::dual::Dual;
use crate::orbit::seeds;
use crate::reference::{LocatedContact, Reference};

/// Every preset with either cart, the wires with either torque, each law in turn.
fn rigs() -> Vec<(String, RigParams)> {
    let mut rigs = Vec::new();
    for (k, (name, preset)) in PRESETS.into_iter().enumerate() {
        for cart in [CartDrive::Prescribed, CartDrive::Loop(ASSUMED_SHAKER)] {
            for (law, contact) in shared::model::contact::LAWS {
                let mut params = RigParams {
                    gap_m: 2e-4 * k as f64,
                    cart,
                    contact,
                    ..preset
                };
                if let SupportParams::Wires { torque, .. } = &mut params.support
                    && cart.recoils()
                {
                    *torque = Torque::Cosine;
                }
                rigs.push((
                    format!("{name}, {law:?}, recoils: {}", cart.recoils()),
                    params,
                ));
            }
        }
    }
    rigs
}

/// The equations of motion themselves say what the second derivative is, wherever the series is looked at.
#[test]
fn it_obeys_the_equations_of_motion() {
    for (name, params) in rigs() {
        let hz = 1.7 * params.natural_frequency_hz();
        let mut hammer = Reference::<f64>::new(&params, hz, 1e-6, 0.07).unwrap();
        hammer = hammer.from_phase(0.3).with_cart([2e-5, -3e-3]);
        for mode in [SwitchMode::Flight, SwitchMode::Contact] {
            hammer.mode = mode;
            let equations = hammer.equations.unwrap();
            if !equations.hold(mode) {
                continue;
            }
            let series = equations.series(&hammer.rig, mode, &hammer.point);
            let flow = hammer.flow();
            let reach = series.reach(
                hammer.tolerance,
                flow.units,
                flow.recoil.map(|(_, units)| units),
            );
            for share in [0.0, 0.3, 0.7, 1.0] {
                let tau = share * reach;
                let (wanted, _) = flow.acceleration(&series.point(tau));
                let is = series.acceleration(tau);
                let off = (is - wanted).abs() / (1.0 + wanted.abs());
                assert!(off < 1e-9, "{name} {mode:?} {share}: {is} {wanted}");
            }
        }
    }
}

/// The Runge–Kutta steps, to which the equations are asked for their rates at every stage, lead to the same contacts and
/// the same section, with the same derivatives.
#[test]
fn it_leads_where_runge_kutta_steps_lead() {
    for (name, params) in rigs() {
        let mut worst = [0.0_f64; 3];
        let hz = 1.7 * params.natural_frequency_hz();
        let start = {
            let mut hammer = Reference::<f64>::at_rest(&params, hz).unwrap();
            (0..5).for_each(|_| _ = hammer.run_period(&mut ()));
            let (q, v) = hammer.state();
            [q, v, hammer.cart()[0], hammer.cart()[1]]
        };
        let run = |in_series: bool| {
            let [q, v, e, w] = seeds::<4>(start);
            let hammer = Reference::<Dual<4>>::new(&params, hz, q, v).unwrap();
            let mut hammer = hammer.with_cart([e, w]);
            if !in_series {
                hammer = hammer.in_steps();
            }
            let mut contacts = Vec::<LocatedContact>::new();
            (0..2).for_each(|_| _ = hammer.run_period(&mut contacts));
            (
                hammer.point(),
                hammer.totals(),
                contacts,
                hammer.rig().coordinate_scale(),
            )
        };
        let ((a, totals, contacts, scale), (b, as_much, as_many, _)) = (run(true), run(false));
        assert_eq!(contacts.len(), as_many.len(), "{name}");
        let close = |worst: &mut f64, a: f64, b: f64, unit: f64| {
            *worst = worst.max((a - b).abs() / unit);
        };
        for (a, b) in [(a.q, b.q), (a.cart[0], b.cart[0])] {
            close(&mut worst[0], a.re, b.re, scale);
            for k in 0..2 {
                close(&mut worst[1], a.eps[k], b.eps[k], 1.0 + b.eps[k].abs());
            }
        }
        for (a, b) in contacts.iter().zip(&as_many) {
            close(&mut worst[2], a.onset_s, b.onset_s, 1e-3);
            close(&mut worst[2], a.duration_s, b.duration_s, b.duration_s);
            close(
                &mut worst[2],
                a.peak_force_n,
                b.peak_force_n,
                b.peak_force_n,
            );
            let energy = 0.5 * params.mass_kg * a.approach_speed_m_per_s.powi(2);
            close(&mut worst[2], a.energy_lost_j, b.energy_lost_j, energy);
            close(&mut worst[2], a.impulse_n_s, b.impulse_n_s, b.impulse_n_s);
        }
        close(
            &mut worst[2],
            totals.inertial_work,
            as_much.inertial_work,
            as_much.inertial_work,
        );
        close(
            &mut worst[2],
            totals.damping_work,
            as_much.damping_work,
            as_much.inertial_work,
        );
        let [section, derivatives, figures] = worst;
        assert!(
            section < 1e-9 && derivatives < 1e-9 && figures < 1e-8,
            "{name}: {worst:?}"
        );
    }
}

/// Rigs and starts far from any that is built: the same contacts as by Runge–Kutta steps, and no more steps.
#[test]
fn it_leads_where_runge_kutta_steps_lead_on_random_rigs() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    for (case, (name, preset)) in PRESETS.into_iter().cycle().take(600).enumerate() {
        let mut between = |low: f64, high: f64| random.random_range(low.ln()..high.ln()).exp();
        let mass_kg = preset.mass_kg * between(0.3, 3.0);
        let (stiffness, damping_ratio) = (between(1e4, 1e9), between(1e-3, 2.0));
        let held = LoopParams {
            frequency_hz: between(5.0, 300.0),
            damping_ratio: between(0.03, 2.0),
            ..ASSUMED_SHAKER
        };
        let mut params = RigParams {
            mass_kg,
            amplitude_m: preset.amplitude_m * between(0.1, 5.0),
            contact: Law::SpringDashpot {
                stiffness,
                damping: 2.0 * damping_ratio * (stiffness * mass_kg).sqrt(),
            },
            ..preset
        };
        let hz = between(0.2, 8.0) * params.natural_frequency_hz();
        params.gap_m = random.random_range(-2e-3..3e-3);
        if random.random() {
            params.cart = CartDrive::Loop(held);
        }
        let (farthest, lever) = match &mut params.support {
            SupportParams::Wires {
                length_m, torque, ..
            } => {
                if random.random() {
                    *torque = Torque::Cosine;
                }
                (0.3, *length_m)
            }
            SupportParams::Beams {
                cubic_stiffness_n_per_m3: cubic,
                ..
            } => {
                *cubic = random
                    .random::<bool>()
                    .then(|| 10.0_f64.powf(random.random_range(3.0..8.0)));
                (10e-3, 1.0)
            }
        };
        // The coordinate is 0 at the surface.
        let q = random.random_range(-farthest..0.0);
        let v = random.random_range(-0.5..0.5) / lever;
        let run = |mut hammer: Reference<f64>| {
            let mut contacts = Vec::<LocatedContact>::new();
            hammer.run_period(&mut contacts);
            (hammer.state(), contacts.len(), hammer.pace.tried)
        };
        let hammer = Reference::<f64>::new(&params, hz, q, v).unwrap();
        let scale = hammer.rig.coordinate_scale();
        let ((a, contacts, steps), (b, as_many, at_most)) = (run(hammer), run(hammer.in_steps()));
        let off = |a: f64, b: f64, unit: f64| (a - b).abs() / (unit + b.abs());
        let off = off(a.0, b.0, scale).max(off(a.1, b.1, scale * hz));
        assert!(
            contacts == as_many && steps <= at_most && off < 1e-6,
            "{case}, {name}: {contacts} and {as_many} contacts, {steps} and {at_most} steps, {off:e} apart"
        );
    }
}
