use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::*;

fn close(a: f64, b: f64, relative: f64) {
    assert!((a - b).abs() <= relative * b.abs(), "{a} against {b}");
}

fn beam(tip: TipJoint, mass_ratio: f64) -> Beam {
    Beam { tip, mass_ratio }
}

/// As good as no hammer.
const UNLOADED: f64 = 1e12;

#[test]
fn roots_without_a_hammer_are_the_textbooks() {
    // Blevins, Formulas for Natural Frequency and Mode Shape (1979), Table 8-1: clamped-free, clamped-sliding.
    let free = [1.87510407, 4.69409113, 7.85475744, 10.99554073, 14.13716839];
    let guided = [2.36502037, 5.49780392, 8.63937983, 11.78097245, 14.92256510];
    for (tip, table) in [(TipJoint::Free, free), (TipJoint::Guided, guided)] {
        for (found, known) in beam(tip, UNLOADED).roots(5).iter().zip(table) {
            close(*found, known, 1e-8);
        }
    }
}

#[test]
fn roots_with_a_hammer_are_the_published_ones() {
    // A tip mass as heavy as the beam: Laura, Pombo and Susemihl (1974), to the digits printed.
    for (found, known) in beam(TipJoint::Free, 1.0)
        .roots(3)
        .iter()
        .zip([1.2479, 4.0311, 7.1341])
    {
        assert!((found - known).abs() < 5.1e-5, "{found} against {known}");
    }
    // A fifth of the beam's mass: Applied Sciences 9 (2019) 2996, doi:10.3390/app9152996, Table 2: frequencies in Hz of
    // one beam, printed to 0.01 Hz, so the ratios to the first hold to 0.05 %.
    let hz = [14.56, 101.47, 298.59, 603.06, 1017.07];
    let roots = beam(TipJoint::Free, 5.0).roots(5);
    for (root, known) in roots.iter().zip(hz) {
        close((root / roots[0]).powi(2), known / hz[0], 5e-4);
    }
}

#[test]
fn a_heavy_hammer_on_a_light_beam_is_a_mass_on_a_spring() {
    // λ⁴ = 12 ε / (1 + 13/35 ε) guided, 3 ε / (1 + 33/140 ε) free (Rayleigh, static shapes; Blevins, Table 8-8), which
    // errs by the order of ε² (about 1e-3 ε² here); the mode's mass is the hammer's and that share of the beam's.
    for (tip, stiffness, share) in [
        (TipJoint::Guided, 12.0, 13.0 / 35.0),
        (TipJoint::Free, 3.0, 33.0 / 140.0),
    ] {
        let epsilon = 0.01;
        let beam = beam(tip, epsilon);
        let known: f64 = stiffness * epsilon / (1.0 + share * epsilon);
        close(beam.roots(1)[0], known.powf(0.25), 1e-6);
        let mode = beam.modes(0.298, 5.0, 1).unwrap()[0];
        close(mode.mass_kg, 0.298 * (1.0 + share * epsilon), 1e-5);
        close(mode.omega, TAU * 5.0, 1e-15);
    }
}

