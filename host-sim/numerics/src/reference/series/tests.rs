//! The series against the equations of motion themselves, and against Runge–Kutta steps.

use shared::model::cart::ASSUMED_SHAKER;
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
