//! Steps along a curve of orbits, and what ends it.

use super::Special;
use super::family::{Family, Node, UP, ahead, between, dot, minus};
use super::locate;
use crate::orbit::{Orbit, OrbitWatch};

/// What ends a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CurveEnd {
    /// The range asked for ends; the curve goes on.
    Limit,
    /// Its last orbit has this special, at which it was asked to stop or cannot go on as what it is.
    Special(Special),
    /// The doubled orbits have closed on orbits of half their period.
    Halved,
    /// The curve has come back to where it began.
    Closed,
    /// No further orbit of as many contacts was found, and none of its contacts grazes.
    Lost,
    /// The flight between two of its contacts has shrunk to nothing: beyond, they are one.
    Merged,
}

/// How far to go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Until {
    /// To the end of the curve.
    End,
    /// To the first special point.
    Special,
}

/// Longest step, in units of [`super::family::CurvePlace`].
const STRIDE: f64 = 0.04;
/// A shorter step than this ends the curve.
const SHORTEST: f64 = 1e-8;
/// A graze is located when it is predicted nearer than this.
const GRAZING_TOLERANCE: f64 = 1e-8;
/// The curve may turn by this much per step: the cosine of 18°.
const STRAIGHT: f64 = 0.95;
/// More orbits than this on one curve are not followed.
const MOST: usize = 4000;

/// Follows the curve from `seed` along its tangent while the parameter stays within `limits`. The seed itself is not
/// among the orbits returned.
pub fn march(
    family: &Family,
    seed: &Node,
    limits: (f64, f64),
    until: Until,
) -> (Vec<Node>, CurveEnd) {
    let mut nodes: Vec<Node> = Vec::new();
    let mut last = seed.clone();
    let mut before: Option<Node> = None;
    let mut stride = 0.5 * STRIDE;
    while nodes.len() < MOST {
        if let Some(near) = before.as_ref().and_then(|b| Break::of(b, &last)) {
            if near.distance < GRAZING_TOLERANCE {
                return at_break(nodes, last, near.end);
            }
            stride = stride.min(0.9 * near.distance);
        }
        let Some(next) = step(family, &last, stride) else {
            stride *= 0.5;
            if stride < SHORTEST {
                return ended(nodes, last);
            }
            continue;
        };
        if outside(&next, limits) {
            return at_limit(family, nodes, &last, &next, limits, until);
        }
        if halves(&last, &next) {
            return (nodes, CurveEnd::Halved);
        }
        let found = locate::between(family, &last, &next);
        let stop = until == Until::Special && !found.is_empty();
        nodes.extend(found);
        if stop {
            nodes.truncate(1 + nodes.iter().position(|n| n.special.is_some()).unwrap_or(0));
            let kind = nodes.last().and_then(|n| n.special);
            return (nodes, kind.map_or(CurveEnd::Lost, CurveEnd::Special));
        }
        let closed = back_at(seed, &last, &next);
        nodes.push(next.clone());
        if closed {
            return (nodes, CurveEnd::Closed);
        }
        before = Some(std::mem::replace(&mut last, next));
        stride = (1.5 * stride).min(STRIDE);
    }
    (nodes, CurveEnd::Lost)
}

/// The next orbit, if it is one of the same curve: as many contacts, and no sharp turn.
fn step(family: &Family, last: &Node, stride: f64) -> Option<Node> {
    let guess = ahead(last.place, stride, last.tangent);
    let next = family.correct(guess, last.tangent)?;
    let moved = minus(next.place, last.place);
    let near = dot(moved, moved) < 2.0 * stride * stride;
    let straight = dot(next.tangent, last.tangent) > STRAIGHT;
    let same = next.orbit.impacts == last.orbit.impacts
        && contacts_alike(
            &onsets(&last.orbit),
            &onsets(&next.orbit),
            last.orbit.periods,
        );
    (near && straight && same).then_some(next)
}

