//! The next point of a curve: Newton's iteration on its equations in the plane across the curve.

use nalgebra::{DMatrix, DVector};

use super::TwoParameterPoint;
use super::conditions::System;

/// Newton steps of one correction.
const ITERATIONS: usize = 10;
/// A point is found when Newton's step is shorter than this, in the units of the unknowns. The step is still taken.
const STILL: f64 = 1e-8;
/// The longest correction to a guess that is believed.
const FARTHEST: f64 = 0.5;
/// Differences from which the derivatives are taken. They decide how fast Newton's iteration converges, and not where it
/// ends.
const DIFFERENCE: f64 = 1e-7;

impl System {
    /// The point in the plane through `guess` normal to `direction`; its tangent points along `direction`.
    pub fn correct(
        &self,
        guess: &DVector<f64>,
        direction: &DVector<f64>,
    ) -> Option<TwoParameterPoint> {
        let n = guess.len();
        let mut x = guess.clone();
        for _ in 0..ITERATIONS {
            let miss = self.miss(x.as_slice())?;
            let lu = self.bordered(&x, &miss, direction)?.lu();
            let off = direction.dot(&(&x - guess));
            let right = miss.iter().map(|m| -m).chain([-off]);
            let step = lu.solve(&DVector::from_iterator(n, right))?;
            let far = step.norm();
            if !far.is_finite() {
                return None;
            }
            x += &step;
            let moved = (&x - guess).norm();
            if moved.is_nan() || moved > FARTHEST {
                return None;
            }
            if far < STILL {
                let mut along = DVector::zeros(n);
                along[n - 1] = 1.0;
                return self.point(x, lu.solve(&along)?.normalize());
            }
        }
        None
    }

    /// The derivatives of the equations by the unknowns, and the direction as the last row.
    fn bordered(
        &self,
        x: &DVector<f64>,
        miss: &[f64],
        direction: &DVector<f64>,
    ) -> Option<DMatrix<f64>> {
        let n = x.len();
        let mut columns = Vec::with_capacity(n * n);
        for j in 0..n {
            let there = |by: f64| {
                let mut beside = x.clone();
                beside[j] += by;
                Some((self.miss(beside.as_slice())?, by))
            };
            // At an end of what a parameter may be, the other side.
            let (there, step) = there(DIFFERENCE).or_else(|| there(-DIFFERENCE))?;
            columns.extend(there.iter().zip(miss).map(|(t, m)| (t - m) / step));
            columns.push(direction[j]);
        }
        Some(DMatrix::from_vec(n, n, columns))
    }

    /// The point at fixed values of one of the parameters, near `guess`.
    pub fn correct_at(&self, guess: &DVector<f64>, parameter: usize) -> Option<TwoParameterPoint> {
        let n = guess.len();
        let mut direction = DVector::zeros(n);
        direction[n - 2 + parameter] = 1.0;
        self.correct(guess, &direction)
    }
}
