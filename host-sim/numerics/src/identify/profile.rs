//! How well each parameter is known: profile likelihood intervals.
//!
//! One parameter is held, all others are sought anew; where the misfit has risen by χ²(1) at 95 %, 3.841, the
//! interval ends (A. Raue et al., Structural and practical identifiability analysis of partially observed dynamical
//! models by exploiting the profile likelihood, Bioinformatics 25 (2009) 1923–1929,
//! doi:10.1093/bioinformatics/btp358). A misfit that does not rise so far says that the data do not fix the parameter.

use serde::Serialize;

use super::least_squares::Solved;
use super::unknowns::Unknowns;

/// The 95 % point of χ² with one degree of freedom.
const CHI_SQUARE_95: f64 = 3.841_458_820_694_124;

/// A parameter found, with its 95 % profile likelihood interval.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProfileEstimate {
    /// As rig files name it, unit included, or `release_mm`.
    pub key: &'static str,
    /// The value found, in the unit of its key.
    pub value: f64,
    /// Lower end of the 95 % interval; none: the data do not bound it.
    pub low: Option<f64>,
    /// Upper end of the 95 % interval; none: the data do not bound it.
    pub high: Option<f64>,
    /// Whether the value lies at the limit of what was searched.
    pub at_limit: bool,
    /// The other parameter that must move most with this one, and how closely (−1 to 1).
    pub strongest_correlation: Option<(&'static str, f64)>,
}

/// The misfit over one parameter, all others at their best.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// The parameter and its interval.
    pub estimate: ProfileEstimate,
    /// (value, rise of χ² over its least), by value.
    pub points: Vec<(f64, f64)>,
}

/// Profiles of all parameters, and how many costs were computed. `least` gives the least χ² near a point with the
/// coordinates named kept. Where a profile finds less than `best`, that becomes the best.
pub fn all(
    least: &dyn Fn(&[f64], &[usize]) -> Solved,
    unknowns: &Unknowns,
    best: &mut Solved,
    per_cost: f64,
) -> (Vec<Profile>, u64) {
    let mut evaluations = 0;
    let mut profiles = Vec::new();
    for _ in 0..3 {
        profiles.clear();
        let mut better: Option<Solved> = None;
        for held in 0..unknowns.list().len() {
            let mut search = Search {
                least,
                unknowns,
                best,
                per_cost,
                held,
                evaluations: 0,
                seen: vec![(best.x.clone(), 0.0)],
            };
            profiles.push(search.profile());
            evaluations += search.evaluations;
            let found = search.seen.iter().min_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((x, rise)) = found
                && *rise < -0.05
            {
                better = Some(least(x, &[]));
            }
        }
        match better {
            Some(found) if found.cost < best.cost => *best = found,
            _ => break,
        }
    }
    (profiles, evaluations)
}

struct Search<'a> {
    least: &'a dyn Fn(&[f64], &[usize]) -> Solved,
    unknowns: &'a Unknowns,
    best: &'a Solved,
    per_cost: f64,
    held: usize,
    evaluations: u64,
    /// Points found: where, and the rise of χ².
    seen: Vec<(Vec<f64>, f64)>,
}

