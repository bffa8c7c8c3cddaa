use std::f64::consts::PI;

use super::*;
use shared::model::contact::TABLE_3_1;

const MASS_KG: f64 = 0.298;

fn one(law: Law<f64>, mass_kg: f64, speed: f64) -> ContactFigures {
    rows("law", law, mass_kg, &[speed]).unwrap().remove(0)
}

#[track_caller]
fn close(a: f64, b: f64, relative: f64) {
    assert!((a - b).abs() <= relative * b.abs(), "{a} against {b}");
}

/// In closed form: δ ∝ exp(−ζω₀t) sin ω_d t; with cos φ = ζ the force is 0 at ω_d t = 2φ, and δ at ω_d t = π.
#[test]
fn the_spring_dashpot_is_its_closed_form_and_pulls_to_the_end_of_its_half_swing() {
    let (k, c): (f64, f64) = (5.5e6, 1.2e3);
    let omega = (k / MASS_KG).sqrt();
    let zeta = c / (2.0 * (k * MASS_KG).sqrt());
    let root = (1.0 - zeta * zeta).sqrt();
    let phi = zeta.acos();
    for speed in [0.01, 0.08, 0.5] {
        let seen = one(TABLE_3_1, MASS_KG, speed);
        close(seen.contact_time_ms, 2e3 * phi / (omega * root), 1e-9);
        close(seen.restitution, (-2.0 * zeta / root * phi).exp(), 1e-9);
        close(seen.pull_share, (PI - 2.0 * phi) / PI, 1e-8);
        close(seen.pulling_restitution, (-PI * zeta / root).exp(), 1e-9);
        // F is least where its derivative is 0 again: ω_d t = 3φ if that is before π, else at the end.
        let end = (3.0 * phi).min(PI);
        let size = MASS_KG * speed * omega * (-zeta / root * end).exp() / root;
        close(seen.pull_n, size * (end - 2.0 * phi).sin(), 2e-4);
        assert!(seen.energy_imbalance.abs() < 1e-10, "{seen:?}");
    }
    let known = one(TABLE_3_1, MASS_KG, 0.08);
    close(known.contact_time_ms, 0.570751, 2e-6);
    close(known.restitution, 0.316902, 2e-6);
}

/// Hertz: T = 2 δ_m/v ∫₀¹ du/√(1 − u^(n+1)), δ_m = ((n+1) m v²/2k)^(1/(n+1)). For n = 3/2 twice the integral is
/// 2 √π Γ(1.4)/Γ(0.9) = 2.943275 (Goldsmith, Impact, Arnold 1960, rounds to 2.94).
#[test]
fn hertz_lasts_as_long_as_its_textbook_formula_says_and_loses_nothing() {
    let law = Law::Hertz {
        stiffness: 2.5e9,
        exponent: 1.5,
    };
    for speed in [0.02, 0.08, 0.5] {
        let seen = one(law, MASS_KG, speed);
        let deepest = (5.0 * MASS_KG * speed * speed / (4.0 * 2.5e9)).powf(0.4);
        close(seen.contact_time_ms, 2.943_275e3 * deepest / speed, 1e-6);
        close(seen.penetration_um, deepest * 1e6, 1e-4);
        close(seen.restitution, 1.0, 1e-9);
        close(seen.force_n, 2.5e9 * deepest.powf(1.5), 1e-6);
        assert_eq!(seen.pull_share, 0.0);
    }
}

/// m v dv/dδ = −kδⁿ(1 + λv) separates; equal work in and out leaves d(1 + e) = ln((1 + d)/(1 − e d)), d = λv,
/// whatever n, k and m. Lankarani–Nikravesh is the same with d = ¾(1 − e_given²).
fn implicit(d: f64) -> f64 {
    let off = |e: f64| d * (1.0 + e) - ((1.0 + d) / (1.0 - e * d)).ln();
    let (mut a, mut b) = (0.0, (1.0 - 1e-15_f64).min((1.0 - 1e-12) / d));
    for _ in 0..200 {
        let middle = 0.5 * (a + b);
        if off(middle) > 0.0 {
            a = middle;
        } else {
            b = middle;
        }
    }
    0.5 * (a + b)
}

#[test]
fn hunt_crossley_rebounds_as_its_implicit_formula_says_and_by_two_thirds_lambda_v_when_slow() {
    for (exponent, speed) in [(1.6, 0.1), (1.6, 1.0), (1.5, 3.0), (2.0, 8.0)] {
        let law = Law::HuntCrossley {
            stiffness: 2.1e8,
            exponent,
            damping_ratio: 0.6,
        };
        let seen = one(law, 2.0, speed);
        close(seen.restitution, implicit(0.6 * speed), 1e-8);
        assert!(seen.energy_imbalance.abs() < 1e-9, "{seen:?}");
        assert_eq!(seen.pull_share, 0.0);
    }
    // The first order: 1 − e = (2/3) λv. The next is of (λv)², so what is left falls fourfold as v halves.
    let left = |speed: f64| 1.0 - one(FIGURE_3_3, 2.0, speed).restitution - 2.0 / 3.0 * 0.6 * speed;
    let (one, half) = (left(0.1), left(0.05));
    assert!(one.abs() < 0.06_f64.powi(2), "{one}");
    close(one / half, 4.0, 0.05);
}

#[test]
fn lankarani_nikravesh_rebounds_more_than_it_is_told_and_never_below_two_thirds() {
    for given in [0.0, 0.3, 0.6, 0.9_f64] {
        let law = Law::LankaraniNikravesh {
            stiffness: 2.9e9,
            exponent: 1.5,
            restitution: given,
        };
        let seen = one(law, MASS_KG, 0.08);
        close(
            seen.restitution,
            implicit(0.75 * (1.0 - given * given)),
            1e-8,
        );
        assert!(seen.restitution > given.max(0.6629) && seen.pull_share == 0.0);
    }
}

#[test]
fn flores_rebounds_about_as_it_is_told_at_any_speed() {
    for given in [0.05, 0.1, 0.3, 0.5, 0.7, 0.9, 0.95_f64] {
        for speed in [0.05, 1.0] {
            let law = Law::Flores {
                stiffness: 2.9e9,
                exponent: 1.5,
                restitution: given,
            };
            let seen = one(law, MASS_KG, speed);
            let expected = implicit(1.6 * (1.0 - given) / given);
            close(seen.restitution, expected, 1e-8);
            assert!((seen.restitution - given).abs() < 0.05 && seen.pull_share == 0.0);
        }
    }
}

#[test]
fn the_force_between_steps_is_that_of_the_closed_form() {
    let rig = Rig::new(&free_mass(MASS_KG, TABLE_3_1)).unwrap();
    let speed = 0.08;
    let course = one_contact(&rig, speed).unwrap();
    let omega = (5.5e6_f64 / MASS_KG).sqrt();
    let zeta = 1.2e3 / (2.0 * (5.5e6_f64 * MASS_KG).sqrt());
    let root = (1.0 - zeta * zeta).sqrt();
    let phi = zeta.acos();
    for i in 0..=1000 {
        let t = course.contact.duration_s * f64::from(i) / 1000.0;
        let size = MASS_KG * speed * omega / root * (-zeta * omega * t).exp();
        let force = size * (2.0 * phi - omega * root * t).sin();
        // The quintic between steps: a millionth of the peak.
        let off = course.force(&rig, t) - force;
        assert!(off.abs() < 1e-6 * course.contact.peak_force_n, "{t}: {off}");
    }
    assert_eq!(course.force(&rig, -1e-9), 0.0);
    assert_eq!(course.force(&rig, course.contact.duration_s + 1e-9), 0.0);
}
