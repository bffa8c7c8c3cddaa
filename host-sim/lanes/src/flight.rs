//! Flight of the hammers in all lanes: one Taylor step, and where in it the surface is met.

use super::number::{Mask, Num, Width};
use super::series::{horner, polynomial, sin_cos};

/// Order of the Taylor step.
pub const ORDER: usize = 12;

/// Coefficients of x over the fraction s of the step.
pub type Path<W> = [Num<W>; ORDER + 1];

/// Evenly spaced points per step at which x is computed.
pub const SAMPLES: usize = 6;

/// Most iterations of Newton's method for one event; a lane that has not come to rest by then is uncertain.
const ITERATIONS: usize = 24;

/// What flight needs of the cells, per lane.
#[derive(Clone, Copy)]
pub struct Field<W: Width> {
    /// [`super::constants::Constants::rest`].
    pub rest: Num<W>,
    /// [`super::constants::Constants::bend`].
    pub bend: Num<W>,
    /// [`super::constants::Constants::spring`].
    pub spring: Num<W>,
    /// [`super::constants::Constants::damping`].
    pub damping: Num<W>,
    /// The reciprocal of the step (0 for a lane at rest).
    pub per_step: Num<W>,
}

/// Where the hammers are.
#[derive(Clone, Copy)]
pub struct At<W: Width> {
    /// Coordinate.
    pub x: Num<W>,
    /// Its rate.
    pub v: Num<W>,
    /// Drive phase since the last strobe, rad.
    pub tau: Num<W>,
}

/// (k+1)-th and following weights 1/((k+1)(k+2)).
const fn weight(k: usize) -> f64 {
    1.0 / ((k + 1) * (k + 2)) as f64
}

/// Σ a_j b_{k−j}.
#[inline(always)]
fn convolve<W: Width>(a: &Path<W>, b: &Path<W>, k: usize) -> Num<W> {
    // The middle first: the newest coefficients, at both ends, are the last to be ready.
    let middle = k.div_ceil(2);
    let mut sum = a[middle] * b[k - middle];
    for d in 1..=middle {
        if middle + d <= k {
            sum = a[middle + d].mul_add(b[k - middle - d], sum);
        }
        sum = a[middle - d].mul_add(b[k + d - middle], sum);
    }
    sum
}

/// Σ a_j a_{k−j}.
#[inline(always)]
fn itself<W: Width>(a: &Path<W>, k: usize) -> Num<W> {
    if k == 0 {
        return a[0] * a[0];
    }
    let half = k.div_ceil(2);
    let mut sum = a[half - 1] * a[k + 1 - half];
    for j in (0..half - 1).rev() {
        sum = a[j].mul_add(a[k - j], sum);
    }
    sum = sum + sum;
    if k.is_multiple_of(2) {
        sum = a[k / 2].mul_add(a[k / 2], sum);
    }
    sum
}

/// Taylor coefficients of the flight from `at` over a step `h`, for either equation of motion.
#[inline(always)]
pub fn path<W: Width>(beams: bool, f: &Field<W>, at: &At<W>, h: Num<W>) -> Path<W> {
    let (sin, cos) = sin_cos(at.tau);
    let h2 = h * h;
    let zero = h.of(0.0);
    let mut drive = [zero; ORDER + 1];
    drive[0] = sin;
    drive[1] = h * cos;
    for k in 2..ORDER - 1 {
        drive[k] = -(drive[k - 2] * h2 * weight(k - 2));
    }
    let mut x = [zero; ORDER + 1];
    x[0] = at.x;
    x[1] = h * at.v;
    if beams {
        on_beams(f, h2, &drive, &mut x);
    } else {
        on_wires(f, h2, &drive, &mut x);
    }
    x
}

/// sin θ and cos θ as polynomials of y = θ/σ to its fifth and fourth power: 2e-7 of a right angle off at 0.3 rad.
#[inline(always)]
#[allow(unused_assignments, reason = "the last order's are not needed")]
fn on_wires<W: Width>(f: &Field<W>, h2: Num<W>, drive: &Path<W>, x: &mut Path<W>) {
    let zero = h2.of(0.0);
    let one = h2.of(1.0);
    let mut y = *x;
    y[0] = x[0] + f.rest;
    let (mut square, mut fourth) = ([zero; ORDER + 1], [zero; ORDER + 1]);
    // sin θ/σ = y U, cos θ = W.
    let (mut u, mut w) = ([zero; ORDER + 1], [zero; ORDER + 1]);
    let bend2 = f.bend * f.bend;
    let (u1, u2) = (f.bend * (-1.0 / 6.0), bend2 * (1.0 / 120.0));
    let (w1, w2) = (f.bend * -0.5, bend2 * (1.0 / 24.0));
    macro_rules! next {
        ($($k:literal)*) => { $(
            square[$k] = itself(&y, $k);
            u[$k] = u1 * square[$k];
            w[$k] = w1 * square[$k];
            if $k < FOURTHS {
                fourth[$k] = itself(&square, $k);
                u[$k] = u2.mul_add(fourth[$k], u[$k]);
                w[$k] = w2.mul_add(fourth[$k], w[$k]);
            }
            if $k == 0 {
                u[0] = u[0] + one;
                w[0] = w[0] + one;
            }
            let push = convolve(&w, drive, $k);
            let pull = f.spring.mul_sub_from(convolve(&u, &y, $k), push);
            x[$k + 2] = h2 * weight($k) * pull;
            y[$k + 2] = x[$k + 2];
        )* };
    }
    next!(0 1 2 3 4 5 6 7 8 9 10);
}

