//! Steps along a curve over two parameters, and what ends it.

use super::graze::Windows;
use super::starts::Seed;
use super::{Codimension, Condition, System, TwoParameterCurve, TwoParameterPoint, marks};
use crate::continuation::CurveEnd;
use crate::continuation::march::{Break, both_ways, contacts_alike};
use crate::error::Error;
use crate::progress::{Progress, check, step};

/// Longest step along a curve, in the units of the unknowns.
const STRIDE: f64 = 0.06;
/// A shorter step than this ends the curve.
const SHORTEST: f64 = 1e-7;
/// A change of contacts is located when it is predicted nearer than this.
const BREAK_TOLERANCE: f64 = 1e-7;
/// The curve may turn by this much per step: the cosine of 14°.
const STRAIGHT: f64 = 0.97;
/// More points than this on one curve are not followed.
const MOST: usize = 4000;

/// The curves through `seeds`, each once. A step of progress is a seed.
///
/// # Errors
/// If the work is interrupted.
pub fn followed(seeds: &[Seed], progress: &dyn Progress) -> Result<Vec<TwoParameterCurve>, Error> {
    let mut curves: Vec<TwoParameterCurve> = Vec::new();
    for seed in seeds {
        if !curves.iter().any(|curve| curve.passes(seed)) {
            curves.push(follow(seed, progress)?);
        }
        step(progress, 1)?;
    }
    let order = |c: &TwoParameterCurve| {
        let kind = Condition::ALL.iter().position(|k| *k == c.condition);
        (kind, c.periods, c.impacts())
    };
    curves.sort_by_key(order);
    Ok(curves)
}

/// The curve through `seed`, both ways.
///
/// # Errors
/// If the work is interrupted.
pub fn follow(seed: &Seed, progress: &dyn Progress) -> Result<TwoParameterCurve, Error> {
    let march = |from: &TwoParameterPoint| march(seed.system, from, progress);
    let (points, ends) = both_ways(seed.point.clone(), TwoParameterPoint::turned, march);
    check(progress)?;
    let mut curve = TwoParameterCurve {
        condition: seed.system.condition,
        periods: seed.system.periods,
        points,
        ends,
        system: seed.system,
    };
    marks::at_ends(&mut curve);
    Ok(curve)
}

impl TwoParameterCurve {
    /// Its points at one value of one of the parameters (0 or 1).
    pub fn at(&self, parameter: usize, value: f64) -> Vec<TwoParameterPoint> {
        let place = self.system.plane.dimensions[parameter].place(value);
        let pairs = self.points.windows(2).filter_map(|pair| {
            let (a, b) = (&pair[0], &pair[1]);
            let (from, to) = (a.parameters()[parameter], b.parameters()[parameter]);
            let s = (place - from) / (to - from);
            if !(0.0..=1.0).contains(&s) {
                return None;
            }
            let mut guess = &a.x + s * (&b.x - &a.x);
            let n = guess.len();
            guess[n - 2 + parameter] = place;
            adapted(self.system, a).correct_at(&guess, parameter)
        });
        pairs.collect()
    }

    /// Whether `seed` lies on it.
    fn passes(&self, seed: &Seed) -> bool {
        /// Values of a parameter that differ by less are the same.
        const SAME: f64 = 1e-6;
        let wanted = &seed.point;
        if self.condition != seed.system.condition
            || self.periods != seed.system.periods
            || self.impacts() != wanted.impacts
        {
            return false;
        }
        let [first, second] = wanted.parameters();
        self.points.windows(2).any(|pair| {
            let (a, b) = (&pair[0], &pair[1]);
            let ([a1, a2], [b1, b2]) = (a.parameters(), b.parameters());
            let inside = (a2.min(b2) - SAME..=a2.max(b2) + SAME).contains(&second);
            let s = if a2 == b2 {
                0.0
            } else {
                ((second - a2) / (b2 - a2)).clamp(0.0, 1.0)
            };
            let reach = 0.02 + (b1 - a1).abs();
            if !inside || (a1 + s * (b1 - a1) - first).abs() > reach {
                return false;
            }
            let mut guess = &a.x + s * (&b.x - &a.x);
            let n = guess.len();
            guess[n - 1] = second;
            let system = adapted(self.system, a);
            let there = system.correct_at(&guess, 1);
            there.is_some_and(|p| (p.parameters()[0] - first).abs() < SAME)
        })
    }
}

/// `system` with the flights around the touch at `point`.
pub fn adapted(system: System, point: &TwoParameterPoint) -> System {
    let mut system = system;
    if let (Condition::Grazing, Some(contacts)) = (system.condition, &point.flights) {
        let phase = point.x[0].rem_euclid(1.0);
        system.windows = Windows::between(contacts, point.frequency_hz, phase, system.periods);
    }
    system
}

