//! The derivative of the return map over one period: of the hammer alone, or of hammer and cart.

use super::march::ForecastSection;

/// Squarings of the matrix until only its largest multiplier is left: ‖M^n‖^(1/n) is then within 1e-5 of it.
const SQUARINGS: u8 = 18;

/// The matrix, row by row, in units of A0 and A0 Ω.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ForecastMonodromy {
    /// A prescribed cart: coordinate and rate of the hammer.
    Hammer([[f32; 2]; 2]),
    /// A cart that recoils: the same, and the cart's deviation and its rate.
    Both([[f32; 4]; 4]),
}

impl ForecastMonodromy {
    /// Whether every number in it is one.
    pub fn is_finite(&self) -> bool {
        match self {
            Self::Hammer(rows) => rows.iter().flatten().all(|x| x.is_finite()),
            Self::Both(rows) => rows.iter().flatten().all(|x| x.is_finite()),
        }
    }

    /// Largest modulus of the multipliers.
    pub fn multiplier(&self) -> f32 {
        match self {
            Self::Hammer([[a, b], [c, d]]) => {
                let (trace, determinant) = (a + d, a * d - b * c);
                let quarter = 0.25 * trace * trace - determinant;
                if quarter < 0.0 {
                    libm::sqrtf(determinant)
                } else {
                    0.5 * libm::fabsf(trace) + libm::sqrtf(quarter)
                }
            }
            Self::Both(rows) => spectral_radius(*rows),
        }
    }

    /// det(I + M), the characteristic polynomial at −1: zero where the period doubles and positive before.
    pub fn doubling_test(&self) -> f32 {
        match self {
            Self::Hammer([[a, b], [c, d]]) => 1.0 + (a + d) + (a * d - b * c),
            Self::Both(rows) => Minors::of(&about_identity(rows, 1.0)).determinant(),
        }
    }

    /// The step to where the linearised map does not miss: (I − M) step = `miss`. Not finite where there is none.
    pub fn newton_step(&self, miss: ForecastSection) -> ForecastSection {
        match self {
            Self::Hammer([[a, b], [c, d]]) => {
                let [m0, m1, ..] = miss;
                let (c00, c01, c10, c11) = (1.0 - a, -b, -c, 1.0 - d);
                let det = c00 * c11 - c01 * c10;
                let step = [(c11 * m0 - c01 * m1) / det, (c00 * m1 - c10 * m0) / det];
                let [q, v] = step;
                [q, v, 0.0, 0.0]
            }
            Self::Both(rows) => solve(&about_identity(rows, -1.0), miss),
        }
    }
}

type Rows = [[f32; 4]; 4];

/// I + `sign` M.
fn about_identity(rows: &Rows, sign: f32) -> Rows {
    let [[a, b, c, d], [e, f, g, h], [i, j, k, l], [m, n, o, p]] =
        rows.map(|row| row.map(|x| sign * x));
    [
        [1.0 + a, b, c, d],
        [e, 1.0 + f, g, h],
        [i, j, 1.0 + k, l],
        [m, n, o, 1.0 + p],
    ]
}

/// The minors of the upper two rows and of the lower two.
struct Minors {
    upper: [f32; 6],
    lower: [f32; 6],
}

impl Minors {
    fn of(&[first, second, third, fourth]: &Rows) -> Self {
        Self {
            upper: minors(first, second),
            lower: minors(third, fourth),
        }
    }

    fn determinant(&self) -> f32 {
        let [s0, s1, s2, s3, s4, s5] = self.upper;
        let [c0, c1, c2, c3, c4, c5] = self.lower;
        s0 * c5 - s1 * c4 + s2 * c3 + s3 * c2 - s4 * c1 + s5 * c0
    }
}

/// The determinants of the columns 01, 02, 03, 12, 13 and 23 of two rows.
fn minors([a0, a1, a2, a3]: [f32; 4], [b0, b1, b2, b3]: [f32; 4]) -> [f32; 6] {
    [
        a0 * b1 - b0 * a1,
        a0 * b2 - b0 * a2,
        a0 * b3 - b0 * a3,
        a1 * b2 - b1 * a2,
        a1 * b3 - b1 * a3,
        a2 * b3 - b2 * a3,
    ]
}

/// The solution of `rows` x = `right` by the adjugate.
fn solve(rows: &Rows, right: ForecastSection) -> ForecastSection {
    let by_two = Minors::of(rows);
    let det = by_two.determinant();
    let ([s0, s1, s2, s3, s4, s5], [c0, c1, c2, c3, c4, c5]) = (by_two.upper, by_two.lower);
    let [
        [a00, a01, a02, a03],
        [a10, a11, a12, a13],
        [a20, a21, a22, a23],
        [a30, a31, a32, a33],
    ] = *rows;
    let adjugate = [
        [
            a11 * c5 - a12 * c4 + a13 * c3,
            -a01 * c5 + a02 * c4 - a03 * c3,
            a31 * s5 - a32 * s4 + a33 * s3,
            -a21 * s5 + a22 * s4 - a23 * s3,
        ],
        [
            -a10 * c5 + a12 * c2 - a13 * c1,
            a00 * c5 - a02 * c2 + a03 * c1,
            -a30 * s5 + a32 * s2 - a33 * s1,
            a20 * s5 - a22 * s2 + a23 * s1,
        ],
        [
            a10 * c4 - a11 * c2 + a13 * c0,
            -a00 * c4 + a01 * c2 - a03 * c0,
            a30 * s4 - a31 * s2 + a33 * s0,
            -a20 * s4 + a21 * s2 - a23 * s0,
        ],
        [
            -a10 * c3 + a11 * c1 - a12 * c0,
            a00 * c3 - a01 * c1 + a02 * c0,
            -a30 * s3 + a31 * s1 - a32 * s0,
            a20 * s3 - a21 * s1 + a22 * s0,
        ],
    ];
    let [x, y, z, w] = right;
    adjugate.map(|[a, b, c, d]| (a * x + b * y + c * z + d * w) / det)
}

