//! Roots and largest values of a function of one number.

use std::iter;

/// Halves the interval `rounds` times about where `beyond` becomes true, which it is at the second end and not at the
/// first; the first may be the larger. Gives the ends that are left, in the order given.
pub fn halved(
    (mut before, mut after): (f64, f64),
    rounds: u32,
    mut beyond: impl FnMut(f64) -> bool,
) -> (f64, f64) {
    for _ in 0..rounds {
        let middle = 0.5 * (before + after);
        if beyond(middle) {
            after = middle;
        } else {
            before = middle;
        }
    }
    (before, after)
}

/// [`halved`] until the interval is no longer than `width`.
pub fn narrowed(ends: (f64, f64), width: f64, beyond: impl FnMut(f64) -> bool) -> (f64, f64) {
    let halvings = ((ends.1 - ends.0).abs() / width).log2().ceil().max(0.0);
    halved(ends, halvings as u32, beyond)
}

/// What lies where the value between both ends passes 0, by false position (the Illinois variant: M. Dowell and
/// P. Jarratt, BIT 11 (1971) 168–174). `values` are those at the ends, `at` gives what lies at a share of the way and
/// its value, `near` says of the last two, and of the share of the way that is left, whether they are near enough. None
/// if the value does not change its sign, or cannot be had.
pub fn false_position<T>(
    values: [f64; 2],
    mut at: impl FnMut(f64) -> Option<(T, f64)>,
    near: impl Fn(Option<&T>, &T, f64) -> bool,
) -> Option<T> {
    let (mut low, mut high) = ((0.0, values[0]), (1.0, values[1]));
    if low.1.signum() == high.1.signum() {
        return None;
    }
    let (mut best, mut side): (Option<T>, i32) = (None, 0);
    for _ in 0..60 {
        let secant = low.0 - low.1 * (high.0 - low.0) / (high.1 - low.1);
        let s = if secant > low.0 && secant < high.0 {
            secant
        } else {
            0.5 * (low.0 + high.0)
        };
        let (found, value) = at(s)?;
        let enough = value == 0.0 || near(best.as_ref(), &found, high.0 - low.0);
        best = Some(found);
        if enough {
            break;
        }
        let (end, other, own) = if value.signum() == low.1.signum() {
            (&mut low, &mut high, -1)
        } else {
            (&mut high, &mut low, 1)
        };
        *end = (s, value);
        if side == own {
            other.1 *= 0.5;
        }
        side = own;
    }
    best
}

/// Where `f` is largest in [a, b], to within `tolerance`, by Brent's method (R. P. Brent, *Algorithms for Minimization
/// Without Derivatives*, 1973, chapter 5): parabolas where they help, golden sections else. `f` is assumed to rise and then
/// fall, and −∞ where a value is not allowed; `anchor` is the best place known.
pub fn maximum(
    mut f: impl FnMut(f64) -> f64,
    (mut a, mut b): (f64, f64),
    tolerance: f64,
    anchor: f64,
) -> f64 {
    const SECTION: f64 = 0.381_966_011_250_105_1;
    let least = 0.5 * tolerance;
    if b - a <= tolerance {
        return 0.5 * (a + b);
    }
    // The best place, the second best, and the one that was it before.
    let mut x = anchor.clamp(a + least, b - least);
    let mut fx = f(x);
    let (mut w, mut fw, mut v, mut fv) = (x, fx, x, fx);
    let (mut step, mut before) = (0.0_f64, 0.0_f64);
    loop {
        let middle = 0.5 * (a + b);
        if (x - middle).abs() <= tolerance - 0.5 * (b - a) {
            return x;
        }
        let (r, q) = ((x - w) * (fv - fx), (x - v) * (fw - fx));
        let (p, q) = ((x - v) * q - (x - w) * r, 2.0 * (q - r));
        let parabola = -p / q;
        let inside = (a + least..=b - least).contains(&(x + parabola));
        // Comparisons with what is no number are false.
        if before.abs() > least && inside && parabola.abs() < 0.5 * before.abs() {
            (step, before) = (parabola, step);
        } else {
            before = if x >= middle { a - x } else { b - x };
            step = SECTION * before;
        }
        let u = x + if step.abs() >= least {
            step
        } else {
            least.copysign(step)
        };
        let fu = f(u);
        if fu >= fx && fu > f64::NEG_INFINITY {
            if u >= x {
                a = x;
            } else {
                b = x;
            }
            (v, fv, w, fw, x, fx) = (w, fw, x, fx, u, fu);
        } else {
            if u < x {
                a = u;
            } else {
                b = u;
            }
            if fu >= fw || w == x {
                (v, fv, w, fw) = (w, fw, u, fu);
            } else if fu >= fv || v == x || v == w {
                (v, fv) = (u, fu);
            }
        }
    }
}