/// The points from `seed` on (without it), and what ends them.
fn march(
    system: System,
    seed: &TwoParameterPoint,
    progress: &dyn Progress,
) -> (Vec<TwoParameterPoint>, CurveEnd) {
    let mut points: Vec<TwoParameterPoint> = Vec::new();
    let mut last = seed.clone();
    let mut before: Option<TwoParameterPoint> = None;
    let mut stride = 0.5 * STRIDE;
    while points.len() < MOST && !progress.interrupted() {
        let system = adapted(system, &last);
        if let Some(near) = before.as_ref().and_then(|b| heading(b, &last)) {
            if near.distance < BREAK_TOLERANCE {
                return (points, near.end);
            }
            stride = stride.min(0.9 * near.distance);
        }
        let Some(next) = next(&system, &last, stride) else {
            stride *= 0.5;
            if stride < SHORTEST {
                return (points, ended(&last, before.as_ref()));
            }
            continue;
        };
        if let Some(cut) = at_limit(&system, &last, &next) {
            points.extend(marks::between(&system, &last, &cut));
            points.push(cut);
            return (points, CurveEnd::Limit);
        }
        points.extend(marks::between(&system, &last, &next));
        let closed = back_at(seed, &last, &next);
        points.push(next.clone());
        if closed {
            return (points, CurveEnd::Closed);
        }
        before = Some(std::mem::replace(&mut last, next));
        stride = (1.5 * stride).min(STRIDE);
    }
    (points, CurveEnd::Lost)
}

fn heading(before: &TwoParameterPoint, last: &TwoParameterPoint) -> Option<Break> {
    let apart = (&last.x - &before.x).norm();
    Break::ahead(apart, &before.margins, &last.margins)
}

/// The next point, if it is one of the same curve: the same contacts, and no sharp turn.
fn next(system: &System, last: &TwoParameterPoint, stride: f64) -> Option<TwoParameterPoint> {
    let guess = &last.x + stride * &last.tangent;
    let next = system.correct(&guess, &last.tangent)?;
    let near = (&next.x - &last.x).norm_squared() < 2.0 * stride * stride;
    let straight = next.tangent.dot(&last.tangent) > STRAIGHT;
    let leaves = next.leaving.is_none_or(|a| a > 0.0);
    let alike = next.impacts == last.impacts
        && next.onsets.len() == last.onsets.len()
        && contacts_alike(&last.onsets, &next.onsets, system.periods);
    (near && straight && leaves && alike).then_some(next)
}

/// No further point was found: what is near at the last.
fn ended(last: &TwoParameterPoint, before: Option<&TwoParameterPoint>) -> CurveEnd {
    /// What is predicted nearer than this has ended the curve.
    const NEAR: f64 = 1e-4;
    let near = before.and_then(|b| heading(b, last));
    near.filter(|near| near.distance < NEAR)
        .map_or(CurveEnd::Lost, |near| near.end)
}

/// The curve cut at the limit that lies between `last` and `next`.
fn at_limit(
    system: &System,
    last: &TwoParameterPoint,
    next: &TwoParameterPoint,
) -> Option<TwoParameterPoint> {
    let mut nearest: Option<(f64, usize, f64)> = None;
    let (from, to) = (last.parameters(), next.parameters());
    for k in 0..2 {
        let (low, high) = system.plane.dimensions[k].limits();
        for (limit, beyond) in [(low, to[k] < low), (high, to[k] > high)] {
            let s = ((limit - from[k]) / (to[k] - from[k])).clamp(0.0, 1.0);
            if beyond && nearest.is_none_or(|(t, ..)| s < t) {
                nearest = Some((s, k, limit));
            }
        }
    }
    let (s, k, limit) = nearest?;
    let mut guess = &last.x + s * (&next.x - &last.x);
    let n = guess.len();
    guess[n - 2 + k] = limit;
    // A curve that touches the limit only may have no point there: it ends where it was.
    let cut = system.correct_at(&guess, k).unwrap_or_else(|| last.clone());
    let along = cut.tangent.dot(&last.tangent) >= 0.0;
    Some(if along { cut } else { cut.turned() })
}

/// Whether the step from `last` to `next` has come back to `seed`.
fn back_at(seed: &TwoParameterPoint, last: &TwoParameterPoint, next: &TwoParameterPoint) -> bool {
    let step = &next.x - &last.x;
    let to_seed = &seed.x - &last.x;
    let share = to_seed.dot(&step) / step.norm_squared();
    if !(0.0..=1.0).contains(&share) || last.x == seed.x {
        return false;
    }
    let off = to_seed - share * &step;
    off.norm_squared() < 0.01 * step.norm_squared() && seed.tangent.dot(&next.tangent) > STRAIGHT
}

/// What ends a curve, as a second condition.
pub fn mark_of(system: &System, end: CurveEnd, last: &TwoParameterPoint) -> Option<Codimension> {
    /// A touch left slower than this, over A0 Ω², is about to be none.
    const PRESSED: f64 = 1e-3;
    match end {
        CurveEnd::Special(_) => Some(system.with_graze()),
        CurveEnd::Lost if last.leaving.is_some_and(|a| a < PRESSED) => {
            Some(Codimension::PressedGraze)
        }
        _ => None,
    }
}
