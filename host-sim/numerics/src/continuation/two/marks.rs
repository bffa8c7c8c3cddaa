//! Points of codimension two: where a curve has a second condition.

use nalgebra::Vector2;

use super::follow::mark_of;
use super::{Codimension, Condition, System, TwoParameterCurve, TwoParameterPoint};

use crate::root::false_position;

/// A mark is located to this far along the curve.
const TOLERANCE: f64 = 1e-9;

/// A function of a point that passes 0 at a mark.
type Test<'a> = Box<dyn Fn(&TwoParameterPoint) -> f64 + 'a>;

/// The marks between two neighbouring points, in their order.
pub fn between(
    system: &System,
    a: &TwoParameterPoint,
    b: &TwoParameterPoint,
) -> Vec<TwoParameterPoint> {
    let doubling: fn(&TwoParameterPoint) -> f64 = |p| p.tests[0];
    let fold: fn(&TwoParameterPoint) -> f64 = |p| p.tests[1];
    let mut tests: Vec<(Codimension, Test)> = Vec::new();
    match system.condition {
        Condition::PeriodDoubling => tests.push((Codimension::FoldDoubling, Box::new(fold))),
        Condition::Fold => {
            tests.push((Codimension::FoldDoubling, Box::new(doubling)));
            // The parameters stand still and turn back there.
            let onwards = shift(a);
            tests.push((Codimension::Cusp, Box::new(move |p| shift(p).dot(&onwards))));
            if system.recoils() {
                tests.push((Codimension::Resonance, Box::new(|p| p.tests[2])));
            }
        }
        Condition::Grazing => {
            tests.push((Codimension::FoldGraze, Box::new(fold)));
            tests.push((Codimension::DoublingGraze, Box::new(doubling)));
        }
    }
    let mut found: Vec<TwoParameterPoint> = tests
        .into_iter()
        .filter_map(|(kind, test)| {
            let mut point = root(system, a, b, &test)?;
            point.mark = Some(kind);
            let still = shift(&point).norm() < 1e-3;
            (kind != Codimension::Cusp || still).then_some(point)
        })
        .collect();
    let along = |p: &TwoParameterPoint| (&p.x - &a.x).dot(&a.tangent);
    found.sort_by(|p, q| along(p).total_cmp(&along(q)));
    found
}

/// How both parameters go on along the curve.
fn shift(point: &TwoParameterPoint) -> Vector2<f64> {
    let n = point.tangent.len();
    point.tangent.fixed_rows::<2>(n - 2).into_owned()
}

/// The point between `a` and `b` at which `test` passes 0, if it does.
fn root(
    system: &System,
    a: &TwoParameterPoint,
    b: &TwoParameterPoint,
    test: &Test,
) -> Option<TwoParameterPoint> {
    let chord = &b.x - &a.x;
    let at = |s| {
        let point = system.correct(&(&a.x + s * &chord), &a.tangent)?;
        let value = test(&point);
        Some((point, value))
    };
    false_position([test(a), test(b)], at, |last, point, _| {
        last.is_some_and(|last| (&last.x - &point.x).norm() < 0.1 * TOLERANCE)
    })
}

/// Marks the first and the last point, where what ends the curve there is a second condition.
pub fn at_ends(curve: &mut TwoParameterCurve) {
    let [low, high] = curve.ends;
    let system = curve.system;
    for (end, first) in [(low, true), (high, false)] {
        let point = if first {
            curve.points.first_mut()
        } else {
            curve.points.last_mut()
        };
        if let Some(point) = point {
            let mark = mark_of(&system, end, point);
            point.mark = point.mark.or(mark);
        }
    }
}
