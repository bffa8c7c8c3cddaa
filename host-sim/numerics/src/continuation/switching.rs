//! From one curve to another: onto the doubled orbits at a period doubling, and to the other side of a graze.

use super::family::{Family, Node, ahead, dot, minus};
use crate::orbit::on_course;

/// Lengths of the first step onto another curve that are tried, in units of [`super::family::CurvePlace`].
const FIRST_STEPS: [f64; 6] = [1e-2, 5e-3, 2e-3, 5e-4, 1e-4, 2e-5];

/// The first orbit of twice the period beside the doubling at `node`, with its curve's direction away from there.
///
/// At the doubling M e = −e, so the twice-iterated map neither grows nor shrinks e: that is where the doubled orbits
/// leave. `None` if none with twice as many contacts is found.
pub fn doubled(family: &Family, node: &Node) -> Option<(Family, Node)> {
    let twice = family.with_periods(2 * family.periods());
    let direction = family.direction(node, node.orbit.monodromy.turned());
    let found = FIRST_STEPS.into_iter().find_map(|step| {
        let start = twice.correct(ahead(node.place, step, direction), direction)?;
        let moved = minus(start.place, node.place);
        let near = dot(moved, moved) < 9.0 * step * step;
        // The halves of a true doubled orbit lie on either side of the one that doubled.
        let apart = family.place(on_course(start.orbit.asymmetry(2, [1.0; 2])), 0.0);
        let doubled = dot(apart, apart).sqrt() > 0.5 * step;
        let contacts = start.orbit.impacts == 2 * node.orbit.impacts;
        (near && doubled && contacts).then_some(start)
    });
    found.map(|start| (twice, start))
}
