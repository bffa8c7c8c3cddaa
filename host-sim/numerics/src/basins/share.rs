//! Shares of starts, and how sure they are: Wilson's interval for a random sample, the spread of
//! interleaved coarser grids for a grid.

use serde::Serialize;

use crate::row::extent;

/// Standard normal quantile of a two-sided 95 % interval.
const NORMAL_95: f64 = 1.959_963_984_540_054;

/// A share of a random sample, with its 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SampledShare {
    /// How many members of the sample were counted.
    pub count: u64,
    /// Size of the whole sample.
    pub of: u64,
    /// Lower end of the interval, 0 to 1.
    pub low: f64,
    /// Upper end, 0 to 1.
    pub high: f64,
}

impl SampledShare {
    /// `count` of `of`, with Wilson's score interval (E. B. Wilson, J. Am. Stat. Assoc. 22, 209–212, 1927,
    /// 10.1080/01621459.1927.10502953): it stays within 0 and 1, and does not collapse when none or all are
    /// counted. An empty sample says nothing: 0 to 1.
    pub fn wilson(count: u64, of: u64) -> Self {
        let (low, high) = if of == 0 {
            (0.0, 1.0)
        } else {
            let (n, z2) = (of as f64, NORMAL_95 * NORMAL_95);
            let p = count as f64 / n;
            let middle = p + z2 / (2.0 * n);
            let half = NORMAL_95 * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
            let low = (middle - half) / (1.0 + z2 / n);
            let high = (middle + half) / (1.0 + z2 / n);
            // None and all: the ends are 0 and 1, and rounding shall not hide it.
            (
                if count == 0 { 0.0 } else { low.max(0.0) },
                if count == of { 1.0 } else { high.min(1.0) },
            )
        };
        Self {
            count,
            of,
            low,
            high,
        }
    }

    /// The share itself, 0 to 1; not a number for an empty sample.
    pub fn value(&self) -> f64 {
        self.count as f64 / self.of as f64
    }
}

/// The share of a grid's cells for which `is` holds, 0 to 1, and the mesh's own error: half the range of the
/// shares of the four interleaved grids of every second column and row. Those are coarser than the grid
/// itself, so that this errs on the large side. A grid too small to be split (fewer than 2 × 2 cells) has no such error.
pub fn on_grid(
    columns: usize,
    rows: usize,
    is: impl Fn(usize, usize) -> bool,
) -> (f64, Option<f64>) {
    let count = |column: usize, row: usize, step: usize| {
        let mut of = 0_u64;
        let mut counted = 0_u64;
        for r in (row..rows).step_by(step) {
            for c in (column..columns).step_by(step) {
                of += 1;
                counted += u64::from(is(c, r));
            }
        }
        counted as f64 / of as f64
    };
    let share = count(0, 0, 1);
    if columns < 2 || rows < 2 {
        return (share, None);
    }
    let quarters = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(c, r)| count(c, r, 2));
    let [low, high] = extent(quarters.into_iter());
    (share, Some(0.5 * (high - low)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// R. G. Newcombe, Statistics in Medicine 17, 857–872 (1998), table I, method 3.
    #[test]
    fn wilson_s_interval_is_newcombe_s() {
        for (count, of, low, high) in [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0000, 0.1611),
            (1, 29, 0.0061, 0.1718),
        ] {
            let share = SampledShare::wilson(count, of);
            // Printed to four digits.
            assert!((share.low - low).abs() < 5.1e-5, "{share:?}");
            assert!((share.high - high).abs() < 5.1e-5, "{share:?}");
        }
    }

    #[test]
    fn none_all_and_nothing_have_sensible_ends() {
        assert_eq!(SampledShare::wilson(0, 50).low, 0.0);
        let all = SampledShare::wilson(50, 50);
        assert_eq!(all.high, 1.0);
        assert!((all.low - (1.0 - SampledShare::wilson(0, 50).high)).abs() < 1e-12);
        let nothing = SampledShare::wilson(0, 0);
        assert_eq!((nothing.low, nothing.high), (0.0, 1.0));
    }

    /// A half plane cut at an odd column: the quarter grids see 20 and 19 of their 50 columns (39 cut).
    #[test]
    fn the_mesh_s_error_of_a_straight_edge_is_half_a_column_of_the_coarse_grid() {
        let (share, error) = on_grid(100, 100, |column, _| column < 39);
        assert!((share - 0.39).abs() < 1e-12);
        assert!((error.unwrap() - 0.01).abs() < 1e-12, "{error:?}");
        let (share, error) = on_grid(100, 100, |column, _| column < 40);
        assert!((share - 0.4).abs() < 1e-12 && error.unwrap() < 1e-12);
        assert_eq!(on_grid(1, 5, |_, _| true), (1.0, None));
    }
}
