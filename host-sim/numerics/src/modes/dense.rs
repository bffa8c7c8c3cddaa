//! Square matrices of a size known only when the modes are: what matrix exponentials need, and no more.

/// A square matrix, by rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Square {
    size: usize,
    at: Vec<f64>,
}

impl Square {
    /// The zero matrix with `size` rows.
    pub fn zero(size: usize) -> Self {
        Self {
            size,
            at: vec![0.0; size * size],
        }
    }

    /// The identity matrix with `size` rows.
    pub fn one(size: usize) -> Self {
        let mut one = Self::zero(size);
        for i in 0..size {
            one.row_mut(i)[i] = 1.0;
        }
        one
    }

    /// Row `i`, counted from 0.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.at[i * self.size..(i + 1) * self.size]
    }

    /// Row `i`, to be changed.
    pub fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.at[i * self.size..(i + 1) * self.size]
    }

    /// This matrix times `x`, into `y`.
    pub fn apply(&self, x: &[f64], y: &mut [f64]) {
        for (y, row) in y.iter_mut().zip(self.at.chunks_exact(self.size)) {
            *y = dot(row, x);
        }
    }

    /// The row `x` times this matrix.
    pub fn after(&self, x: &[f64]) -> Vec<f64> {
        let mut row = vec![0.0; self.size];
        self.after_into(x, &mut row);
        row
    }

    /// The row `x` times this matrix, into `row`: of a transposed matrix what [`apply`](Self::apply) does, some times as fast,
    /// since no sum waits for the one before.
    pub fn after_into(&self, x: &[f64], row: &mut [f64]) {
        row.fill(0.0);
        for (factor, own) in x.iter().zip(self.at.chunks_exact(self.size)) {
            row.iter_mut().zip(own).for_each(|(r, a)| *r += factor * a);
        }
    }

    /// Rows and columns exchanged.
    pub fn transposed(&self) -> Self {
        let mut turned = Self::zero(self.size);
        for i in 0..self.size {
            for (k, x) in self.row(i).iter().enumerate() {
                turned.row_mut(k)[i] = *x;
            }
        }
        turned
    }

    /// This matrix times `other`.
    pub fn times(&self, other: &Self) -> Self {
        let mut product = Self::zero(self.size);
        for i in 0..self.size {
            for (k, factor) in self.row(i).iter().enumerate() {
                if *factor != 0.0 {
                    let row = &mut product.at[i * self.size..(i + 1) * self.size];
                    for (sum, x) in row.iter_mut().zip(other.row(k)) {
                        *sum += factor * x;
                    }
                }
            }
        }
        product
    }

    /// e^(A h) by its series, for ‖A‖ h not much above 1.
    pub fn exponential(&self, h: f64) -> Self {
        let mut sum = Self::one(self.size);
        let mut term = sum.clone();
        for k in 1..=TERMS {
            term = term.times(self);
            term.at.iter_mut().for_each(|x| *x *= h / k as f64);
            sum.at.iter_mut().zip(&term.at).for_each(|(s, t)| *s += t);
        }
        sum
    }

    /// e^(A h) x by the same series.
    pub fn exponential_of(&self, h: f64, x: &[f64]) -> Vec<f64> {
        let (mut sum, mut term) = (x.to_vec(), x.to_vec());
        let mut next = vec![0.0; self.size];
        for k in 1..=TERMS {
            self.apply(&term, &mut next);
            for ((s, t), n) in sum.iter_mut().zip(&mut term).zip(&next) {
                *t = n * h / k as f64;
                *s += *t;
            }
        }
        sum
    }

    /// The terms of the same series in h: e^(A h) x for many h.
    pub fn series(&self, x: &[f64]) -> Series {
        let mut terms = vec![x.to_vec()];
        for k in 1..=TERMS {
            let mut next = vec![0.0; self.size];
            self.apply(&terms[k - 1], &mut next);
            next.iter_mut().for_each(|x| *x /= k as f64);
            terms.push(next);
        }
        Series(terms)
    }

    /// The block of the first `size` rows and columns.
    pub fn block(&self, size: usize) -> Self {
        let mut block = Self::zero(size);
        for i in 0..size {
            block.row_mut(i).copy_from_slice(&self.row(i)[..size]);
        }
        block
    }

    /// (I − this) x = `b`, by elimination with pivots. `None` if it has no one solution.
    pub fn solve_fixed(&self, b: &[f64]) -> Option<Vec<f64>> {
        let n = self.size;
        let mut a = Self::one(n);
        a.at.iter_mut().zip(&self.at).for_each(|(a, m)| *a -= m);
        let mut x = b.to_vec();
        for column in 0..n {
            let size = |i: &usize| a.row(*i)[column].abs();
            let pivot = (column..n).max_by(|i, j| size(i).total_cmp(&size(j)))?;
            if size(&pivot) <= 1e-300 || !size(&pivot).is_finite() {
                return None;
            }
            for k in 0..n {
                a.at.swap(column * n + k, pivot * n + k);
            }
            x.swap(column, pivot);
            for below in column + 1..n {
                let by = a.row(below)[column] / a.row(column)[column];
                for k in column..n {
                    a.at[below * n + k] -= by * a.at[column * n + k];
                }
                x[below] -= by * x[column];
            }
        }
        for i in (0..n).rev() {
            let known: f64 = (i + 1..n).map(|k| a.row(i)[k] * x[k]).sum();
            x[i] = (x[i] - known) / a.row(i)[i];
        }
        Some(x)
    }

    /// The largest modulus of an eigenvalue, as ‖Mᵏ‖^(1/k) with k = 2¹⁶ (Gelfand).
    pub fn spectral_radius(&self) -> f64 {
        const DOUBLINGS: i32 = 16;
        let (mut power, mut log) = (self.clone(), 0.0);
        for k in 0..=DOUBLINGS {
            let norm = power.at.iter().fold(0.0_f64, |n, x| n.max(x.abs()));
            if norm == 0.0 || !norm.is_finite() {
                return norm;
            }
            log += norm.ln() / 2.0_f64.powi(k);
            if k < DOUBLINGS {
                power.at.iter_mut().for_each(|x| *x /= norm);
                power = power.times(&power);
            }
        }
        log.exp()
    }
}

