//! The derivative of the return map: against differences, and its determinant against Liouville's.

use std::f64::consts::TAU;

use numerics::orbit::{Orbit, shoot};
use numerics::reference::{LocatedContact, Reference};
use shared::model::cart::{CartDrive, LoopParams};
use shared::model::params::{PRESETS, RigParams, SupportParams};
use shared::model::rig::Rig;

use crate::support::close;

/// The settled 1/1 orbit of a rig.
fn orbit(params: &RigParams, ratio: f64) -> Orbit {
    let frequency_hz = ratio * params.natural_frequency_hz();
    let mut hammer = Reference::<f64>::at_rest(params, frequency_hz).unwrap();
    for _ in 0..300 {
        hammer.run_period(&mut ());
    }
    let (q, v) = hammer.state();
    let orbit = shoot(params, frequency_hz, [q, v]).expect("a settled orbit");
    assert_eq!(orbit.impacts, 1);
    orbit
}

/// Every preset with a prescribed cart, and with one that a soft loop hardly damps: it is still on its way a period later.
fn cases() -> impl Iterator<Item = (&'static str, RigParams)> {
    let soft = CartDrive::Loop(LoopParams {
        frequency_hz: 9.0,
        damping_ratio: 0.2,
        feed_forward: 0.9,
        max_force_n: 200.0,
    });
    [CartDrive::Prescribed, soft].into_iter().flat_map(|cart| {
        PRESETS.into_iter().map(move |(name, params)| {
            let params = RigParams {
                gap_m: 1e-3,
                cart,
                ..params
            };
            (name, params)
        })
    })
}

#[test]
fn dual_numbers_agree_with_central_differences() {
    for (name, params) in cases() {
        let orbit = orbit(&params, 1.5);
        let scale = Rig::<f64>::new(&params).unwrap().coordinate_scale();
        let (omega, amplitude) = (TAU * orbit.frequency_hz, params.amplitude_m);
        let units = [scale, scale * omega, amplitude, amplitude * omega];
        let image = |j: usize, by: f64| {
            let mut x = orbit.at();
            x[j] += by * units[j];
            let hammer = Reference::<f64>::new(&params, orbit.frequency_hz, x[0], x[1]).unwrap();
            let mut hammer = hammer.with_cart([x[2], x[3]]);
            hammer.run_period(&mut ());
            let ((q, v), [e, w]) = (hammer.state(), hammer.cart());
            [q / units[0], v / units[1], e / units[2], w / units[3]]
        };
        const STEP: f64 = 1e-5;
        let n = orbit.monodromy.size();
        let entries = (0..n * n).map(|k| orbit.monodromy.entry(k / n, k % n));
        let size = entries.fold(0.0_f64, |max, m| max.max(m.abs()));
        for j in 0..n {
            let (up, down) = (image(j, STEP), image(j, -STEP));
            for i in 0..n {
                let difference = (up[i] - down[i]) / (2.0 * STEP);
                let exact = orbit.monodromy.entry(i, j);
                let error = (difference - exact).abs() / size;
                assert!(error < 1e-6, "{name} [{i}][{j}]: off by {error:.1e}");
            }
        }
    }
}

/// Liouville: the determinant is exp(∫ div), and the saltation at onset (the force jumps by ci δ̇) and at
/// release (it does not jump) has determinant 1. So only the dampers count.
#[test]
fn the_determinant_is_what_the_dampers_leave() {
    // On wires the mass that a recoiling cart moves changes with the angle, and the loop's damper with it.
    let plain = |params: &RigParams| {
        !(params.cart.recoils() && matches!(params.support, SupportParams::Wires { .. }))
    };
    for (name, params) in cases().filter(|(_, params)| plain(params)) {
        let orbit = orbit(&params, 1.5);
        let m = params.mass_kg;
        let contact_s = orbit.contact.duration_s;
        let (support, slope, tolerance) = match params.support {
            // cos θ changes by 2e-6 during a contact.
            SupportParams::Wires { length_m, .. } => {
                let sin = params.gap_m / length_m;
                (0.0, (1.0 - sin * sin).sqrt(), 5e-6)
            }
            SupportParams::Beams {
                natural_frequency_hz,
                damping_ratio,
                ..
            } => (2.0 * damping_ratio * TAU * natural_frequency_hz, 1.0, 1e-9),
        };
        let hammer = support / orbit.frequency_hz + slope * 1.2e3 * contact_s / m;
        // What damps the hammer against a free cart damps both; the loop's damper is the cart's own.
        let exponent = match params.cart {
            CartDrive::Prescribed => hammer,
            CartDrive::Loop(held) => {
                let own = 2.0 * held.damping_ratio * TAU * held.frequency_hz;
                hammer * (1.0 + m / params.cart_mass_kg) + own / orbit.frequency_hz
            }
        };
        let determinant = orbit.monodromy.determinant();
        close(name, determinant, (-exponent).exp(), tolerance);
    }
}

/// An orbit that is settled repeats: the multipliers lie inside the unit circle, and shooting finds the
/// same contact that simulation settles to.
#[test]
fn shooting_finds_what_simulation_settles_to() {
    for (name, params) in cases() {
        let orbit = orbit(&params, 1.5);
        assert!(orbit.is_stable_one_one(), "{name}");
        let mut hammer = Reference::<f64>::at_rest(&params, orbit.frequency_hz).unwrap();
        for _ in 0..600 {
            hammer.run_period(&mut ());
        }
        let mut contacts = Vec::<LocatedContact>::new();
        hammer.run_period(&mut contacts);
        close(name, orbit.force_n, contacts[0].peak_force_n, 1e-9);
    }
}
