//! Where in a step of flight the hammers meet the surface: the first root of the step's polynomial.

use super::flight::{FlightPath, ORDER};
use super::number::{Mask, Num};
use super::root::root;
use super::series::{horner, polynomial};
use super::width::LaneWidth;

/// Evenly spaced points per step at which x is computed.
pub const SAMPLES: usize = 6;

/// What a step met.
#[derive(Clone, Copy)]
pub struct Met<W: LaneWidth> {
    /// Lanes that met the surface.
    pub hit: Mask<W>,
    /// Fraction of the step at which they did; 1 elsewhere.
    pub at: Num<W>,
    /// Lanes in which it is uncertain whether they did.
    pub uncertain: Mask<W>,
}

/// Tolerances with which a meeting with the surface is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EventMargins {
    /// A top this close to the surface, in cart amplitudes, may or may not have touched it.
    pub grazing: f64,
    /// Newton's iteration has come to rest when it moves by less than this share of a step: what is left is its square.
    pub rest: f64,
}

/// The first meeting with the surface in the step. Lanes start below the surface, or on it on their way out (x = 0).
#[inline(always)]
pub fn meet<W: LaneWidth>(path: &FlightPath<W>, margins: EventMargins) -> Met<W> {
    let one = path[0].of(1.0);
    let zero = path[0].of(0.0);
    let never = one.lt(zero);
    let spacing = 1.0 / SAMPLES as f64;
    let seen = samples(path, spacing);
    let earlier = x_before(path, spacing);
    let mut hit = never;
    // Ends of the interval with the first rise above the surface.
    let mut from = zero;
    let mut to = one;
    let mut around = [seen[0], one, zero, zero];
    // The highest top hidden between samples, as a bound: the samples' parabola.
    let mut hidden = never;
    let mut before = seen[0] - path[1] * spacing;
    for i in 0..=SAMPLES {
        let x = seen[i];
        if i > 0 {
            let rises = zero.lt(x) & !hit;
            from = rises.choose(one * ((i - 1) as f64 * spacing), from);
            to = rises.choose(one * (i as f64 * spacing), to);
            let low = if i > 1 { seen[i - 2] } else { earlier };
            let all = [seen[i - 1], x, low, seen[i + 1]];
            around = each(|k| rises.choose(all[k], around[k]));
            hit = hit | rises;
        }
        let after = seen[i + 1];
        let bend = (x + x) - before - after;
        let top = before.lt(x) & after.lt(x);
        // Twice the parabola's rise above the middle sample, which is at most bend/8.
        let near = zero.lt(x + bend * 0.25 + margins.grazing * 4.0);
        hidden = hidden | (top & near & !hit);
        before = x;
    }
    let mut uncertain = never;
    let short = short_hop(path, spacing);
    let (longer, about) = longer_hop(path, &seen, spacing);
    if (short | longer).any() {
        let (top, height) = top_of_hop(path, short, about, spacing);
        // A top beside the first sample and not at an end of the search: it is one.
        let inside = (one * (0.5 * spacing)).lt(top) & top.lt(one * (2.0 * spacing));
        let hopped = short | (longer & inside);
        uncertain = hopped & height.abs().lt(one * margins.grazing);
        let rises = hopped & zero.lt(height);
        from = rises.choose(zero, from);
        to = rises.choose(top, to);
        let all = straight(zero, height);
        around = each(|k| rises.choose(all[k], around[k]));
        hit = hit | rises;
        hidden = hidden & !rises;
    }
    if hidden.any() {
        let found = highest(path, &seen, margins);
        let grazes = hidden & found.height.abs().lt(one * margins.grazing);
        uncertain = uncertain | grazes;
        let rises = hidden & zero.lt(found.height) & found.at.lt(to);
        from = rises.choose(found.from, from);
        to = rises.choose(found.at, to);
        let all = straight(polynomial(path, found.from), found.height);
        around = each(|k| rises.choose(all[k], around[k]));
        hit = hit | rises;
    }
    let mut at = one;
    if hit.any() {
        let (root, lost) = root(path, (from, to), &around, hit, margins);
        at = hit.choose(root, one);
        uncertain = uncertain | lost;
    }
    Met { hit, at, uncertain }
}

/// Lanes that left the surface and may have come back and left again before the first sample: where the path, its root
/// at the start divided out, rises first and falls later, and its parabola's top (and a fifth) is above the surface.
#[inline(always)]
fn short_hop<W: LaneWidth>(path: &FlightPath<W>, spacing: f64) -> Mask<W> {
    let zero = path[0].of(0.0);
    let outbound = !path[0].lt(zero);
    let rise = path[2];
    let curve = path[3] + path[4] * (1.5 * spacing);
    let falls = (rise + curve * (2.0 * spacing)).lt(zero);
    // X1 + 1.2 (−X2²/4 X3) > 0, X3 < 0.
    let high = (path[1] * curve * 4.0).lt(rise * rise * 1.2);
    outbound & zero.lt(rise) & falls & high & path[1].lt(zero)
}