/// e^(A h) x as a power series in h.
#[derive(Clone, Debug)]
pub struct Series(Vec<Vec<f64>>);

impl Series {
    /// The sum of the products with `weights`.
    pub fn seen(&self, weights: &[f64]) -> Polynomial {
        let terms = self.0.iter();
        Polynomial(terms.map(|term| dot(term, weights)).collect())
    }
}

/// A polynomial, by rising powers.
#[derive(Clone, Debug)]
pub struct Polynomial(Vec<f64>);

impl Polynomial {
    /// Value of the polynomial at `h`.
    pub fn at(&self, h: f64) -> f64 {
        self.0.iter().rev().fold(0.0, |sum, c| sum * h + c)
    }

    /// Derivative of the polynomial at `h`.
    pub fn slope(&self, h: f64) -> f64 {
        let terms = self.0.iter().enumerate().skip(1).rev();
        terms.fold(0.0, |sum, (k, c)| sum * h + k as f64 * c)
    }
}

/// Terms of the series: with ‖A‖ h = 1 the first one left out is 1e-21.
const TERMS: usize = 20;

/// The sum of the products.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A turn by 0.3 about one axis, damped, beside a number that grows as e^(0.5 t).
    fn turning() -> Square {
        let mut a = Square::zero(3);
        a.row_mut(0).copy_from_slice(&[-0.1, -0.3, 0.0]);
        a.row_mut(1).copy_from_slice(&[0.3, -0.1, 0.0]);
        a.row_mut(2)[2] = 0.5;
        a
    }

    #[test]
    fn the_exponential_turns_and_grows() {
        let e = turning().exponential(2.0);
        let (sin, cos) = 0.6_f64.sin_cos();
        let fading = (-0.2_f64).exp();
        for (row, expected) in [
            [fading * cos, -fading * sin, 0.0],
            [fading * sin, fading * cos, 0.0],
            [0.0, 0.0, 1.0_f64.exp()],
        ]
        .iter()
        .enumerate()
        {
            for (x, known) in e.row(row).iter().zip(expected) {
                assert!((x - known).abs() < 1e-14);
            }
        }
        let x = [0.3, -2.0, 0.7];
        let mut by_matrix = [0.0; 3];
        e.apply(&x, &mut by_matrix);
        let by_series = turning().exponential_of(2.0, &x);
        for (a, b) in by_matrix.iter().zip(by_series) {
            assert!((a - b).abs() < 1e-14);
        }
        let seen = turning().series(&x).seen(&[1.0, 2.0, 3.0]);
        assert!((seen.at(2.0) - dot(&by_matrix, &[1.0, 2.0, 3.0])).abs() < 1e-13);
        let mut rates = [0.0; 3];
        turning().apply(&by_matrix, &mut rates);
        assert!((seen.slope(2.0) - dot(&rates, &[1.0, 2.0, 3.0])).abs() < 1e-13);
        let row = turning().after(&[1.0, 2.0, 3.0]);
        assert!((seen.slope(2.0) - dot(&row, &by_matrix)).abs() < 1e-13);
    }

    #[test]
    fn a_fixed_point_is_solved_and_the_radius_is_that_of_the_largest_eigenvalue() {
        let m = turning().exponential(2.0).block(2);
        let x = m.solve_fixed(&[1.0, -0.5]).unwrap();
        let mut image = [0.0; 2];
        m.apply(&x, &mut image);
        assert!((x[0] - image[0] - 1.0).abs() < 1e-14);
        assert!((x[1] - image[1] + 0.5).abs() < 1e-14);
        assert!((m.spectral_radius() / (-0.2_f64).exp() - 1.0).abs() < 1e-4);
        let all = turning().exponential(2.0);
        assert!((all.spectral_radius() / 1.0_f64.exp() - 1.0).abs() < 1e-4);
        assert_eq!(Square::one(2).solve_fixed(&[1.0, 0.0]), None);
    }
}