/// Where the parabola through three points (x, y) turns. No number if they lie on a line.
pub fn vertex([(a, fa), (b, fb), (c, fc)]: [(f64, f64); 3]) -> f64 {
    let (left, right) = ((b - a) * (fb - fc), (b - c) * (fb - fa));
    b - 0.5 * ((b - a) * left - (b - c) * right) / (left - right)
}

/// Where in `within` the `value` is largest, and what comes with it; `value` is `None` where a place is not allowed. The
/// rising `nodes` bracket the maximum, [`maximum`] finds it to within `tolerance`; a maximum against the edge of what is
/// allowed is found as that edge.
pub fn largest<T>(
    nodes: impl Iterator<Item = f64>,
    (low, high): (f64, f64),
    tolerance: f64,
    value: impl Fn(f64) -> Option<(f64, T)>,
) -> Option<(f64, T)> {
    let inside = nodes.filter(|x| *x > low && *x < high);
    let nodes: Vec<f64> = iter::once(low).chain(inside).chain([high]).collect();
    let mut best: Option<(usize, f64, T)> = None;
    for (i, x) in nodes.iter().enumerate() {
        if let Some((y, what)) = value(*x)
            && best.as_ref().is_none_or(|b| y > b.1)
        {
            best = Some((i, y, what));
        }
    }
    let (i, mut top, what) = best?;
    let anchor = nodes[i];
    let mut found = (anchor, what);
    let around = (
        nodes[i.saturating_sub(1)],
        nodes[(i + 1).min(nodes.len() - 1)],
    );
    let value_at = |x: f64| {
        let Some((y, what)) = value(x) else {
            return f64::NEG_INFINITY;
        };
        if y > top {
            top = y;
            found = (x, what);
        }
        y
    };
    maximum(value_at, around, tolerance, anchor);
    Some(found)
}

/// The interval about `from`, inside `within`, on which `holds` is true, assumed connected: the rising `nodes` bracket its
/// ends, which are halved to `width`.
pub fn stretch(
    nodes: impl Iterator<Item = f64>,
    from: f64,
    within: (f64, f64),
    width: f64,
    holds: impl Fn(f64) -> bool,
) -> (f64, f64) {
    let walk = |nodes: &mut dyn Iterator<Item = f64>| {
        let mut last = from;
        for x in nodes {
            if !holds(x) {
                return narrowed((last, x), width, |x| !holds(x)).0;
            }
            last = x;
        }
        last
    };
    let inside = nodes.filter(|x| *x > within.0 && *x < within.1 && *x != from);
    let (down, up): (Vec<f64>, Vec<f64>) = inside.partition(|x| *x < from);
    let low = walk(&mut down.into_iter().rev().chain([within.0]));
    (low, walk(&mut up.into_iter().chain([within.1])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_about_a_change_keep_their_order() {
        let beyond = |x: f64| x > 0.7;
        let (before, after) = halved((0.0, 1.0), 20, beyond);
        assert!(before <= 0.7 && after > 0.7 && after - before < 1e-6);
        let (before, after) = narrowed((1.0, 0.0), 1e-6, |x| !beyond(x));
        assert!(after <= 0.7 && before > 0.7 && before - after <= 1e-6);
        assert_eq!(narrowed((0.0, 1.0), 2.0, beyond), (0.0, 1.0));
    }

    /// cos x = x at 0.739085133215160641655.
    #[test]
    fn false_position_meets_a_known_root_and_refuses_no_change_of_sign() {
        let value = |x: f64| x.cos() - x;
        let root = |to: f64| {
            let at = |s| Some((s * to, value(s * to)));
            let near = |last: Option<&f64>, x: &f64, _| last.is_some_and(|l| (l - x).abs() < 1e-12);
            false_position([value(0.0), value(to)], at, near)
        };
        assert!((root(2.0).unwrap() - 0.739_085_133_215_160_6).abs() < 1e-12);
        assert_eq!(root(0.5), None);
    }

    #[test]
    fn the_top_of_a_parabola_and_the_edge_of_what_is_allowed() {
        let top = maximum(|x| -(x - 0.3).powi(2), (0.0, 1.0), 1e-7, 0.5);
        assert!((top - 0.3).abs() < 1e-6, "{top}");
        let points = [0.1, 0.25, 0.9].map(|x: f64| (x, -(x - 0.3).powi(2)));
        assert!((vertex(points) - 0.3).abs() < 1e-12);
        let allowed = |x: f64| if x < 0.2 { x } else { f64::NEG_INFINITY };
        let edge = maximum(allowed, (0.0, 1.0), 1e-9, 0.0);
        assert!((edge - 0.2).abs() < 1e-8, "{edge}");
    }
}
