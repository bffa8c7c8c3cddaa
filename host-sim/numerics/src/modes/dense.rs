//! Square matrices of a size known only when the modes are: what matrix exponentials need, and no more.

/// Numbers that are worked on at a time.
const BLOCK: usize = 8;

/// A square matrix, by columns, each filled up with zeros to whole blocks: so that no sum waits for the one before.
#[derive(Clone, Debug, PartialEq)]
pub struct Square {
    size: usize,
    columns: Vec<[f64; BLOCK]>,
}

impl Square {
    /// The zero matrix with `size` rows.
    pub fn zero(size: usize) -> Self {
        Self {
            size,
            columns: vec![[0.0; BLOCK]; size * size.div_ceil(BLOCK)],
        }
    }

    /// The identity matrix with `size` rows.
    pub fn one(size: usize) -> Self {
        let mut one = Self::zero(size);
        for i in 0..size {
            *one.at_mut(i, i) = 1.0;
        }
        one
    }

    fn column(&self, k: usize) -> &[[f64; BLOCK]] {
        let blocks = self.size.div_ceil(BLOCK);
        &self.columns[k * blocks..(k + 1) * blocks]
    }

    /// The number in row `i` and column `k`, both counted from 0.
    pub fn at(&self, i: usize, k: usize) -> f64 {
        self.column(k).as_flattened()[i]
    }

    /// The number in row `i` and column `k`, to be changed.
    pub fn at_mut(&mut self, i: usize, k: usize) -> &mut f64 {
        let blocks = self.size.div_ceil(BLOCK);
        &mut self.columns.as_flattened_mut()[k * blocks * BLOCK + i]
    }

    /// Sets row `i`, counted from 0.
    pub fn set_row(&mut self, i: usize, row: &[f64]) {
        for (k, x) in row.iter().enumerate() {
            *self.at_mut(i, k) = *x;
        }
    }

    /// Block `b` of this matrix times `x`.
    #[inline]
    fn block_of(&self, b: usize, x: &[f64]) -> [f64; BLOCK] {
        let mut sums = [0.0; BLOCK];
        let columns = self.columns.chunks_exact(self.size.div_ceil(BLOCK));
        for (x, column) in x.iter().zip(columns) {
            for (sum, a) in sums.iter_mut().zip(&column[b]) {
                *sum += x * a;
            }
        }
        sums
    }

    /// This matrix times `x`, into `y`.
    pub fn apply(&self, x: &[f64], y: &mut [f64]) {
        for (b, y) in y.chunks_mut(BLOCK).enumerate() {
            y.copy_from_slice(&self.block_of(b, x)[..y.len()]);
        }
    }

    /// This matrix times `x`.
    pub fn of(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; self.size];
        self.apply(x, &mut y);
        y
    }

    /// The row `x` times this matrix.
    pub fn after(&self, x: &[f64]) -> Vec<f64> {
        (0..self.size)
            .map(|k| dot(x, &self.column(k).as_flattened()[..self.size]))
            .collect()
    }

    /// This matrix times `other`.
    pub fn times(&self, other: &Self) -> Self {
        let mut product = Self::zero(self.size);
        let blocks = self.size.div_ceil(BLOCK);
        for (k, column) in product.columns.chunks_exact_mut(blocks).enumerate() {
            let factors = &other.column(k).as_flattened()[..self.size];
            for (b, block) in column.iter_mut().enumerate() {
                *block = self.block_of(b, factors);
            }
        }
        product
    }

    /// e^(A h), for ‖A‖ h not much above 1.
    pub fn exponential(&self, h: f64) -> Self {
        let mut exponential = Self::one(self.size);
        let blocks = self.size.div_ceil(BLOCK);
        for column in exponential.columns.chunks_exact_mut(blocks) {
            let numbers = &mut column.as_flattened_mut()[..self.size];
            numbers.copy_from_slice(&self.exponential_of(h, numbers));
        }
        exponential
    }

    /// e^(A h) x by the series of the exponential, until it no longer changes.
    pub fn exponential_of(&self, h: f64, x: &[f64]) -> Vec<f64> {
        let (mut sum, mut term) = (x.to_vec(), x.to_vec());
        let (mut next, mut unchanged) = (vec![0.0; self.size], 0);
        for k in 1..=TERMS {
            self.apply(&term, &mut next);
            let (mut is_same, share) = (true, h / k as f64);
            for ((s, t), n) in sum.iter_mut().zip(&mut term).zip(&next) {
                *t = n * share;
                is_same &= *s == *s + *t;
                *s += *t;
            }
            unchanged = if is_same { unchanged + 1 } else { 0 };
            if unchanged == UNCHANGED {
                break;
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
            for k in 0..size {
                *block.at_mut(i, k) = self.at(i, k);
            }
        }
        block
    }

    /// (I − this) x = `b`, by elimination with pivots. `None` if it has no one solution.
    pub fn solve_fixed(&self, b: &[f64]) -> Option<Vec<f64>> {
        let n = self.size;
        let mut a = Self::one(n);
        let own = self.columns.as_flattened();
        let from = a.columns.as_flattened_mut().iter_mut();
        from.zip(own).for_each(|(a, m)| *a -= m);
        let mut x = b.to_vec();
        for column in 0..n {
            let size = |i: &usize| a.at(*i, column).abs();
            let pivot = (column..n).max_by(|i, j| size(i).total_cmp(&size(j)))?;
            if size(&pivot) <= 1e-300 || !size(&pivot).is_finite() {
                return None;
            }
            for k in 0..n {
                let (own, other) = (a.at(column, k), a.at(pivot, k));
                (*a.at_mut(column, k), *a.at_mut(pivot, k)) = (other, own);
            }
            x.swap(column, pivot);
            for below in column + 1..n {
                let by = a.at(below, column) / a.at(column, column);
                for k in column..n {
                    *a.at_mut(below, k) -= by * a.at(column, k);
                }
                x[below] -= by * x[column];
            }
        }
        for i in (0..n).rev() {
            let known: f64 = (i + 1..n).map(|k| a.at(i, k) * x[k]).sum();
            x[i] = (x[i] - known) / a.at(i, i);
        }
        Some(x)
    }

    /// The largest modulus of an eigenvalue, as ‖Mᵏ‖^(1/k) with k = 2¹⁶ (Gelfand).
    pub fn spectral_radius(&self) -> f64 {
        const DOUBLINGS: i32 = 16;
        let (mut power, mut log) = (self.clone(), 0.0);
        for k in 0..=DOUBLINGS {
            let numbers = power.columns.as_flattened_mut();
            let norm = numbers.iter().fold(0.0_f64, |n, x| n.max(x.abs()));
            if norm == 0.0 || !norm.is_finite() {
                return norm;
            }
            log += norm.ln() / 2.0_f64.powi(k);
            if k < DOUBLINGS {
                numbers.iter_mut().for_each(|x| *x /= norm);
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

/// Terms in a row that change nothing, after which the series ends.
const UNCHANGED: u32 = 2;

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
        a.set_row(0, &[-0.1, -0.3, 0.0]);
        a.set_row(1, &[0.3, -0.1, 0.0]);
        *a.at_mut(2, 2) = 0.5;
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
            for (k, known) in expected.iter().enumerate() {
                assert!((e.at(row, k) - known).abs() < 1e-14);
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