impl Search<'_> {
    fn profile(&mut self) -> Profile {
        let unknown = self.unknowns.list()[self.held];
        let centre = self.best.x[self.held];
        let span = unknown.range.1 - unknown.range.0;
        let (low, high) = if self.per_cost.is_finite() {
            (self.end(-1.0), self.end(1.0))
        } else {
            (None, None)
        };
        let strongest_correlation = self.correlation(low, high);
        // A few more, for the picture.
        for end in [low, high].into_iter().flatten() {
            for share in [0.35, 0.7, 1.6] {
                let x = centre + share * (end - centre);
                if x > unknown.range.0 && x < unknown.range.1 {
                    self.rise(x);
                }
            }
        }
        let value = |x: f64| unknown.value(x);
        let near = |limit: f64| (centre - limit).abs() < 1e-3 * span;
        let mut points: Vec<_> = self
            .seen
            .iter()
            .map(|(x, rise)| (value(x[self.held]), *rise))
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Profile {
            estimate: ProfileEstimate {
                key: unknown.key,
                value: value(centre),
                low: low.map(value),
                high: high.map(value),
                at_limit: near(unknown.range.0) || near(unknown.range.1),
                strongest_correlation,
            },
            points,
        }
    }

    /// The rise of χ² with the held parameter at `x`.
    fn rise(&mut self, x: f64) -> f64 {
        let held = self.held;
        let (from, to) = self.unknowns.list()[held].range;
        let x = x.clamp(from, to);
        // Begin from the nearest point known.
        let near = |a: &&(Vec<f64>, f64), b: &&(Vec<f64>, f64)| {
            (a.0[held] - x).abs().total_cmp(&(b.0[held] - x).abs())
        };
        let nearest = self.seen.iter().min_by(near);
        let mut whole = nearest.map_or_else(|| self.best.x.clone(), |s| s.0.clone());
        whole[held] = x;
        let found = (self.least)(&whole, &[held]);
        self.evaluations += found.evaluations;
        let (whole, cost) = (found.x, found.cost);
        let rise = (cost - self.best.cost) / self.per_cost;
        self.seen.push((whole, rise));
        rise
    }

    /// The coordinate at which χ² has risen by 3.841, on one side.
    fn end(&mut self, side: f64) -> Option<f64> {
        let unknown = self.unknowns.list()[self.held];
        let limit = if side < 0.0 {
            unknown.range.0
        } else {
            unknown.range.1
        };
        let centre = self.best.x[self.held];
        let room = (limit - centre).abs();
        let off = |rise: f64| rise - CHI_SQUARE_95;
        // Outwards until it is crossed.
        let mut inner = (0.0, off(0.0));
        let mut reach = (1e-4 * (unknown.range.1 - unknown.range.0)).min(0.5 * room);
        let mut outer = loop {
            if reach <= 0.0 {
                return None;
            }
            let there = off(self.rise(centre + side * reach));
            if there >= 0.0 {
                break (reach, there);
            }
            if reach >= room {
                return None;
            }
            inner = (reach, there);
            // A parabola's next guess, but at least twice and at most eight times as far.
            let risen = (there + CHI_SQUARE_95).max(1e-3);
            let factor = (1.2 * (CHI_SQUARE_95 / risen).sqrt()).clamp(2.0, 8.0);
            reach = (reach * factor).min(room);
        };
        // Regula falsi in the root of the rise, which is nearly straight, kept inside by bisection.
        let root = |o: f64| (o + CHI_SQUARE_95).max(0.0).sqrt() - CHI_SQUARE_95.sqrt();
        for round in 0..12 {
            let (a, b) = (root(inner.1), root(outer.1));
            let share = if round % 3 == 2 {
                0.5
            } else {
                (a / (a - b)).clamp(0.02, 0.98)
            };
            let x = inner.0 + share * (outer.0 - inner.0);
            let there = off(self.rise(centre + side * x));
            if there >= 0.0 {
                outer = (x, there);
            } else {
                inner = (x, there);
            }
            if there.abs() < 0.02 || outer.0 - inner.0 < 1e-3 * outer.0 {
                return Some(centre + side * x);
            }
        }
        Some(centre + side * outer.0)
    }

    /// How closely the parameter is tied to the others, and to which most: the one that moves farthest along the
    /// profile.
    fn correlation(&self, low: Option<f64>, high: Option<f64>) -> Option<(&'static str, f64)> {
        let (low, high) = (low?, high?);
        let at = |x: f64| {
            let near = |a: &&(Vec<f64>, f64), b: &&(Vec<f64>, f64)| {
                let d = |s: &(Vec<f64>, f64)| (s.0[self.held] - x).abs();
                d(a).total_cmp(&d(b))
            };
            self.seen.iter().min_by(near).map(|s| s.0.clone())
        };
        let (a, b) = (at(low)?, at(high)?);
        let own = b[self.held] - a[self.held];
        if own == 0.0 {
            return None;
        }
        // With the others held, how far could this one go? ρ² = 1 − (alone/profiled)².
        let rho = (1.0 - (self.alone(own) / own).powi(2)).max(0.0).sqrt();
        let travel = |i: usize| (b[i] - a[i]) / self.unknowns.list()[i].step;
        let others = (0..self.unknowns.list().len()).filter(|i| *i != self.held);
        let partner = others.max_by(|i, j| travel(*i).abs().total_cmp(&travel(*j).abs()))?;
        let sign = (travel(partner) * own).signum();
        Some((self.unknowns.list()[partner].key, sign * rho))
    }

    /// The width over which χ² rises by 3.841 with every other parameter held at its best, and the sensor sought, from the
    /// curvature.
    fn alone(&self, own: f64) -> f64 {
        let h = 0.25 * own;
        let at = |side: f64| {
            let mut x = self.best.x.clone();
            x[self.held] += side * h;
            let sought: Vec<usize> = (0..self.unknowns.list().len()).collect();
            let cost = (self.least)(&x, &sought).cost;
            (cost - self.best.cost) / self.per_cost
        };
        let curvature = 0.5 * (at(-1.0) + at(1.0)) / (h * h);
        if curvature > 0.0 {
            2.0 * (CHI_SQUARE_95 / curvature).sqrt()
        } else {
            own
        }
    }
}
