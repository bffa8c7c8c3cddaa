//! Least squares by the method of Levenberg and Marquardt, between bounds (D. W. Marquardt, An algorithm for
//! least-squares estimation of nonlinear parameters, SIAM Journal 11 (1963) 431–441).

use nalgebra::{DMatrix, DVector};

use crate::parallel;

/// Residuals whose squares are summed, and what is known about the coordinates.
pub trait Problem {
    /// What is kept of a point for its derivatives.
    type Seen;
    /// The residuals at `x`; `None` where there are none.
    fn residuals(&self, x: &[f64]) -> Option<(DVector<f64>, Self::Seen)>;
    /// Their derivative by the coordinate `k`.
    fn column(&self, x: &[f64], at: &(DVector<f64>, Self::Seen), k: usize) -> Option<DVector<f64>>;
    /// The range of the coordinate `k` for a search that is at `x`.
    fn range(&self, x: &[f64], k: usize) -> (f64, f64);
}

/// Where a search ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Solved {
    /// Coordinates of the point where it ended.
    pub x: Vec<f64>,
    /// The sum of squares there.
    pub cost: f64,
    /// Residuals and derivatives computed.
    pub evaluations: u64,
}

impl Solved {
    /// No least near `x`: nothing can be computed there.
    pub fn nowhere(x: &[f64]) -> Self {
        Self {
            x: x.to_vec(),
            cost: f64::INFINITY,
            evaluations: 1,
        }
    }

    /// The better of the two, this one if they are equal; what both computed.
    pub fn or_better(self, other: Self) -> Self {
        let evaluations = self.evaluations + other.evaluations;
        let best = if other.cost < self.cost { other } else { self };
        Self {
            evaluations,
            ..best
        }
    }
}

/// What searches from several starts found.
pub struct Searched {
    /// Where the best of them ended, searched on from there.
    pub best: Solved,
    /// The sums of squares with which they ended.
    pub ended: Vec<f64>,
    /// Residuals and derivatives computed.
    pub evaluations: u64,
}

impl Searched {
    /// How many of the searches ended at about the best.
    pub fn agreeing(&self) -> usize {
        let near = 1.01 * self.best.cost + 0.5;
        self.ended.iter().filter(|cost| **cost < near).count()
    }
}

/// Searches `first` from each of `starts`, then on to the `last` from where the best of them ended. None if none finds
/// anything.
pub fn from_all(
    starts: &[Vec<f64>],
    first: impl Fn(&[f64]) -> Option<Solved> + Sync,
    last: impl Fn(&[f64]) -> Option<Solved>,
) -> Option<Searched> {
    let ended = parallel::map(starts, |start| first(start));
    let ended: Vec<Solved> = ended.into_iter().flatten().collect();
    let nearest = ended.iter().min_by(|a, b| a.cost.total_cmp(&b.cost))?;
    let best = last(&nearest.x)?;
    let before: u64 = ended.iter().map(|s| s.evaluations).sum();
    Some(Searched {
        ended: ended.iter().map(|s| s.cost).collect(),
        evaluations: before + best.evaluations,
        best: if nearest.cost < best.cost {
            nearest.clone()
        } else {
            best
        },
    })
}

/// A search is over when a round lowers the sum by less than this, or this share of it if that is less.
const LEAST_GAIN: f64 = 1e-3;

/// The least sum of squares near `x`, the coordinates `held` kept, in at most `rounds` rounds.
pub fn solve<P: Problem>(problem: &P, x: &[f64], held: &[usize], rounds: usize) -> Option<Solved> {
    let mut x = x.to_vec();
    let mut here = problem.residuals(&x)?;
    let mut cost = here.0.norm_squared();
    let mut evaluations = 1;
    let mut damping = 1e-3;
    let free: Vec<usize> = (0..x.len()).filter(|k| !held.contains(k)).collect();
    let rounds = if free.is_empty() { 0 } else { rounds };
    for _ in 0..rounds {
        let columns: Option<Vec<_>> = free.iter().map(|k| problem.column(&x, &here, *k)).collect();
        let columns = columns?;
        evaluations += columns.len() as u64;
        let square = products(&columns);
        let slope = DVector::from_fn(columns.len(), |i, _| columns[i].dot(&here.0));
        let least = LEAST_GAIN * cost.min(1.0);
        let mut gained = 0.0;
        for _ in 0..8 {
            let there = step(problem, &x, &free, &square, &slope, damping);
            let by = DVector::from_iterator(free.len(), free.iter().map(|k| there[*k] - x[*k]));
            if -(2.0 * slope.dot(&by) + by.dot(&(&square * &by))) < least {
                break;
            }
            evaluations += 1;
            if let Some(seen) = problem.residuals(&there) {
                let found = seen.0.norm_squared();
                if found < cost {
                    gained = cost - found;
                    (x, here, cost) = (there, seen, found);
                    damping = (damping * 0.1).max(1e-9);
                    break;
                }
            }
            damping *= 8.0;
        }
        if gained < least || cost < 1e-9 {
            break;
        }
    }
    Some(Solved {
        x,
        cost,
        evaluations,
    })
}

