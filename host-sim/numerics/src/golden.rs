//! Golden-section search, shared by the grazing test and the choice of a frequency.

/// Narrows [a, b] to within `tolerance` about where `f` is largest, assumed to rise and then fall, and
/// returns the middle. Where `f` says nothing (equal values, as −∞ for "not allowed" at both inner points),
/// the side of `anchor` is kept.
pub fn maximum(
    mut f: impl FnMut(f64) -> f64,
    (mut a, mut b): (f64, f64),
    tolerance: f64,
    anchor: f64,
) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let (mut x, mut y) = (b - GOLDEN * (b - a), a + GOLDEN * (b - a));
    let (mut fx, mut fy) = (f(x), f(y));
    while b - a > tolerance {
        let left = if fx == fy { anchor < y } else { fx > fy };
        if left {
            (b, y, fy) = (y, x, fx);
            x = b - GOLDEN * (b - a);
            fx = f(x);
        } else {
            (a, x, fx) = (x, y, fy);
            y = a + GOLDEN * (b - a);
            fy = f(y);
        }
    }
    0.5 * (a + b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_top_of_a_parabola_and_the_edge_of_what_is_allowed() {
        let top = maximum(|x| -(x - 0.3).powi(2), (0.0, 1.0), 1e-7, 0.5);
        assert!((top - 0.3).abs() < 1e-6, "{top}");
        let allowed = |x: f64| if x < 0.2 { x } else { f64::NEG_INFINITY };
        let edge = maximum(allowed, (0.0, 1.0), 1e-9, 0.0);
        assert!((edge - 0.2).abs() < 1e-8, "{edge}");
    }
}
