//! Flight of the hammers in all lanes: one Taylor step, and where in it the surface is met.

use super::number::{COS, Mask, Num, SIN, Width, horner, polynomial, series, sin_cos};

/// Order of the Taylor step.
pub const ORDER: usize = 12;

/// Coefficients of x over the fraction s of the step.
pub type Path<W> = [Num<W>; ORDER + 1];

/// Points per step at which x is looked at, evenly spaced.
pub const SAMPLES: usize = 8;

/// Most iterations of Newton's method for one event; a lane that has not come to rest by then is uncertain.
const ITERATIONS: usize = 24;

/// What flight needs of the cells, per lane.
#[derive(Clone, Copy)]
pub struct Field<W: Width> {
    /// [`super::constants::Constants::gap`].
    pub gap: Num<W>,
    /// [`super::constants::Constants::drive`].
    pub drive: Num<W>,
    /// [`super::constants::Constants::bend`].
    pub bend: Num<W>,
    /// [`super::constants::Constants::spring`].
    pub spring: Num<W>,
    /// [`super::constants::Constants::damping`].
    pub damping: Num<W>,
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
    let mut sum = a[0] * b[k];
    for j in 1..=k {
        sum = a[j].mul_add(b[k - j], sum);
    }
    sum
}

/// Taylor coefficients of the flight from `at` over a step `h`, for either equation of motion.
#[inline(always)]
pub fn path<W: Width>(beams: bool, f: &Field<W>, at: &At<W>, h: Num<W>) -> Path<W> {
    let (sin, cos) = sin_cos(at.tau);
    let h2 = h * h;
    let mut drive = [h.of(0.0); ORDER + 1];
    drive[0] = sin;
    drive[1] = h * cos;
    for k in 2..ORDER - 1 {
        drive[k] = -(drive[k - 2] * h2 * weight(k - 2));
    }
    if beams {
        on_beams(f, at, h, h2, &drive)
    } else {
        on_wires(f, at, h, h2, &drive)
    }
}

#[inline(always)]
#[expect(unused_assignments, reason = "the last order's")]
fn on_wires<W: Width>(f: &Field<W>, at: &At<W>, h: Num<W>, h2: Num<W>, drive: &Path<W>) -> Path<W> {
    let zero = h.of(0.0);
    let (mut x, mut rate) = ([zero; ORDER + 1], [zero; ORDER + 1]);
    let (mut sine, mut cosine) = ([zero; ORDER + 1], [zero; ORDER + 1]);
    x[0] = at.x;
    x[1] = h * at.v;
    rate[0] = x[1];
    // sin θ/σ and cos θ from the small angle σ x past the surface.
    let z = f.bend * at.x * at.x;
    let part = at.x * series(SIN, z);
    let whole = series(COS, z);
    sine[0] = f.gap.mul_add(whole, f.drive * part);
    cosine[0] = (f.bend * f.gap).mul_sub_from(part, f.drive * whole);
    macro_rules! next {
        ($($k:literal)*) => { $(
            let push = convolve(&cosine, drive, $k);
            let pull = f.spring.mul_sub_from(sine[$k], push);
            x[$k + 2] = h2 * weight($k) * pull;
            rate[$k + 1] = x[$k + 2] * ($k + 2) as f64;
            if $k + 3 <= ORDER {
                sine[$k + 1] = convolve(&cosine, &rate, $k) * (1.0 / ($k + 1) as f64);
                cosine[$k + 1] = -(f.bend * convolve(&sine, &rate, $k) * (1.0 / ($k + 1) as f64));
            }
        )* };
    }
    next!(0 1 2 3 4 5 6 7 8 9 10);
    x
}

