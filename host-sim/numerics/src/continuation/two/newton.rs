//! The next point of a curve: Newton's iteration on its equations in the plane across the curve.

use nalgebra::{DMatrix, DVector};

use super::conditions::System;
use super::{TwoParameterPoint, dot, length, minus};

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
    pub fn correct(&self, guess: &[f64], direction: &[f64]) -> Option<TwoParameterPoint> {
        let n = guess.len();
        let mut x = guess.to_vec();
        for _ in 0..ITERATIONS {
            let miss = self.miss(&x)?;
            let system = self.bordered(&x, &miss, direction)?;
            let mut right = DVector::from_iterator(n, miss.iter().map(|m| -m).chain([0.0]));
            right[n - 1] = -dot(direction, &minus(&x, guess));
            let lu = system.lu();
            let step = lu.solve(&right)?;
            let far = step.norm();
            if !far.is_finite() {
                return None;
            }
            x.iter_mut().zip(step.iter()).for_each(|(x, s)| *x += s);
            let moved = length(&minus(&x, guess));
            if moved.is_nan() || moved > FARTHEST {
                return None;
            }
            if far < STILL {
                let mut along = DVector::zeros(n);
                along[n - 1] = 1.0;
                let tangent = lu.solve(&along)?.normalize();
                return self.point(x, tangent.iter().copied().collect());
            }
        }
        None
    }

    /// The derivatives of the equations by the unknowns, and the direction as the last row.
    fn bordered(&self, x: &[f64], miss: &[f64], direction: &[f64]) -> Option<DMatrix<f64>> {
        let n = x.len();
        let mut system = DMatrix::zeros(n, n);
        let columns: Option<Vec<Vec<f64>>> = (0..n)
            .map(|j| {
                let mut beside = x.to_vec();
                beside[j] += DIFFERENCE;
                // At an end of what a parameter may be, the other side.
                let side = match self.miss(&beside) {
                    Some(there) => Some((there, DIFFERENCE)),
                    None => {
                        beside[j] = x[j] - DIFFERENCE;
                        self.miss(&beside).map(|there| (there, -DIFFERENCE))
                    }
                };
                let (there, step) = side?;
                Some(
                    there
                        .iter()
                        .zip(miss)
                        .map(|(t, m)| (t - m) / step)
                        .collect(),
                )
            })
            .collect();
        for (j, column) in columns?.into_iter().enumerate() {
            for (i, entry) in column.into_iter().enumerate() {
                system[(i, j)] = entry;
            }
        }
        for (j, d) in direction.iter().enumerate() {
            system[(n - 1, j)] = *d;
        }
        Some(system)
    }

    /// The point at fixed values of one of the parameters, near `guess`.
    pub fn correct_at(&self, guess: &[f64], parameter: usize) -> Option<TwoParameterPoint> {
        let n = guess.len();
        let mut direction = vec![0.0; n];
        direction[n - 2 + parameter] = 1.0;
        self.correct(guess, &direction)
    }
}