/// The loaded beam in finite elements with cubic shapes (Blevins' beam, μ = EI = L = 1): frequencies squared, tip
/// displacements and participations of modes of unit modal mass.
fn finite_elements(tip: TipJoint, hammer: f64, elements: usize) -> (DVector<f64>, Vec<(f64, f64)>) {
    let l = 1.0 / elements as f64;
    let stiffness = [
        [12.0, 6.0 * l, -12.0, 6.0 * l],
        [6.0 * l, 4.0 * l * l, -6.0 * l, 2.0 * l * l],
        [-12.0, -6.0 * l, 12.0, -6.0 * l],
        [6.0 * l, 2.0 * l * l, -6.0 * l, 4.0 * l * l],
    ];
    let mass = [
        [156.0, 22.0 * l, 54.0, -13.0 * l],
        [22.0 * l, 4.0 * l * l, 13.0 * l, -3.0 * l * l],
        [54.0, 13.0 * l, 156.0, -22.0 * l],
        [-13.0 * l, -3.0 * l * l, -22.0 * l, 4.0 * l * l],
    ];
    let all = 2 * (elements + 1);
    let (mut k, mut m) = (
        DMatrix::<f64>::zeros(all, all),
        DMatrix::<f64>::zeros(all, all),
    );
    for e in 0..elements {
        for i in 0..4 {
            for j in 0..4 {
                k[(2 * e + i, 2 * e + j)] += stiffness[i][j] / l.powi(3);
                m[(2 * e + i, 2 * e + j)] += mass[i][j] * l / 420.0;
            }
        }
    }
    m[(all - 2, all - 2)] += hammer;
    // Moved as a rigid whole: every displacement 1, no rotation.
    let rigid = DVector::from_fn(all, |i, _| if i % 2 == 0 { 1.0 } else { 0.0 });
    let pull = &m * rigid;
    let end = if tip == TipJoint::Guided {
        all - 1
    } else {
        all
    };
    let (k, m) = (
        k.view((2, 2), (end - 2, end - 2)).into_owned(),
        m.view((2, 2), (end - 2, end - 2)).into_owned(),
    );
    let lower = m.cholesky().unwrap().l();
    let inverse = lower.clone().try_inverse().unwrap();
    let eigen = SymmetricEigen::<f64, nalgebra::Dyn>::new(&inverse * k * inverse.transpose());
    let mut order: Vec<_> = (0..end - 2).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    let shapes = inverse.transpose() * &eigen.eigenvectors;
    let tip_row = all - 2 - 2;
    let told = |i: &usize| {
        let shape = shapes.column(*i);
        (shape[tip_row], shape.dot(&pull.rows(2, end - 2)))
    };
    (
        DVector::from_iterator(order.len(), order.iter().map(|i| eigen.eigenvalues[*i])),
        order.iter().map(told).collect(),
    )
}

#[test]
fn modes_are_those_of_a_finite_element_beam() {
    for tip in [TipJoint::Guided, TipJoint::Free] {
        for ratio in [0.03, 0.1, 0.5, 2.0] {
            // 40 elements: the fifth mode's frequency errs by about (λ/40)⁴/1440 = 1e-5.
            let (squares, told) = finite_elements(tip, 1.0 / ratio, 40);
            let modes = beam(tip, ratio).modes(1.0 / ratio, 1.0, 5).unwrap();
            for (i, mode) in modes.iter().enumerate() {
                close(mode.root, squares[i].powf(0.25), 2e-5);
                // Unit modal mass and tip φ: modal mass for a tip of 1 is 1/φ², participation Γ/φ.
                let (phi, gamma) = told[i];
                close(mode.mass_kg, 1.0 / (phi * phi), 2e-3);
                close(mode.participation_kg, gamma / phi, 2e-3);
            }
        }
    }
}

#[test]
fn modes_add_up_to_the_whole() {
    // All modes together carry the mass of beam and hammer, ΣΓ²/m, and answer a blow on the hammer as the hammer alone,
    // Σ1/m = 1/M (the beam is at rest at that instant): both are approached from below.
    for tip in [TipJoint::Guided, TipJoint::Free] {
        let (ratio, hammer) = (0.1, 0.298);
        let modes = beam(tip, ratio).modes(hammer, 4.5, 60).unwrap();
        let carried: f64 = modes
            .iter()
            .map(|m| m.participation_kg.powi(2) / m.mass_kg)
            .sum();
        let mobility: f64 = modes.iter().map(|m| 1.0 / m.mass_kg).sum();
        let whole = hammer * (1.0 + ratio);
        assert!(
            carried < whole && carried > whole * (1.0 - 2e-3),
            "{carried}"
        );
        let alone = 1.0 / hammer;
        assert!(
            mobility < alone && mobility > alone * (1.0 - 2e-3),
            "{mobility}"
        );
    }
}

#[test]
fn beams_that_make_no_sense_are_refused() {
    for ratio in [0.0, -0.1, f64::NAN, 11.0] {
        assert!(
            beam(TipJoint::Guided, ratio).modes(0.298, 4.5, 2).is_err(),
            "{ratio}"
        );
    }
}