/// The sum of `rows` weighed by the numbers of `row`.
fn combined([a, b, c, d]: [f32; 4], rows: &Rows) -> [f32; 4] {
    let [
        [r0, r1, r2, r3],
        [s0, s1, s2, s3],
        [t0, t1, t2, t3],
        [u0, u1, u2, u3],
    ] = *rows;
    [
        a * r0 + b * s0 + c * t0 + d * u0,
        a * r1 + b * s1 + c * t1 + d * u1,
        a * r2 + b * s2 + c * t2 + d * u2,
        a * r3 + b * s3 + c * t3 + d * u3,
    ]
}

/// The largest modulus of the eigenvalues, as the limit of ‖M^n‖^(1/n) (Gelfand): the matrix is squared again and again,
/// and scaled to a largest entry of 1 before each time.
fn spectral_radius(mut rows: Rows) -> f32 {
    let (mut logarithm, mut share) = (0.0_f32, 1.0_f32);
    for _ in 0..SQUARINGS {
        let largest = (rows.iter().flatten()).fold(0.0_f32, |most, x| {
            let x = libm::fabsf(*x);
            if x > most { x } else { most }
        });
        if largest == 0.0 {
            return 0.0;
        }
        logarithm += share * libm::logf(largest);
        share *= 0.5;
        let scaled = rows.map(|row| row.map(|x| x / largest));
        rows = scaled.map(|row| combined(row, &scaled));
    }
    libm::expf(logarithm)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix4, Vector4};

    fn matrix(rows: &Rows) -> Matrix4<f64> {
        Matrix4::from_fn(|i, j| f64::from(rows[i][j]))
    }

    /// Matrices of several kinds: a nearly defective one, a complex pair, one with two vanishing multipliers, random ones.
    fn examples() -> std::vec::Vec<Rows> {
        let mut all = std::vec![
            [
                [0.5, 1.0, 0.0, 0.0],
                [0.0, 0.5001, 0.0, 0.0],
                [0.0; 4],
                [0.0; 4]
            ],
            [
                [0.3, -0.9, 0.1, 0.0],
                [0.8, 0.2, 0.0, 0.3],
                [1e-6, 0.0, 1e-7, 0.0],
                [0.0, 1e-6, 0.0, 1e-8]
            ],
        ];
        let mut seed = 1_u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        for _ in 0..200 {
            all.push([0; 4].map(|_| [0; 4].map(|_| random())));
        }
        all
    }

    #[test]
    fn multiplier_doubling_and_step_are_those_of_the_matrix() {
        for rows in examples() {
            let exact = matrix(&rows);
            let found = ForecastMonodromy::Both(rows);
            let radius = exact
                .complex_eigenvalues()
                .iter()
                .fold(0.0_f64, |most, x| most.max(x.re.hypot(x.im)));
            let off = f64::from(found.multiplier()) / radius - 1.0;
            // Two equal ones: n^(1/n) is all that is left of them.
            assert!(off.abs() < 1e-4, "{rows:?}: {off}");
            let doubling = (Matrix4::identity() + exact).determinant();
            assert!(
                (f64::from(found.doubling_test()) - doubling).abs() < 1e-5,
                "{rows:?}"
            );
            let inverse = (Matrix4::identity() - exact)
                .try_inverse()
                .expect("regular");
            let miss = [0.3, -0.2, 0.1, 0.4];
            let wanted = inverse * Vector4::from(miss.map(f64::from));
            let condition = inverse.norm() * (Matrix4::identity() - exact).norm();
            for (found, wanted_one) in found.newton_step(miss).into_iter().zip(wanted.iter()) {
                let off = (f64::from(found) - wanted_one).abs() / wanted.norm();
                assert!(
                    off < 1e-6 * condition,
                    "{rows:?}: {off}, condition {condition}"
                );
            }
        }
    }

    #[test]
    fn a_hammer_alone_is_the_upper_left_of_both() {
        let hammer = [[0.4, -1.1], [0.3, 0.2]];
        let both = [
            [0.4, -1.1, 0.0, 0.0],
            [0.3, 0.2, 0.0, 0.0],
            [0.0; 4],
            [0.0; 4],
        ];
        let (alone, both) = (
            ForecastMonodromy::Hammer(hammer),
            ForecastMonodromy::Both(both),
        );
        assert!((alone.multiplier() - both.multiplier()).abs() < 1e-5);
        assert!((alone.doubling_test() - both.doubling_test()).abs() < 1e-6);
        let miss = [0.1, 0.2, 0.0, 0.0];
        for (a, b) in alone
            .newton_step(miss)
            .into_iter()
            .zip(both.newton_step(miss))
        {
            assert!((a - b).abs() < 1e-6);
        }
    }

    #[test]
    fn what_is_no_number_is_not_finite_and_nothing_has_no_multiplier() {
        let mut rows = [[0.1; 4]; 4];
        assert!(ForecastMonodromy::Both(rows).is_finite());
        rows[2][3] = f32::NAN;
        assert!(!ForecastMonodromy::Both(rows).is_finite());
        assert!(!ForecastMonodromy::Hammer([[f32::INFINITY, 0.0], [0.0; 2]]).is_finite());
        assert_eq!(ForecastMonodromy::Both([[0.0; 4]; 4]).multiplier(), 0.0);
    }
}