/// Both ways along a curve from `seed`: its points in order and how it ends, at the first and at the last. `march` gives the
/// points from one on, without it, `turned` a point with its tangent reversed.
pub(super) fn both_ways<P: Clone + Send + Sync>(
    seed: P,
    turned: fn(P) -> P,
    march: impl Fn(&P) -> (Vec<P>, CurveEnd) + Sync,
) -> (Vec<P>, [CurveEnd; 2]) {
    let back = turned(seed.clone());
    let ((ahead, high), (behind, low)) = rayon::join(|| march(&seed), || march(&back));
    let (behind, low) = if high == CurveEnd::Closed {
        (Vec::new(), CurveEnd::Closed)
    } else {
        (behind, low)
    };
    let mut points: Vec<P> = behind.into_iter().rev().map(turned).collect();
    points.push(seed);
    points.extend(ahead);
    (points, [low, high])
}

/// When the contacts of an orbit begin, drive periods after drive phase 0.
pub(super) fn onsets(orbit: &Orbit) -> Vec<f64> {
    let contacts = orbit.seen.contacts.iter();
    contacts.map(|c| c.onset_s * orbit.frequency_hz).collect()
}

/// Whether each contact of one orbit begins at about the same phase as one of the other, by their [`onsets`] in so many drive
/// periods: if not, the step has passed over orbits with other contacts, though as many.
pub(super) fn contacts_alike(of_a: &[f64], of_b: &[f64], periods: u8) -> bool {
    /// A contact that begins this many drive periods away is another.
    const OTHER: f64 = 0.08;
    let round = f64::from(periods);
    let apart = |x: f64, y: f64| {
        let off = (x - y).rem_euclid(round);
        off.min(round - off)
    };
    let within = |all: &[f64], others: &[f64]| {
        (all.iter()).all(|x| others.iter().any(|y| apart(*x, *y) < OTHER))
    };
    within(of_a, of_b) && within(of_b, of_a)
}

/// How far an orbit is from one with another number of contacts: none where no such change is near. All three pass 0
/// linearly there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ContactMargins {
    /// Clearance of the nearest miss.
    pub near_miss: Option<f64>,
    /// Square of the slowest approach.
    pub approach: Option<f64>,
    /// Square of the shortest flight.
    pub flight: Option<f64>,
}

impl ContactMargins {
    /// Of a motion of `period_s`.
    pub fn new(seen: &OrbitWatch, period_s: f64) -> Self {
        let square = |x: Option<f64>| x.map(|x| x * x);
        let speeds = seen.grazing_contacts().map(|c| c.approach_speed_m_per_s);
        Self {
            near_miss: seen.near_miss_m,
            approach: square(speeds.reduce(f64::min)),
            // Only a flight that is shorter than the contacts at its ends is about to vanish.
            flight: square(seen.shortest_flight(period_s).filter(|share| *share < 1.0)),
        }
    }

    /// The margins of a periodic orbit.
    pub fn of(orbit: &Orbit) -> Self {
        Self::new(&orbit.seen, f64::from(orbit.periods) / orbit.frequency_hz)
    }
}

/// Where the last two orbits head for another number of contacts.
pub(super) struct Break {
    /// What ends the curve there.
    pub end: CurveEnd,
    /// How far along the curve.
    pub distance: f64,
}

