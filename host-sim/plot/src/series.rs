//! Data made ready to draw: cut to the frame, interrupted at gaps, thinned.

use super::Point;
use super::ticks::is_drawable;

/// The visible rectangle in data units.
#[derive(Debug, Clone, Copy)]
pub(super) struct DataWindow {
    pub x: (f64, f64),
    pub y: (f64, f64),
}

impl DataWindow {
    pub fn contains(&self, (x, y): Point) -> bool {
        (self.x.0..=self.x.1).contains(&x) && (self.y.0..=self.y.1).contains(&y)
    }

    /// The part of the segment `a`-`b` inside the window.
    fn clip(&self, a: Point, b: Point) -> Option<(Point, Point)> {
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        for (from, step, lo, hi) in [(a.0, dx, self.x.0, self.x.1), (a.1, dy, self.y.0, self.y.1)] {
            if step == 0.0 {
                if from < lo || from > hi {
                    return None;
                }
                continue;
            }
            let (t0, t1) = ((lo - from) / step, (hi - from) / step);
            enter = enter.max(t0.min(t1));
            leave = leave.min(t0.max(t1));
        }
        let at = |t: f64| {
            if t == 0.0 {
                a
            } else if t == 1.0 {
                b
            } else {
                (a.0 + t * dx, a.1 + t * dy)
            }
        };
        (enter <= leave).then(|| (at(enter), at(leave)))
    }
}

/// Joined points as unbroken stretches inside the window. A stretch of one
/// point stands for a point with a gap on either side.
pub(super) fn stretches(points: &[Point], window: DataWindow) -> Vec<Vec<Point>> {
    let mut out: Vec<Vec<Point>> = Vec::new();
    for run in points.split(|(x, y)| !is_drawable(*x) || !is_drawable(*y)) {
        if let [only] = run {
            if window.contains(*only) {
                out.push(vec![*only]);
            }
            continue;
        }
        let mut current: Vec<Point> = Vec::new();
        for pair in run.windows(2) {
            let Some((from, to)) = window.clip(pair[0], pair[1]) else {
                continue;
            };
            if current.last() != Some(&from) {
                out.push(std::mem::take(&mut current));
                current.push(from);
            }
            current.push(to);
        }
        out.push(current);
    }
    out.retain(|stretch| !stretch.is_empty());
    out
}

/// Leaves out points that change nothing on the canvas: of a run within one
/// canvas column only the first, lowest, highest and last are kept.
pub(super) fn thin(points: Vec<(i32, i32)>) -> Vec<(i32, i32)> {
    let mut out = Vec::new();
    for column in points.chunk_by(|a, b| a.0 == b.0) {
        let last = column.len() - 1;
        let extreme = |sign: i32| {
            (0..=last)
                .max_by_key(|i| sign * column[*i].1)
                .unwrap_or(last)
        };
        let mut keep = [0, extreme(1), extreme(-1), last];
        keep.sort_unstable();
        out.extend(keep.map(|i| column[i]));
    }
    out.dedup();
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: DataWindow = DataWindow {
        x: (0.0, 1.0),
        y: (0.0, 1.0),
    };

    #[test]
    fn gaps_split_and_single_points_survive() {
        let nan = (f64::NAN, 0.0);
        let line = [
            (0.1, 0.1),
            (0.2, 0.2),
            nan,
            (0.5, 0.5),
            nan,
            nan,
            (0.8, 0.1),
            (0.9, 0.9),
        ];
        let sizes: Vec<_> = stretches(&line, UNIT).iter().map(Vec::len).collect();
        assert_eq!(sizes, [2, 1, 2]);
    }

    #[test]
    fn lines_are_cut_at_the_window_and_rejoin_as_new_stretches() {
        let line = [(0.0, 0.5), (0.5, 1.5), (1.0, 0.5), (2.0, 0.5)];
        let cut = stretches(&line, UNIT);
        assert_eq!(
            cut,
            [
                vec![(0.0, 0.5), (0.25, 1.0)],
                vec![(0.75, 1.0), (1.0, 0.5), (1.0, 0.5)]
            ]
        );
        assert!(stretches(&[(2.0, 2.0), (3.0, 5.0)], UNIT).is_empty());
        assert_eq!(
            stretches(&[(-1.0, 0.5), (2.0, 0.5)], UNIT),
            [[(0.0, 0.5), (1.0, 0.5)]]
        );
    }

    #[test]
    fn thinning_keeps_ends_and_extremes_of_a_column() {
        let mut dense: Vec<_> = (0..1000).map(|i| (7, i % 97)).collect();
        dense.push((8, 3));
        let thinned = thin(dense);
        assert!(thinned.len() <= 5, "{thinned:?}");
        for kept in [(7, 0), (7, 96), (8, 3)] {
            assert!(thinned.contains(&kept), "{thinned:?}");
        }
        assert_eq!(thinned[3..], [(7, 29), (8, 3)]);
        assert_eq!(thin(vec![(1, 1), (2, 2), (3, 1)]).len(), 3);
        assert!(thin(Vec::new()).is_empty());
    }
}
