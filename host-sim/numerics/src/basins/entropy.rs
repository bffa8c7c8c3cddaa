//! How mixed the basins are: basin entropy, boundary basin entropy and the uncertainty exponent.
//!
//! A. Daza, A. Wagemakers, B. Georgeot, D. Guéry-Odelin, M. A. F. Sanjuán, *Basin entropy: a new tool to
//! analyze uncertainty in dynamical systems*, Scientific Reports 6, 31416 (2016), 10.1038/srep31416.
//! C. Grebogi, S. W. McDonald, E. Ott, J. A. Yorke, *Final state sensitivity: an obstruction to predictability*,
//! Physics Letters A 99, 415–418 (1983), 10.1016/0375-9601(83)90945-3.

use serde::Serialize;

/// Cells along a side of a box: 25 starts a box, as in the paper.
pub const BOX_SIDE: usize = 5;

/// A boundary basin entropy above ln 2 proves a fractal boundary (the paper's criterion): more than two basins would
/// have to meet in most boxes. Below it, nothing is proved.
pub const FRACTAL_ABOVE: f64 = std::f64::consts::LN_2;

/// Entropies of a picture of basins, in nats.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Entropy {
    /// S_b: Gibbs entropy of the basins within a box, averaged over all boxes.
    pub basin: f64,
    /// S_bb: the same, averaged over the boxes that hold more than one basin; none: there is no boundary.
    pub boundary: Option<f64>,
    /// All boxes, with or without a boundary in them.
    pub boxes: usize,
    /// Boxes with more than one basin.
    pub boundary_boxes: usize,
}

/// The entropies of a grid of `columns` wide rows, the number of its basin in each cell, over boxes of
/// [`BOX_SIDE`] cells a side that do not overlap. Columns and rows left over at the far edges are passed over.
/// None if not one box fits.
pub fn entropy(basin: &[u16], columns: usize) -> Option<Entropy> {
    let rows = basin.len().checked_div(columns)?;
    let (across, down) = (columns / BOX_SIDE, rows / BOX_SIDE);
    let boxes = across * down;
    if boxes == 0 {
        return None;
    }
    let (mut total, mut boundary_boxes) = (0.0, 0);
    for i in 0..boxes {
        let (left, top) = (BOX_SIDE * (i % across), BOX_SIDE * (i / across));
        let mut inside = [0_u16; BOX_SIDE * BOX_SIDE];
        for (k, cell) in inside.iter_mut().enumerate() {
            *cell = basin[(top + k / BOX_SIDE) * columns + left + k % BOX_SIDE];
        }
        let here = gibbs(&mut inside);
        boundary_boxes += usize::from(here > 0.0);
        total += here;
    }
    Some(Entropy {
        basin: total / boxes as f64,
        boundary: (boundary_boxes > 0).then(|| total / boundary_boxes as f64),
        boxes,
        boundary_boxes,
    })
}

/// −Σ p ln p over the shares of each number among `cells`.
fn gibbs(cells: &mut [u16]) -> f64 {
    cells.sort_unstable();
    let n = cells.len() as f64;
    let groups = cells.chunk_by(|a, b| a == b);
    let shares = groups.map(|group| group.len() as f64 / n);
    let terms = shares.filter(|p| *p < 1.0).map(|p| -p * p.ln());
    terms.sum()
}

/// How the share of uncertain starts falls with the distance one is uncertain by: f(ε) ∝ ε^α.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StartUncertainty {
    /// α, the uncertainty exponent: 1 for a smooth boundary, towards 0 the rougher it is.
    pub exponent: f64,
    /// Dimension of the boundary in the plane of starts, 2 − α.
    pub dimension: f64,
    /// Largest distance of the fitted line from a logarithm of f.
    pub misfit: f64,
    /// Distances used, from 1 cell to this many.
    pub farthest: usize,
}

/// Part of a row to which distances reach: farther apart, ends differ by chance, and f grows no more.
const FARTHEST_PART: usize = 32;

/// The uncertainty exponent of a grid, by counting over distances of 1, 2, 4, … cells along a row, up to a 32nd
/// of it, the pairs of starts that end in different basins; a line through the logarithms, least squares. None
/// if there is no boundary, or fewer than three distances.
///
/// Displacement and velocity have different units; along a row only displacement is uncertain. A boundary that runs along
/// the rows is not seen.
pub fn uncertainty(basin: &[u16], columns: usize) -> Option<StartUncertainty> {
    let shares: Vec<(f64, f64)> = (0..)
        .map(|k| 1_usize << k)
        .take_while(|distance| FARTHEST_PART * distance <= columns)
        .map(|distance| (distance as f64, differing(basin, columns, distance)))
        .collect();
    if shares.len() < 3 || shares.iter().any(|(_, share)| *share == 0.0) {
        return None;
    }
    let points: Vec<(f64, f64)> = shares.iter().map(|(d, f)| (d.ln(), f.ln())).collect();
    let n = points.len() as f64;
    let mean = |pick: fn(&(f64, f64)) -> f64| points.iter().map(pick).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let sxx: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    let sxy: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    let slope = sxy / sxx;
    let misfit = points.iter().map(|p| (p.1 - y - slope * (p.0 - x)).abs());
    Some(StartUncertainty {
        exponent: slope,
        dimension: 2.0 - slope,
        misfit: misfit.fold(0.0, f64::max),
        farthest: 1 << (points.len() - 1),
    })
}