impl Break {
    /// The nearest, of orbits that are `length` apart.
    pub fn ahead(length: f64, before: &ContactMargins, last: &ContactMargins) -> Option<Self> {
        let of = |end: CurveEnd, from: Option<f64>, to: Option<f64>| {
            let (from, to) = (from?, to?);
            let fall = from - to;
            let distance = length * to.max(0.0) / fall;
            (fall > 0.0).then_some(Self { end, distance })
        };
        let (gained, lost) = (Special::GrazingGained, Special::GrazingLost);
        let all = [
            of(CurveEnd::Special(gained), before.near_miss, last.near_miss),
            of(CurveEnd::Special(lost), before.approach, last.approach),
            of(CurveEnd::Merged, before.flight, last.flight),
        ];
        let all = all.into_iter().flatten();
        all.min_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    /// The nearest ahead of two orbits of a curve.
    fn of(before: &Node, last: &Node) -> Option<Self> {
        let moved = minus(last.place, before.place);
        let length = dot(moved, moved).sqrt();
        Self::ahead(
            length,
            &ContactMargins::of(&before.orbit),
            &ContactMargins::of(&last.orbit),
        )
    }
}

/// The curve ended at `last`, at a graze or where two contacts merge.
fn at_break(mut nodes: Vec<Node>, mut last: Node, end: CurveEnd) -> (Vec<Node>, CurveEnd) {
    if let CurveEnd::Special(kind) = end {
        last.special = Some(kind);
        match nodes.last_mut() {
            Some(node) => node.special = last.special,
            None => nodes.push(last),
        }
    }
    (nodes, end)
}

/// No further orbit was found: whether a contact grazes at the last.
fn ended(nodes: Vec<Node>, last: Node) -> (Vec<Node>, CurveEnd) {
    /// A hammer this close is about to touch, m.
    const CLOSE_M: f64 = 1e-8;
    /// A contact this slow is about to be missed, m/s.
    const SLOW_M_PER_S: f64 = 1e-5;
    /// A flight this short, over the shorter of the contacts before and after it, is about to vanish.
    const SHORT: f64 = 0.02;
    let orbit = &last.orbit;
    let end = if orbit.seen.near_miss_m.is_some_and(|m| m < CLOSE_M) {
        CurveEnd::Special(Special::GrazingGained)
    } else if (orbit.slowest_approach_m_per_s()).is_some_and(|v| v < SLOW_M_PER_S) {
        CurveEnd::Special(Special::GrazingLost)
    } else if orbit.shortest_flight().is_some_and(|share| share < SHORT) {
        CurveEnd::Merged
    } else {
        CurveEnd::Lost
    };
    at_break(nodes, last, end)
}

fn outside(node: &Node, (low, high): (f64, f64)) -> bool {
    !(low..=high).contains(&node.parameter())
}

/// The curve cut at the limit that lies between its last orbit and the next.
fn at_limit(
    family: &Family,
    mut nodes: Vec<Node>,
    last: &Node,
    next: &Node,
    (low, high): (f64, f64),
    until: Until,
) -> (Vec<Node>, CurveEnd) {
    let limit = if next.parameter() > high { high } else { low };
    let s = (limit - last.parameter()) / (next.parameter() - last.parameter());
    let mut guess = between(last.place, next.place, s);
    guess[2] = limit;
    if let Some(mut end) = family.correct(guess, UP) {
        if dot(end.tangent, last.tangent) < 0.0 {
            end = end.turned();
        }
        let found = locate::between(family, last, &end);
        let first = found.first().and_then(|n| n.special);
        nodes.extend(found);
        if let (Until::Special, Some(kind)) = (until, first) {
            return (nodes, CurveEnd::Special(kind));
        }
        nodes.push(end);
    }
    (nodes, CurveEnd::Limit)
}

/// Whether the doubled orbit has passed through one of half its period: its two halves change places.
fn halves(last: &Node, next: &Node) -> bool {
    let apart = |node: &Node| node.orbit.asymmetry(2, [1.0; 2]);
    let (a, b) = (apart(last), apart(next));
    // Coordinate and rate have different units; each must change sign on its own.
    a[0] * b[0] < 0.0 && a[1] * b[1] < 0.0
}

/// Whether the step from `last` to `next` has come back to `seed`.
fn back_at(seed: &Node, last: &Node, next: &Node) -> bool {
    let step = minus(next.place, last.place);
    let to_seed = minus(seed.place, last.place);
    let share = dot(to_seed, step) / dot(step, step);
    if !(0.0..=1.0).contains(&share) || last.place == seed.place {
        return false;
    }
    let off = minus(to_seed, step.map(|x| share * x));
    dot(off, off) < 0.01 * dot(step, step) && dot(seed.tangent, next.tangent) > STRAIGHT
}
