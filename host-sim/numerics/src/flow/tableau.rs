//! Coefficients of Dormand and Prince's Runge–Kutta method of order 8 with embedded estimates of orders
//! 5 and 3 (Hairer, Nørsett and Wanner, *Solving Ordinary Differential Equations I*, 2nd ed., II.5 and
//! II.10). The tests check the row sums and the order conditions of quadrature.

/// The length to try after a step of length `h` whose `error` is more than the tolerance.
pub fn shorter(h: f64, error: f64) -> f64 {
    h * (0.9 * error.powf(-0.125)).clamp(0.2, 0.9)
}

/// The length to try after a step of length `h` with this `error` was accepted.
pub fn next(h: f64, error: f64) -> f64 {
    h * (0.9 * error.max(1e-12).powf(-0.125)).clamp(0.2, 6.0)
}

/// The error of a step from its estimates of orders 5 and 3 (Hairer, Nørsett and Wanner, II.10).
pub fn combined(fifth: f64, third: f64) -> f64 {
    if fifth == 0.0 {
        0.0
    } else {
        fifth * fifth / length(fifth, 0.1 * third)
    }
}

/// √(a² + b²): `hypot` only where the squares overflow or vanish, as it takes ten times as long.
#[inline]
pub fn length(a: f64, b: f64) -> f64 {
    let square = a * a + b * b;
    if square.is_normal() {
        square.sqrt()
    } else {
        a.hypot(b)
    }
}

/// Stages per step.
pub const STAGES: usize = 12;

/// Nodes of the stages, as shares of the step.
pub const C: [f64; STAGES] = [
    0.0,
    0.05260015195876773,
    0.0789002279381516,
    0.1183503419072274,
    0.2816496580927726,
    0.3333333333333333,
    0.25,
    0.3076923076923077,
    0.6512820512820513,
    0.6,
    0.8571428571428571,
    1.0,
];

/// Stage weights: for each stage the (earlier stage, weight) pairs that are not zero.
pub const A: [&[(usize, f64)]; STAGES] = [
    &[],
    &[(0, 0.05260015195876773)],
    &[(0, 0.0197250569845379), (1, 0.0591751709536137)],
    &[(0, 0.02958758547680685), (2, 0.08876275643042054)],
    &[
        (0, 0.2413651341592667),
        (2, -0.8845494793282861),
        (3, 0.924834003261792),
    ],
    &[
        (0, 0.037037037037037035),
        (3, 0.17082860872947386),
        (4, 0.12546768756682242),
    ],
    &[
        (0, 0.037109375),
        (3, 0.17025221101954405),
        (4, 0.06021653898045596),
        (5, -0.017578125),
    ],
    &[
        (0, 0.03709200011850479),
        (3, 0.17038392571223998),
        (4, 0.10726203044637328),
        (5, -0.015319437748624402),
        (6, 0.008273789163814023),
    ],
    &[
        (0, 0.6241109587160757),
        (3, -3.3608926294469414),
        (4, -0.868219346841726),
        (5, 27.59209969944671),
        (6, 20.154067550477894),
        (7, -43.48988418106996),
    ],
    &[
        (0, 0.47766253643826434),
        (3, -2.4881146199716677),
        (4, -0.590290826836843),
        (5, 21.230051448181193),
        (6, 15.279233632882423),
        (7, -33.28821096898486),
        (8, -0.020331201708508627),
    ],
    &[
        (0, -0.9371424300859873),
        (3, 5.186372428844064),
        (4, 1.0914373489967295),
        (5, -8.149787010746927),
        (6, -18.52006565999696),
        (7, 22.739487099350505),
        (8, 2.4936055526796523),
        (9, -3.0467644718982196),
    ],
    &[
        (0, 2.273310147516538),
        (3, -10.53449546673725),
        (4, -2.0008720582248625),
        (5, -17.9589318631188),
        (6, 27.94888452941996),
        (7, -2.8589982771350235),
        (8, -8.87285693353063),
        (9, 12.360567175794303),
        (10, 0.6433927460157636),
    ],
];

/// Weights of the solution of order 8.
pub const B: &[(usize, f64)] = &[
    (0, 0.054293734116568765),
    (5, 4.450312892752409),
    (6, 1.8915178993145003),
    (7, -5.801203960010585),
    (8, 0.3111643669578199),
    (9, -0.1521609496625161),
    (10, 0.20136540080403034),
    (11, 0.04471061572777259),
];

/// The weights [`B`] by stage: 0 for those that do not count.
pub const WEIGHTS: [f64; STAGES] = {
    let (mut weights, mut k) = ([0.0; STAGES], 0);
    while k < B.len() {
        weights[B[k].0] = B[k].1;
        k += 1;
    }
    weights
};

/// Weights of the error estimate of order 5.
pub const E5: &[(usize, f64)] = &[
    (0, 0.01312004499419488),
    (5, -1.2251564463762044),
    (6, -0.4957589496572502),
    (7, 1.6643771824549864),
    (8, -0.35032884874997366),
    (9, 0.3341791187130175),
    (10, 0.08192320648511571),
    (11, -0.022355307863886294),
];

/// Weights of the error estimate of order 3.
pub const E3: &[(usize, f64)] = &[
    (0, -0.18980075407240762),
    (5, 4.450312892752409),
    (6, 1.8915178993145003),
    (7, -5.801203960010585),
    (8, -0.4226823213237919),
    (9, -0.1521609496625161),
    (10, 0.20136540080403034),
    (11, 0.02265179219836082),
];

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(weights: &[(usize, f64)], power: i32) -> f64 {
        weights.iter().map(|(i, w)| w * C[*i].powi(power)).sum()
    }

    #[test]
    fn rows_sum_to_their_nodes() {
        for (row, node) in A.iter().zip(C) {
            assert!((sum(row, 0) - node).abs() < 2e-14, "{node}");
        }
    }

    #[test]
    fn the_weights_integrate_polynomials_up_to_degree_seven() {
        for power in 0..8 {
            let exact = 1.0 / f64::from(power + 1);
            assert!((sum(B, power) - exact).abs() < 1e-14, "{power}");
        }
        assert!((sum(B, 8) - 1.0 / 9.0).abs() > 1e-6, "and not beyond");
    }

    #[test]
    fn the_estimates_vanish_on_what_both_orders_integrate() {
        assert!(sum(E5, 0).abs() < 1e-14 && sum(E3, 0).abs() < 1e-14);
        assert!(sum(E5, 4).abs() < 1e-14 && sum(E3, 2).abs() < 1e-14);
    }
}