/// Share of the pairs of cells `distance` apart in a row that lie in different basins.
fn differing(basin: &[u16], columns: usize, distance: usize) -> f64 {
    let (mut pairs, mut differ) = (0_u64, 0_u64);
    for row in basin.chunks_exact(columns) {
        for (a, b) in row.iter().zip(&row[distance..]) {
            pairs += 1;
            differ += u64::from(a != b);
        }
    }
    differ as f64 / pairs as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn grid(columns: usize, rows: usize, basin: impl FnMut((usize, usize)) -> u16) -> Vec<u16> {
        let cells = (0..rows).flat_map(|r| (0..columns).map(move |c| (c, r)));
        cells.map(basin).collect()
    }

    /// −p ln p − (1−p) ln(1−p).
    fn two(p: f64) -> f64 {
        -p * p.ln() - (1.0 - p) * (1.0 - p).ln()
    }

    #[test]
    fn one_basin_has_no_entropy_and_no_boundary() {
        let found = entropy(&grid(20, 20, |_| 3), 20).unwrap();
        assert_eq!((found.basin, found.boundary, found.boxes), (0.0, None, 16));
        assert_eq!(uncertainty(&grid(640, 8, |_| 3), 640), None);
        assert_eq!(entropy(&[1, 2, 3, 4], 2), None);
        assert_eq!(entropy(&[], 0), None);
    }

    /// Cut at column 52 of 100: every row of boxes has one that is split 2 to 3.
    #[test]
    fn a_straight_boundary_has_the_entropy_of_the_boxes_it_splits() {
        let picture = grid(100, 50, |(c, _)| u16::from(c >= 52));
        let found = entropy(&picture, 100).unwrap();
        assert_eq!((found.boxes, found.boundary_boxes), (200, 10));
        assert!((found.boundary.unwrap() - two(0.4)).abs() < 1e-12);
        assert!((found.basin - two(0.4) / 20.0).abs() < 1e-12);
        assert!(found.boundary.unwrap() < FRACTAL_ABOVE);
        // Each cell more of distance makes one pair more of each row differ, of one pair fewer.
        let smooth = uncertainty(&grid(4096, 1, |(c, _)| u16::from(c >= 2000)), 4096).unwrap();
        assert!((smooth.exponent - 1.0).abs() < 0.02, "{smooth:?}");
    }

    /// 13 and 12 of a box's 25 cells.
    #[test]
    fn a_checkerboard_has_the_entropy_of_thirteen_to_twelve() {
        let picture = grid(50, 35, |(c, r)| ((c + r) % 2) as u16);
        let found = entropy(&picture, 50).unwrap();
        assert_eq!(found.boundary_boxes, found.boxes);
        assert!((found.basin - two(13.0 / 25.0)).abs() < 1e-12);
        assert_eq!(Some(found.basin), found.boundary);
    }

    /// Noise of two colours: ln 2, less what 25 cells miss of it on the average (a sum over the binomial).
    #[test]
    fn random_noise_has_ln_2_less_what_small_boxes_miss() {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let picture = grid(1000, 1000, |_| random.random_range(0..2));
        let found = entropy(&picture, 1000).unwrap();
        let mut binomial = 0.5_f64.powi(25);
        let mut expected = 0.0;
        for k in 1..25_u32 {
            binomial *= f64::from(26 - k) / f64::from(k);
            expected += binomial * two(f64::from(k) / 25.0);
        }
        assert!((std::f64::consts::LN_2 - expected - 0.02).abs() < 2e-3);
        // 40,000 boxes whose entropy scatters by 0.03: five standard errors are 7e-4.
        assert!(
            (found.basin - expected).abs() < 7e-4,
            "{found:?} {expected}"
        );
        let rough = uncertainty(&picture, 1000).unwrap();
        assert!(rough.exponent.abs() < 0.01, "{rough:?}");
    }

    #[test]
    fn noise_of_four_colours_is_told_fractal() {
        let mut random = ChaCha8Rng::seed_from_u64(8);
        let picture = grid(200, 200, |_| random.random_range(0..4));
        assert!(entropy(&picture, 200).unwrap().boundary.unwrap() > FRACTAL_ABOVE);
    }

    /// Stripes that are the gaps of the middle-third Cantor set, each a basin: dimension ln 2/ln 3 across them, so
    /// α = 1 − ln 2/ln 3.
    #[test]
    fn a_cantor_boundary_has_the_cantor_set_s_dimension() {
        const DEPTH: u32 = 9;
        // The first ternary digits of a column, up to the 1 that says it lies in a gap.
        let basin = |column: usize| {
            let mut path = 1_u16;
            for k in (0..DEPTH).rev() {
                match column / 3_usize.pow(k) % 3 {
                    1 => break,
                    digit => path = 2 * path + (digit / 2) as u16,
                }
            }
            path
        };
        let columns = 3_usize.pow(DEPTH);
        let found = uncertainty(&grid(columns, 1, |(c, _)| basin(c)), columns).unwrap();
        let expected = 1.0 - 2.0_f64.ln() / 3.0_f64.ln();
        // Distances of 2^k against gaps of 3^k: the logarithm wavers about its line.
        assert!(
            (found.exponent - expected).abs() < 0.04,
            "{found:?} {expected}"
        );
    }
}