/// Lanes that left the surface and may have come back between the first and the second sample, both of which are below
/// it, the second farther: with the root at the start divided out, the parabola through the start and the two samples
/// may reach the surface. Also where its top is.
#[inline(always)]
fn longer_hop<W: LaneWidth>(
    path: &FlightPath<W>,
    seen: &[Num<W>; SAMPLES + 2],
    spacing: f64,
) -> (Mask<W>, Num<W>) {
    let zero = path[0].of(0.0);
    let (first, second) = (seen[1], seen[2]);
    let outbound = !path[0].lt(zero) & path[1].lt(zero) & zero.lt(path[2]);
    let falls = first.lt(zero) & second.lt(first);
    // The quotients x/s at the start, the first and the second sample, times two intervals.
    let start = path[1] * (2.0 * spacing);
    let middle = first + first;
    let bend = middle + middle - start - second;
    let lean = second - start;
    // The parabola's top is lean²/8 bend above the middle; a fifth of it, and some of the bend, for what it misses.
    let reach = lean.mul_add(lean * 1.2, bend * bend * 0.1);
    let high = zero.lt(middle.mul_add(bend * 8.0, reach));
    let may = outbound & falls & high & zero.lt(bend);
    (may, (lean / (bend + bend) + zero.of(1.0)) * spacing)
}

/// Where in the first interval (`short`), or in the first two from `about` on, the path, its root at the start divided
/// out, is highest, and x there.
#[inline(always)]
fn top_of_hop<W: LaneWidth>(
    path: &FlightPath<W>,
    short: Mask<W>,
    about: Num<W>,
    spacing: f64,
) -> (Num<W>, Num<W>) {
    let zero = path[0].of(0.0);
    let end = short.choose(zero.of(spacing), zero.of(2.0 * spacing));
    let mut slopes = [zero; ORDER - 1];
    for (k, c) in slopes.iter_mut().enumerate() {
        *c = path[k + 2] * (k + 1) as f64;
    }
    let near = -(path[2] / (path[3] + path[3]));
    let mut s = short.choose(near, about).max(zero).min(end);
    for _ in 0..5 {
        let (slope, bend) = horner(&slopes, s);
        s = (s - slope / bend).max(zero).min(end);
    }
    (s, polynomial(path, s))
}

/// x at the ends of the intervals, and one interval after the step.
#[inline(always)]
fn samples<W: LaneWidth>(path: &FlightPath<W>, spacing: f64) -> [Num<W>; SAMPLES + 2] {
    let mut seen = [path[0]; SAMPLES + 2];
    for (i, x) in seen.iter_mut().enumerate().skip(1) {
        *x = polynomial(path, path[0].of(i as f64 * spacing));
    }
    seen
}

/// x one interval before the step, to fourth order.
#[inline(always)]
fn x_before<W: LaneWidth>(path: &FlightPath<W>, spacing: f64) -> Num<W> {
    polynomial(
        &[path[0], path[1], path[2], path[3], path[4]],
        path[0].of(-spacing),
    )
}

/// Four numbers, made one by one.
#[inline(always)]
fn each<W: LaneWidth>(number: impl Fn(usize) -> Num<W>) -> [Num<W>; 4] {
    [number(0), number(1), number(2), number(3)]
}

/// Four even points on a straight line by the middle two, in the order of [`root`].
#[inline(always)]
fn straight<W: LaneWidth>(at_from: Num<W>, at_to: Num<W>) -> [Num<W>; 4] {
    let rise = at_to - at_from;
    [at_from, at_to, at_from - rise, at_to + rise]
}

struct Top<W: LaneWidth> {
    height: Num<W>,
    at: Num<W>,
    from: Num<W>,
}

/// The first top that may reach the surface, between samples.
#[inline(always)]
fn highest<W: LaneWidth>(
    path: &FlightPath<W>,
    seen: &[Num<W>; SAMPLES + 2],
    margins: EventMargins,
) -> Top<W> {
    let one = path[0].of(1.0);
    let zero = path[0].of(0.0);
    let spacing = 1.0 / SAMPLES as f64;
    let mut found = one.lt(zero);
    let (mut s, mut lean, mut round) = (zero, zero, one);
    let mut before = seen[0] - path[1] * spacing;
    for i in 0..=SAMPLES {
        let x = seen[i];
        let after = seen[i + 1];
        let bend = (x + x) - before - after;
        let near = zero.lt(x + bend * 0.25 + margins.grazing * 4.0);
        let top = before.lt(x) & after.lt(x) & near & !found;
        s = top.choose(one * (i as f64), s);
        lean = top.choose(after - before, lean);
        round = top.choose(bend + bend, round);
        found = found | top;
        before = x;
    }
    s = ((s + lean / round) * spacing).max(zero).min(one);
    let middle = s;
    // Newton on the slope.
    let mut slopes = *path;
    for k in 0..ORDER {
        slopes[k] = path[k + 1] * (k + 1) as f64;
    }
    slopes[ORDER] = zero;
    for _ in 0..4 {
        let (slope, bend) = horner(&slopes, s);
        let step = slope / bend;
        let low = (middle - spacing).max(zero);
        let high = (middle + spacing).min(one);
        s = (s - step).max(low).min(high);
    }
    Top {
        height: polynomial(path, s),
        at: s,
        from: (s - 2.0 * spacing).max(zero),
    }
}