#[inline(always)]
#[expect(unused_assignments, reason = "the last order's")]
fn on_beams<W: Width>(f: &Field<W>, at: &At<W>, h: Num<W>, h2: Num<W>, drive: &Path<W>) -> Path<W> {
    let zero = h.of(0.0);
    let (mut x, mut y, mut square) = ([zero; ORDER + 1], [zero; ORDER + 1], [zero; ORDER + 1]);
    x[0] = at.x;
    x[1] = h * at.v;
    y[0] = at.x + f.gap;
    y[1] = x[1];
    let lost = f.damping / h.max(h.of(1e-30));
    macro_rules! next {
        ($($k:literal)*) => { $(
            square[$k] = convolve(&y, &y, $k);
            let cube = convolve(&square, &y, $k);
            let spring = f.spring.mul_add(y[$k], f.bend * cube);
            let damper = lost * x[$k + 1] * ($k + 1) as f64;
            x[$k + 2] = h2 * weight($k) * (drive[$k] - spring - damper);
            y[$k + 2] = x[$k + 2];
        )* };
    }
    next!(0 1 2 3 4 5 6 7 8 9 10);
    x
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

/// How sharply events are told.
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
    // x at the ends of the intervals.
    let mut seen = [path[0]; SAMPLES + 1];
    for (i, x) in seen.iter_mut().enumerate().skip(1) {
        *x = polynomial(path, one * (i as f64 * spacing));
    }
    let mut hit = never;
    // Ends of the interval with the first rise above the surface.
    let mut from = zero;
    let mut to = one;
    // The highest top hidden between samples, as a bound: the samples' parabola.
    let mut hidden = never;
    let mut before = seen[0] - path[1] * spacing;
    for i in 0..=SAMPLES {
        let x = seen[i];
        if i > 0 {
            let rises = zero.lt(x) & !hit;
            from = rises.choose(one * ((i - 1) as f64 * spacing), from);
            to = rises.choose(one * (i as f64 * spacing), to);
            hit = hit | rises;
        }
        let after = if i < SAMPLES {
            seen[i + 1]
        } else {
            x + slope_at_end(path) * spacing
        };
        let bend = (x + x) - before - after;
        let top = before.lt(x) & after.lt(x);
        // Twice the parabola's rise above the middle sample, which is at most bend/8.
        let near = zero.lt(x + bend * 0.25 + margins.grazing * 4.0);
        hidden = hidden | (top & near & !hit);
        before = x;
    }
    let mut uncertain = never;
    if hidden.any() {
        let found = highest(path, &seen, margins);
        let grazes = hidden & found.height.abs().lt(one * margins.grazing);
        uncertain = uncertain | grazes;
        let rises = hidden & zero.lt(found.height) & found.at.lt(to);
        from = rises.choose(found.from, from);
        to = rises.choose(found.at, to);
        hit = hit | rises;
    }
    let mut at = one;
    if hit.any() {
        let (root, lost) = root(path, from, to, hit, margins);
        at = hit.choose(root, one);
        uncertain = uncertain | lost;
    }
    Met { hit, at, uncertain }
}

/// Σ k c_k.
#[inline(always)]
fn slope_at_end<W: Width>(path: &Path<W>) -> Num<W> {
    let mut sum = path[1];
    for (k, c) in path.iter().enumerate().skip(2) {
        sum = c.mul_add(c.of(k as f64), sum);
    }
    sum
}

struct Top<W: Width> {
    height: Num<W>,
    at: Num<W>,
    from: Num<W>,
}

/// The first top that may reach the surface, between samples.
#[inline(always)]
fn highest<W: Width>(path: &Path<W>, seen: &[Num<W>; SAMPLES + 1], margins: Margins) -> Top<W> {
    let one = path[0].of(1.0);
    let zero = path[0].of(0.0);
    let spacing = 1.0 / SAMPLES as f64;
    let mut found = one.lt(zero);
    let mut s = zero;
    let mut before = seen[0] - path[1] * spacing;
    for i in 0..=SAMPLES {
        let x = seen[i];
        let after = if i < SAMPLES {
            seen[i + 1]
        } else {
            x + slope_at_end(path) * spacing
        };
        let bend = (x + x) - before - after;
        let near = zero.lt(x + bend * 0.25 + margins.grazing * 4.0);
        let top = before.lt(x) & after.lt(x) & near & !found;
        let place = (one * (i as f64)) + (after - before) / (bend * 2.0);
        s = top.choose(place * spacing, s);
        found = found | top;
        before = x;
    }
    s = s.max(zero).min(one);
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

/// The root of the path between `from` (below) and `to` (above), by Newton's method kept within that interval. A lane
/// that starts on the surface (x = 0, outbound) has its root at the start divided out.
#[inline(always)]
fn root<W: Width>(
    path: &Path<W>,
    from: Num<W>,
    to: Num<W>,
    wanted: Mask<W>,
    margins: Margins,
) -> (Num<W>, Mask<W>) {
    let zero = path[0].of(0.0);
    let below = path[0].lt(zero);
    let mut p = *path;
    for k in 0..ORDER {
        p[k] = below.choose(path[k], path[k + 1]);
    }
    p[ORDER] = below.choose(path[ORDER], zero);
    let (mut low, mut high) = (from, to);
    let (at_low, at_high) = (polynomial(&p, low), polynomial(&p, high));
    let mut s = low + (high - low) * (at_low / (at_low - at_high));
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
