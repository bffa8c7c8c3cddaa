//! The derivative of the return map about an orbit, and what it says about stability.

use nalgebra::{Matrix4, Vector4};

use super::Section;
use crate::dual::Dual;

/// The two leading multipliers of an orbit: those of the largest modulus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Multipliers {
    /// Two real ones, the smaller first.
    Real(f64, f64),
    /// A complex pair of this modulus.
    Complex(f64),
}

impl Multipliers {
    /// Largest modulus: below 1 the orbit is stable.
    pub fn modulus(self) -> f64 {
        match self {
            Self::Real(a, b) => a.abs().max(b.abs()),
            Self::Complex(modulus) => modulus,
        }
    }
}

/// The monodromy matrix in units of A0 and A0 Ω: of the hammer alone (two rows), or of hammer and cart (four).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Monodromy {
    size: usize,
    rows: [[f64; 4]; 4],
}

/// The section point `x` with derivatives along its first `N` directions.
pub(crate) fn seeds<const N: usize>(x: Section) -> [Dual<N>; 4] {
    [0, 1, 2, 3].map(|i| {
        if i < N {
            Dual::variable(x[i], i)
        } else {
            Dual::constant(x[i])
        }
    })
}

impl Monodromy {
    /// The first `size` (2 or 4) rows and columns of `rows`.
    pub(crate) fn new(size: usize, rows: [[f64; 4]; 4]) -> Self {
        Self { size, rows }
    }

    /// Of a motion from [`seeds`] to `end`, in `units`.
    pub(crate) fn of_seeds<const N: usize>(end: [Dual<N>; 4], units: Section) -> Self {
        let mut rows = [[0.0; 4]; 4];
        for i in 0..N {
            for j in 0..N {
                rows[i][j] = end[i].eps[j] * units[j] / units[i];
            }
        }
        Self::new(N, rows)
    }

    /// How many rows and columns it has.
    pub fn size(&self) -> usize {
        self.size
    }

    /// What the end moves in direction `row` when the start moves in direction `column`.
    pub fn entry(&self, row: usize, column: usize) -> f64 {
        self.rows[row][column]
    }

    /// The hammer's part: its own two rows and columns.
    pub fn hammer(&self) -> [[f64; 2]; 2] {
        let [[a, b, ..], [c, d, ..], ..] = self.rows;
        [[a, b], [c, d]]
    }

    /// Its determinant: by how much volumes of the section shrink in all periods.
    pub fn determinant(&self) -> f64 {
        if self.size > 2 {
            return self.matrix().determinant();
        }
        let [[a, b], [c, d]] = self.hammer();
        a * d - b * c
    }

    fn matrix(&self) -> Matrix4<f64> {
        Matrix4::from_fn(|i, j| self.rows[i][j])
    }

    /// The two leading eigenvalues.
    pub fn multipliers(&self) -> Multipliers {
        if self.size > 2 {
            let [a, b] = self.leading();
            return if a.1 != 0.0 {
                Multipliers::Complex(a.0.hypot(a.1))
            } else {
                Multipliers::Real(a.0.min(b.0), a.0.max(b.0))
            };
        }
        let [[a, b], [c, d]] = self.hammer();
        let (mean, det) = (0.5 * (a + d), a * d - b * c);
        let discriminant = 0.25 * (a - d).powi(2) + b * c;
        if discriminant >= 0.0 {
            // The larger root directly, the other from the determinant: no cancellation.
            let big = mean + discriminant.sqrt().copysign(mean);
            let small = if big == 0.0 { 0.0 } else { det / big };
            Multipliers::Real(big.min(small), big.max(small))
        } else {
            Multipliers::Complex(det.sqrt())
        }
    }

    /// The two leading eigenvalues as (real part, imaginary part); of a complex pair the one above the real axis first.
    pub fn leading(&self) -> [(f64, f64); 2] {
        if self.size > 2 {
            let found = self.matrix().complex_eigenvalues();
            let mut all = [0, 1, 2, 3].map(|i| (found[i].re, found[i].im));
            let size = |x: &(f64, f64)| x.0.hypot(x.1);
            // A pair stands together: the one above the real axis first.
            all.sort_by(|a, b| size(b).total_cmp(&size(a)).then(b.1.total_cmp(&a.1)));
            return [all[0], all[1]];
        }
        let [[a, _], [_, d]] = self.hammer();
        match self.multipliers() {
            Multipliers::Real(small, big) => [(small, 0.0), (big, 0.0)],
            Multipliers::Complex(modulus) => {
                let re = 0.5 * (a + d);
                let im = (modulus * modulus - re * re).max(0.0).sqrt();
                [(re, im), (re, -im)]
            }
        }
    }

    /// det(I + M): passes 0 where a multiplier passes −1, a period doubling.
    pub fn doubling_test(&self) -> f64 {
        if self.size > 2 {
            return (Matrix4::identity() + self.matrix()).determinant();
        }
        let [[a, b], [c, d]] = self.hammer();
        1.0 + (a + d) + (a * d - b * c)
    }

    /// det(I − M): passes 0 where a multiplier passes +1, a fold.
    pub fn fold_test(&self) -> f64 {
        if self.size > 2 {
            return (Matrix4::identity() - self.matrix()).determinant();
        }
        let [[a, b], [c, d]] = self.hammer();
        1.0 - (a + d) + (a * d - b * c)
    }

    /// The slope of det(λI − M) at λ = 1: where it and [`Self::fold_test`] are 0, two multipliers are +1.
    pub(crate) fn slope_at_one(&self) -> f64 {
        if self.size > 2 {
            let left = Matrix4::identity() - self.matrix();
            let minor = |i: usize| left.remove_row(i).remove_column(i).determinant();
            return (0..4).map(minor).sum();
        }
        let [[a, _], [_, d]] = self.hammer();
        2.0 - (a + d)
    }

    /// The direction that the map turns round, M e = −e, at a period doubling.
    pub(crate) fn turned(&self) -> Section {
        if self.size > 2 {
            let svd = (Matrix4::identity() + self.matrix()).svd(false, true);
            let last = svd.v_t.map(|v| v.row(3).transpose());
            return last.map_or([0.0; 4], Into::into);
        }
        let [[a, b], [c, d]] = self.hammer();
        let (first, second) = ([-b, 1.0 + a], [1.0 + d, -c]);
        let size = |e: [f64; 2]| e[0].hypot(e[1]);
        super::on_course(if size(first) > size(second) {
            first
        } else {
            second
        })
    }

    /// The step to where the linearised map does not miss: (I − M) step = `miss`. Not finite where there is none.
    pub(crate) fn newton_step(&self, miss: Section) -> Section {
        if self.size > 2 {
            let solved = (Matrix4::identity() - self.matrix())
                .lu()
                .solve(&Vector4::from(miss));
            return solved.map_or([f64::NAN; 4], Into::into);
        }
        let [[a, b], [c, d]] = self.hammer();
        let (a, b, c, d) = (1.0 - a, -b, -c, 1.0 - d);
        let det = a * d - b * c;
        super::on_course([
            (d * miss[0] - b * miss[1]) / det,
            (a * miss[1] - c * miss[0]) / det,
        ])
    }
}
