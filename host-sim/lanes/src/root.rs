//! The root of a step's polynomial in an interval in which it is.

use super::flight::{FlightPath, ORDER};
use super::meet::EventMargins;
use super::number::{Mask, Num};
use super::series::horner;
use super::width::LaneWidth;

/// Most iterations of Newton's method for one event; a lane that has not come to rest by then is uncertain.
const ITERATIONS: usize = 24;

/// The root of the path between `from` (below) and `to` (above), by Newton's method kept within that interval. `around`
/// holds x at `from` and at `to`, and as far before and after them. A lane that starts on the surface (x = 0, outbound)
/// and comes back before the first sample has its root at the start divided out.
#[inline(always)]
pub fn root<W: LaneWidth>(
    path: &FlightPath<W>,
    (from, to): (Num<W>, Num<W>),
    around: &[Num<W>; 4],
    wanted: Mask<W>,
    margins: EventMargins,
) -> (Num<W>, Mask<W>) {
    let (one, zero) = (from.of(1.0), from.of(0.0));
    let [at_from, at_to, before, after] = *around;
    let width = to - from;
    // The parabola through the interval's ends and the point before them; its root and its slope there, both over
    // the interval's width.
    let curve = (at_to - at_from) - (at_from - before);
    let rise = at_to - at_from - curve * 0.5;
    let inside = rise.mul_add(rise, curve * at_from * -2.0);
    let below = path[0].lt(zero) | zero.lt(from);
    let sound = zero.lt(inside) & below;
    let steepness = sound.choose(inside, one).sqrt();
    let sum = rise + steepness;
    let quotient = one / (sum * steepness);
    let share = at_from * -2.0 * (quotient * steepness);
    let flat = quotient * sum;
    // The cubic through the point after them as well: one step of Newton's method from there.
    let third = (after - at_to - (at_to - at_from)) - curve;
    let square = share * share;
    let above = third * (1.0 / 6.0) * share * (square - one);
    let steeper = third * (1.0 / 6.0) * (square * 3.0 - one) * flat;
    let flat = flat * (one - steeper);
    let mut s = (share - above * flat).mul_add(width, from);
    let mut steep = flat * width;
    let mut open = wanted & sound;
    let mut astray = wanted & !sound;
    // Steps on the path itself, with 1/slope refined from the last: one is often enough, two nearly always.
    for _ in 0..3 {
        let (value, slope) = horner(path, s);
        let off = slope.mul_sub_from(steep, one);
        steep = steep * off.mul_add(off, one + off);
        let next = value.mul_sub_from(steep, s);
        let strays = !(off.abs().lt(zero.of(0.2))) | next.lt(from) | to.lt(next);
        astray = astray | (open & strays);
        let rests = (next - s).abs().lt(zero.of(margins.rest));
        s = open.choose(next, s);
        open = open & !rests & !strays;
        if !open.any() {
            break;
        }
    }
    let astray = astray | open;
    if astray.any() {
        let (careful, lost) = bracketed(path, (from, to), (at_from, at_to), astray, margins);
        (astray.choose(careful, s), lost)
    } else {
        (s, astray)
    }
}

/// [`root`] where its guess is not good: from the chord, by Newton's method kept within the interval. Also returns
/// the lanes in which it does not converge.
#[inline(always)]
fn bracketed<W: LaneWidth>(
    path: &FlightPath<W>,
    (from, to): (Num<W>, Num<W>),
    (at_from, at_to): (Num<W>, Num<W>),
    wanted: Mask<W>,
    margins: EventMargins,
) -> (Num<W>, Mask<W>) {
    let zero = from.of(0.0);
    let below = path[0].lt(zero) | zero.lt(from);
    let mut p = *path;
    for k in 0..ORDER {
        p[k] = below.choose(path[k], path[k + 1]);
    }
    p[ORDER] = below.choose(path[ORDER], zero);
    let at_low = below.choose(at_from, path[1]);
    let at_high = below.choose(at_to, at_to / to);
    let (mut low, mut high) = (from, to);
    let chord = (high - low) / (at_high - at_low);
    let mut s = at_low.mul_sub_from(chord, low).max(low).min(high);
    let mut open = wanted;
    for _ in 0..ITERATIONS {
        let (value, slope) = horner(&p, s);
        let under = value.lt(zero);
        low = (open & under).choose(s, low);
        high = (open & !under).choose(s, high);
        let newton = s - value / slope;
        let inside = low.lt(newton) & newton.lt(high);
        let next = inside.choose(newton, (low + high) * 0.5);
        let moved = (next - s).abs();
        s = open.choose(next, s);
        open = open & !(moved.lt(zero.of(margins.rest)));
        if !open.any() {
            break;
        }
    }
    (s, open)
}
