//! Period doublings and folds between two neighbouring orbits of a curve.

use super::Special;
use super::family::{Family, Node, between as part, dot, minus};
use crate::orbit::Orbit;

/// Special points are located to this far along the curve, in units of [`super::family::Place`]: in Ω/ω or gap/A0,
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

/// The orbit between `a` and `b` at which `test` passes 0, if it does, by false position (the Illinois variant:
/// M. Dowell and P. Jarratt, BIT 11 (1971) 168–174).
fn root(family: &Family, a: &Node, b: &Node, test: Test) -> Option<Node> {
    let (mut low, mut high) = ((0.0, test(&a.orbit)), (1.0, test(&b.orbit)));
    if low.1.signum() == high.1.signum() {
        return None;
    }
    let moved = minus(b.place, a.place);
    let length = dot(moved, moved).sqrt();
    let mut best: Option<Node> = None;
    let mut side = 0;
    for _ in 0..60 {
        let secant = low.0 - low.1 * (high.0 - low.0) / (high.1 - low.1);
        let s = if secant > low.0 && secant < high.0 {
            secant
        } else {
            0.5 * (low.0 + high.0)
        };
        // A point of the chord lies in the plane normal to a's tangent in which its orbit is sought.
        let node = family.correct(part(a.place, b.place, s), a.tangent)?;
        let value = test(&node.orbit);
        let step = best.as_ref().map_or(f64::INFINITY, |n| {
            let d = minus(n.place, node.place);
            dot(d, d).sqrt()
        });
        best = Some(node);
        if value == 0.0 || step < 0.1 * TOLERANCE || (high.0 - low.0) * length < TOLERANCE {
            break;
        }
        if value.signum() == low.1.signum() {
            low = (s, value);
            if side == -1 {
                high.1 *= 0.5;
            }
            side = -1;
        } else {
            high = (s, value);
            if side == 1 {
                low.1 *= 0.5;
            }
            side = 1;
        }
    }
    best
}