/// JᵀJ of a Jacobian's columns.
fn products(columns: &[DVector<f64>]) -> DMatrix<f64> {
    let mut square = DMatrix::zeros(columns.len(), columns.len());
    for (i, a) in columns.iter().enumerate() {
        for (j, b) in columns[..=i].iter().enumerate() {
            square[(i, j)] = a.dot(b);
            square[(j, i)] = square[(i, j)];
        }
    }
    square
}

/// The next point: coordinates that would leave their range go to its end, and the others are sought anew.
fn step<P: Problem>(
    problem: &P,
    x: &[f64],
    free: &[usize],
    square: &DMatrix<f64>,
    slope: &DVector<f64>,
    damping: f64,
) -> Vec<f64> {
    let mut moved: Vec<Option<f64>> = vec![None; free.len()];
    // None of it outside its range by rounding.
    let arrived = |moved: &[Option<f64>]| {
        let mut there = x.to_vec();
        for (k, by) in free.iter().zip(moved) {
            let (low, high) = problem.range(x, *k);
            if let Some(by) = by {
                there[*k] = (x[*k] + by).clamp(low, high);
            }
        }
        there
    };
    for _ in 0..4 {
        let open: Vec<usize> = (0..free.len()).filter(|i| moved[*i].is_none()).collect();
        let mut matrix =
            DMatrix::from_fn(open.len(), open.len(), |i, j| square[(open[i], open[j])]);
        for i in 0..open.len() {
            let size = matrix[(i, i)];
            matrix[(i, i)] += damping * size + 1e-12 * size.max(1e-30) + 1e-30;
        }
        let right = DVector::from_fn(open.len(), |i, _| {
            let fixed = moved.iter().enumerate();
            let pushed: f64 = fixed
                .filter_map(|(j, d)| Some(square[(open[i], j)] * (*d)?))
                .sum();
            -slope[open[i]] - pushed
        });
        let Some(found) = matrix.cholesky().map(|c| c.solve(&right)) else {
            return x.to_vec();
        };
        let mut clipped = false;
        for (i, d) in open.iter().zip(found.iter()) {
            let k = free[*i];
            let (low, high) = problem.range(x, k);
            if x[k] + d < low || x[k] + d > high {
                moved[*i] = Some((x[k] + d).clamp(low, high) - x[k]);
                clipped = true;
            }
        }
        if !clipped {
            for (i, d) in open.into_iter().zip(found.iter()) {
                moved[i] = Some(*d);
            }
            break;
        }
    }
    arrived(&moved)
}

/// The covariance of the coordinates about a least sum of squares: the inverse of JᵀJ. Coordinates that the residuals do
/// not depend on are given none.
pub fn covariance<P: Problem>(problem: &P, x: &[f64]) -> Option<DMatrix<f64>> {
    let here = problem.residuals(x)?;
    let columns: Option<Vec<_>> = (0..x.len()).map(|k| problem.column(x, &here, k)).collect();
    let products = products(&columns?);
    // Scaled to ones on the diagonal, so that units do not matter.
    let scale: Vec<f64> = (0..x.len()).map(|k| products[(k, k)].sqrt()).collect();
    let scaled = |of: &DMatrix<f64>, own: f64| {
        DMatrix::from_fn(x.len(), x.len(), |i, j| match scale[i] * scale[j] {
            by if by > 0.0 => of[(i, j)] / by,
            _ if i == j => own,
            _ => 0.0,
        })
    };
    let mut square = scaled(&products, 1.0);
    (0..x.len()).for_each(|i| square[(i, i)] += 1e-12);
    let inverse = scaled(&square.cholesky()?.inverse(), 0.0);
    Some(inverse)
}
