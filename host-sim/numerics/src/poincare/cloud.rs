//! How far apart two clouds of points are.

use std::f64::consts::PI;

use serde::Serialize;

use crate::row::extent;

/// How far two clouds are apart, by two measures that agree on the same cloud: 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Apart {
    /// Sliced Wasserstein distance: how far points must be carried on average to turn one cloud into the other, along
    /// a direction, averaged over directions; in the clouds' unit.
    pub carried: f64,
    /// Share of the boxes occupied by either cloud that only one occupies, 0 to 1.
    pub boxes_not_shared: f64,
    /// Total variation of the shares of points per box, 0 to 1.
    pub variation: f64,
}

/// Directions the clouds are projected on.
const DIRECTIONS: usize = 32;
/// Boxes across each side of the rectangle around both clouds.
pub const BOXES: usize = 48;

/// How far `a` and `b` are apart, both in the same units. Both must have points.
pub fn apart(a: &[(f64, f64)], b: &[(f64, f64)]) -> Apart {
    let (boxes_not_shared, variation) = boxes(a, b);
    Apart {
        carried: carried(a, b),
        boxes_not_shared,
        variation,
    }
}

/// N. Bonneel et al., "Sliced and Radon Wasserstein barycenters of measures", J. Math. Imaging Vis. 51, 22–45 (2015),
/// doi:10.1007/s10851-014-0506-3, of order one, over evenly spread directions.
fn carried(a: &[(f64, f64)], b: &[(f64, f64)]) -> f64 {
    let along = |points: &[(f64, f64)], angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let mut x: Vec<f64> = points.iter().map(|p| p.0 * cos + p.1 * sin).collect();
        x.sort_by(f64::total_cmp);
        x
    };
    let each = (0..DIRECTIONS).map(|k| {
        let angle = PI * k as f64 / DIRECTIONS as f64;
        let (x, y) = (along(a, angle), along(b, angle));
        // Quantiles: clouds of different size are compared at the finer one's.
        let count = x.len().max(y.len());
        let at = |x: &[f64], i: usize| x[(i * x.len()) / count];
        (0..count)
            .map(|i| (at(&x, i) - at(&y, i)).abs())
            .sum::<f64>()
            / count as f64
    });
    each.sum::<f64>() / DIRECTIONS as f64
}

fn boxes(a: &[(f64, f64)], b: &[(f64, f64)]) -> (f64, f64) {
    let all = || a.iter().chain(b);
    let ends = |value: fn(&(f64, f64)) -> f64| {
        let [low, high] = extent(all().map(value));
        (low, (high - low).max(f64::MIN_POSITIVE))
    };
    let (x, y) = (ends(|p| p.0), ends(|p| p.1));
    let place = |value: f64, (low, span): (f64, f64)| {
        (((value - low) / span * BOXES as f64) as usize).min(BOXES - 1)
    };
    let shares = |points: &[(f64, f64)]| {
        let mut shares = vec![0.0; BOXES * BOXES];
        let each = 1.0 / points.len() as f64;
        for p in points {
            shares[place(p.1, y) * BOXES + place(p.0, x)] += each;
        }
        shares
    };
    let (a, b) = (shares(a), shares(b));
    let pairs = || a.iter().zip(&b);
    let either = pairs().filter(|(a, b)| **a > 0.0 || **b > 0.0).count();
    let both = pairs().filter(|(a, b)| **a > 0.0 && **b > 0.0).count();
    let variation = 0.5 * pairs().map(|(a, b)| (a - b).abs()).sum::<f64>();
    (1.0 - both as f64 / either as f64, variation)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of points, moved.
    fn square(by: (f64, f64)) -> Vec<(f64, f64)> {
        let grid = (0..100).flat_map(|i| (0..100).map(move |j| (i, j)));
        grid.map(|(i, j)| (f64::from(i) * 0.01 + by.0, f64::from(j) * 0.01 + by.1))
            .collect()
    }

    #[test]
    fn a_cloud_is_nowhere_from_itself() {
        let same = apart(&square((0.0, 0.0)), &square((0.0, 0.0)));
        assert!(same.carried < 1e-12 && same.boxes_not_shared == 0.0 && same.variation == 0.0);
    }

    /// A cloud moved by (d, 0) is d |cos φ| away along φ, 2d/π on average over φ; clouds apart share nothing.
    #[test]
    fn a_moved_cloud_is_as_far_as_it_was_moved() {
        let moved = apart(&square((0.0, 0.0)), &square((3.0, 0.0)));
        // The mean over 32 directions is the trapezoidal rule: 1e-3 of the integral.
        assert!(
            (moved.carried / (3.0 * 2.0 / PI) - 1.0).abs() < 2e-3,
            "{moved:?}"
        );
        assert_eq!(moved.boxes_not_shared, 1.0);
        assert!((moved.variation - 1.0).abs() < 1e-12);
    }

    /// Half of one cloud lies outside the other.
    #[test]
    fn half_an_overlap_is_half_a_variation() {
        let moved = apart(&square((0.0, 0.0)), &square((0.5, 0.0)));
        assert!((moved.variation - 0.5).abs() < 0.03, "{moved:?}");
        assert!(
            (moved.boxes_not_shared - 2.0 / 3.0).abs() < 0.04,
            "{moved:?}"
        );
    }

    #[test]
    fn size_does_not_count() {
        let every_other: Vec<_> = square((0.0, 0.0)).into_iter().step_by(2).collect();
        assert!(apart(&square((0.0, 0.0)), &every_other).carried < 0.01);
    }
}
