//! Period doublings and folds between two neighbouring orbits of a curve.

use super::Special;
use super::family::{Family, Node, between as part, dot, minus};
use crate::orbit::Orbit;
use crate::root::false_position;

/// Special points are located to this far along the curve, in units of [`super::family::CurvePlace`]: in Ω/ω or gap/A0,
/// to no more than this.
pub const TOLERANCE: f64 = 1e-9;

/// A function of an orbit that passes 0 where something special happens.
type Test = fn(&Orbit) -> f64;

/// The special points between `a` and `b`, in their order.
pub fn between(family: &Family, a: &Node, b: &Node) -> Vec<Node> {
    let tests: [(Special, Test); 2] = [
        (Special::PeriodDoubling, Orbit::doubling_test),
        (Special::Fold, Orbit::fold_test),
    ];
    let mut found: Vec<Node> = tests
        .into_iter()
        .filter_map(|(kind, test)| {
            let mut node = root(family, a, b, test)?;
            node.special = Some(kind);
            Some(node)
        })
        .collect();
    let along = |node: &Node| dot(minus(node.place, a.place), a.tangent);
    found.sort_by(|p, q| along(p).total_cmp(&along(q)));
    found
}

/// The orbit between `a` and `b` at which `test` passes 0, if it does.
fn root(family: &Family, a: &Node, b: &Node, test: Test) -> Option<Node> {
    let apart = |a: &Node, b: &Node| {
        let d = minus(b.place, a.place);
        dot(d, d).sqrt()
    };
    let at = |s| {
        // A point of the chord lies in the plane normal to a's tangent in which its orbit is sought.
        let node = family.correct(part(a.place, b.place, s), a.tangent)?;
        let value = test(&node.orbit);
        Some((node, value))
    };
    let whole = apart(a, b);
    false_position([test(&a.orbit), test(&b.orbit)], at, |last, node, left| {
        left * whole < TOLERANCE || last.is_some_and(|last| apart(last, node) < 0.1 * TOLERANCE)
    })
}
