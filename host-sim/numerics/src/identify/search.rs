//! Nelder–Mead, as Matlab's `fminsearch` that the chapter used (J. A. Nelder and R. Mead, A simplex method for
//! function minimization, The Computer Journal 7 (1965) 308–313), by the crate `argmin`.

use crate::parallel;
use argmin::core::{CostFunction, Error, Executor, State};
use argmin::solver::neldermead::NelderMead;

/// Where a search ended.
#[derive(Clone, Debug, PartialEq)]
pub struct SearchEnd {
    /// Where.
    pub x: Vec<f64>,
    /// The cost there.
    pub cost: f64,
    /// Costs computed.
    pub evaluations: u64,
}

struct Problem<'a, F>(&'a F);

impl<F: Fn(&[f64]) -> f64> CostFunction for Problem<'_, F> {
    type Param = Vec<f64>;
    type Output = f64;
    fn cost(&self, x: &Vec<f64>) -> Result<f64, Error> {
        Ok(self.0(x))
    }
}

/// The least of `cost` near `x`: the first simplex reaches `steps` from it; the search ends when the costs of its
/// corners differ by less than `tolerance`, or after `rounds`.
pub fn nelder_mead(
    cost: &impl Fn(&[f64]) -> f64,
    x: &[f64],
    steps: &[f64],
    tolerance: f64,
    rounds: u64,
) -> SearchEnd {
    let mut corners = vec![x.to_vec()];
    for (i, step) in steps.iter().enumerate() {
        let mut corner = x.to_vec();
        corner[i] += step;
        corners.push(corner);
    }
    let start = || SearchEnd {
        x: x.to_vec(),
        cost: cost(x),
        evaluations: 1,
    };
    let Ok(solver) = NelderMead::new(corners).with_sd_tolerance(tolerance) else {
        return start();
    };
    let ran = Executor::new(Problem(cost), solver)
        .configure(|state| state.max_iters(rounds))
        .timer(false)
        .run();
    let Ok(ran) = ran else { return start() };
    let evaluations = ran.problem.counts.get("cost_count").copied().unwrap_or(0);
    let state = ran.state();
    match state.get_best_param() {
        Some(best) => SearchEnd {
            x: best.clone(),
            cost: state.get_best_cost(),
            evaluations,
        },
        None => start(),
    }
}

/// What searches from several starts found.
pub struct Searched {
    /// The best.
    pub best: SearchEnd,
    /// Searches begun.
    pub starts: usize,
    /// How many of them ended at about the best cost.
    pub agreeing: usize,
    /// Costs computed.
    pub evaluations: u64,
}

/// Searches from each of `starts`, then twice more, with smaller simplexes, from the best point. `None` without starts.
pub fn from_all(
    cost: &(impl Fn(&[f64]) -> f64 + Sync),
    starts: &[Vec<f64>],
    steps: &[f64],
) -> Option<Searched> {
    let first = parallel::map(starts, |x| nelder_mead(cost, x, steps, 1e-3, 80));
    let mut evaluations: u64 = first.iter().map(|f| f.evaluations).sum();
    let mut best = first
        .iter()
        .min_by(|a, b| a.cost.total_cmp(&b.cost))
        .cloned()?;
    // A simplex that has collapsed is opened again, smaller.
    for share in [0.3, 0.05] {
        let steps: Vec<f64> = steps.iter().map(|s| s * share).collect();
        let again = nelder_mead(cost, &best.x, &steps, 1e-9, 200);
        evaluations += again.evaluations;
        if again.cost < best.cost {
            best = again;
        }
    }
    let near = 1e-2 * best.cost.abs() + 0.1;
    Some(Searched {
        agreeing: first.iter().filter(|f| f.cost < best.cost + near).count(),
        starts: starts.len(),
        best,
        evaluations,
    })
}