/// Orders of θ⁴ that matter.
const FOURTHS: usize = 9;

#[inline(always)]
#[allow(unused_assignments, reason = "the last order's are not needed")]
fn on_beams<W: Width>(f: &Field<W>, h2: Num<W>, drive: &Path<W>, x: &mut Path<W>) {
    let mut y = *x;
    y[0] = x[0] + f.rest;
    let mut square = [h2.of(0.0); ORDER + 1];
    let lost = f.damping * f.per_step;
    macro_rules! next {
        ($($k:literal)*) => { $(
            square[$k] = itself(&y, $k);
            let cube = convolve(&square, &y, $k);
            let spring = f.spring.mul_add(y[$k], f.bend * cube);
            let damper = lost * x[$k + 1] * ($k + 1) as f64;
            x[$k + 2] = h2 * weight($k) * (drive[$k] - spring - damper);
            y[$k + 2] = x[$k + 2];
        )* };
    }
    next!(0 1 2 3 4 5 6 7 8 9 10);
}

/// What a step met.
#[derive(Clone, Copy)]
pub struct Met<W: Width> {
    /// Lanes that met the surface.
    pub hit: Mask<W>,
    /// Fraction of the step at which they did; 1 elsewhere.
    pub at: Num<W>,
    /// Lanes in which it is uncertain whether they did.
    pub uncertain: Mask<W>,
}

/// Event tolerances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// A top this close to the surface, in cart amplitudes, may or may not have touched it.
    pub grazing: f64,
    /// Newton's iteration has come to rest when it moves by less than this share of a step: what is left is its square.
    pub rest: f64,
}

/// The first meeting with the surface in the step. Lanes start below the surface, or on it on their way out (x = 0).
#[inline(always)]
pub fn meet<W: Width>(path: &Path<W>, margins: Margins) -> Met<W> {
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
fn short_hop<W: Width>(path: &Path<W>, spacing: f64) -> Mask<W> {
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
fn longer_hop<W: Width>(
    path: &Path<W>,
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
fn top_of_hop<W: Width>(
    path: &Path<W>,
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
fn samples<W: Width>(path: &Path<W>, spacing: f64) -> [Num<W>; SAMPLES + 2] {
    let mut seen = [path[0]; SAMPLES + 2];
    for (i, x) in seen.iter_mut().enumerate().skip(1) {
        *x = polynomial(path, path[0].of(i as f64 * spacing));
    }
    seen
}

/// x one interval before the step, to fourth order.
#[inline(always)]
fn x_before<W: Width>(path: &Path<W>, spacing: f64) -> Num<W> {
    polynomial(
        &[path[0], path[1], path[2], path[3], path[4]],
        path[0].of(-spacing),
    )
}

/// Four numbers, made one by one.
#[inline(always)]
fn each<W: Width>(number: impl Fn(usize) -> Num<W>) -> [Num<W>; 4] {
    [number(0), number(1), number(2), number(3)]
}

/// Four even points on a straight line by the middle two, in the order of [`root`].
#[inline(always)]
fn straight<W: Width>(at_from: Num<W>, at_to: Num<W>) -> [Num<W>; 4] {
    let rise = at_to - at_from;
    [at_from, at_to, at_from - rise, at_to + rise]
}

struct Top<W: Width> {
    height: Num<W>,
    at: Num<W>,
    from: Num<W>,
}

/// The first top that may reach the surface, between samples.
#[inline(always)]
fn highest<W: Width>(path: &Path<W>, seen: &[Num<W>; SAMPLES + 2], margins: Margins) -> Top<W> {
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

/// The root of the path between `from` (below) and `to` (above), by Newton's method kept within that interval. `around`
/// holds x at `from` and at `to`, and as far before and after them. A lane that starts on the surface (x = 0, outbound)
/// and comes back before the first sample has its root at the start divided out.
#[inline(always)]
fn root<W: Width>(
    path: &Path<W>,
    (from, to): (Num<W>, Num<W>),
    around: &[Num<W>; 4],
    wanted: Mask<W>,
    margins: Margins,
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
    // Steps on the path itself, with 1/slope refined from the last: one is nearly always enough in f32, two in f64.
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
fn bracketed<W: Width>(
    path: &Path<W>,
    (from, to): (Num<W>, Num<W>),
    (at_from, at_to): (Num<W>, Num<W>),
    wanted: Mask<W>,
    margins: Margins,
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
