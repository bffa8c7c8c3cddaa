//! Means and straight lines whose old points fade.

use super::FEWEST_WINDOWS as FEWEST;
use super::MEMORY;

/// F of 15 for two parameters and 24 points (22 degrees of freedom): noise alone passes it once in ten thousand times.
const DIFFERENT: f32 = 2.0 * 15.0 / FEWEST as f32;

/// Share of the variance of y that a line may leave unexplained.
pub const SCATTER: f32 = 0.08;

/// Square of a point's distance from the line, over what is usual, beyond which it is off.
const OFF: f32 = 25.0;

/// Difference of two slopes that does not matter: 1 % of natural frequency.
const SAME_SLOPE: f32 = 0.02;

/// Mean and variance that forget: of the last `M` values, older ones faded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Average<const M: u32 = MEMORY> {
    pub mean: f32,
    pub variance: f32,
    pub count: u32,
}

impl<const M: u32> Average<M> {
    pub fn push(&mut self, value: f32) {
        self.push_within(value, M);
    }

    /// Takes in a value as [`Self::push`] does, with a memory of `memory` values.
    pub fn push_within(&mut self, value: f32, memory: u32) {
        self.count = self.count.saturating_add(1);
        let weight = 1.0 / self.count.min(memory) as f32;
        let off = value - self.mean;
        self.mean += weight * off;
        self.variance = (1.0 - weight) * (self.variance + weight * off * off);
    }

    /// Standard error of the mean.
    pub fn sigma(&self) -> f32 {
        let count = self.count.clamp(2, M);
        libm::sqrtf(self.variance / (count - 1) as f32)
    }
}

/// A straight line through points, older ones fading; about the mean of the last `M`, so that a line whose level moves has its
/// slope all the same.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FadingLine<const M: u32 = MEMORY> {
    pub x: f32,
    pub y: f32,
    pub xx: f32,
    pub xy: f32,
    pub yy: f32,
    pub count: u32,
}

impl<const M: u32> FadingLine<M> {
    pub fn push(&mut self, x: f32, y: f32) {
        self.count = self.count.saturating_add(1);
        let weight = 1.0 / self.count.min(MEMORY) as f32;
        let nearer = 1.0 / self.count.min(M) as f32;
        let (dx, dy) = (x - self.x, y - self.y);
        self.x += nearer * dx;
        self.y += nearer * dy;
        let (keep, new) = (1.0 - weight, weight * (1.0 - nearer));
        self.xx = keep * self.xx + new * dx * dx;
        self.xy = keep * self.xy + new * dx * dy;
        self.yy = keep * self.yy + new * dy * dy;
    }

    /// Moves the level to this point; the slope stays.
    pub fn move_to(&mut self, x: f32, y: f32) {
        self.x = x;
        self.y = y;
    }

    /// Whether a point lies off the line by more than its scatter and `grain`, a mean square, explain.
    pub fn is_off(&self, x: f32, y: f32, grain: f32) -> bool {
        self.fit().is_some_and(|(slope, square)| {
            let off = y - self.y - slope * (x - self.x);
            // Written so that NaN is off.
            let near = off * off <= OFF * (square + grain);
            !near
        })
    }

    /// Slope and mean square residual of a line that the points do lie on.
    pub fn straight(&self) -> Option<(f32, f32)> {
        let (slope, square) = self.fit()?;
        // Contacts too weak to be detected, one per period, leave a scatter that no noise does.
        let straight = square < SCATTER * self.yy;
        (slope > 0.0 && straight).then_some((slope, square))
    }

    /// Whether `newest`, the last [`FEWEST`] points, lie on another line: F test of both its parameters, and a slope that
    /// is off by more than [`SAME_SLOPE`] or a level that is off by more than the root of `grain`.
    pub fn differs_from(&self, newest: &Self, grain: f32) -> bool {
        let (Some((slope, _)), Some((new_slope, square))) = (self.fit(), newest.fit()) else {
            return false;
        };
        let (off, turned) = (
            newest.y - self.y - slope * (newest.x - self.x),
            new_slope - slope,
        );
        // What their mean square residual about this line has more than that about their own.
        let more = turned * turned * newest.xx + off * off;
        let same = SAME_SLOPE * slope;
        more > DIFFERENT * square && (turned * turned > same * same || off * off > grain)
    }

    /// Slope and mean square residual.
    pub fn fit(&self) -> Option<(f32, f32)> {
        if self.count < FEWEST || self.xx <= 0.0 {
            return None;
        }
        let slope = self.xy / self.xx;
        let left = self.yy - slope * self.xy;
        let freedom = 1.0 - 2.0 / self.count.min(MEMORY) as f32;
        Some((slope, if left > 0.0 { left / freedom } else { 0.0 }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: f32, wanted: f32) {
        let off = (found - wanted).abs();
        assert!(off <= 1e-4 * wanted.abs() + 1e-6, "{found}, {wanted}");
    }

    #[test]
    fn a_mean_and_its_standard_error_are_those_of_the_textbook() {
        let mut average = Average::<MEMORY>::default();
        for value in [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0] {
            average.push(value);
        }
        assert_eq!(average.count, 8);
        close(average.mean, 5.0);
        close(average.variance, 4.0);
        // √(32/7) of scatter over √8.
        close(average.sigma(), libm::sqrtf(32.0 / 7.0 / 8.0));
        assert_eq!(Average::<MEMORY>::default().sigma(), 0.0);
    }

    /// Once the memory is full, each new value weighs 1/[`MEMORY`], and the old ones fade by as much.
    #[test]
    fn old_values_fade() {
        let mut average = Average::<MEMORY>::default();
        let mut line = FadingLine::<MEMORY>::default();
        for k in 0..MEMORY {
            average.push(3.0);
            line.push((k % 2) as f32, 3.0);
        }
        for k in 0..MEMORY {
            average.push(1.0);
            line.push((k % 2) as f32, 1.0);
        }
        let kept = libm::powf(1.0 - 1.0 / MEMORY as f32, MEMORY as f32);
        close(average.mean, 1.0 + 2.0 * kept);
        close(line.y, 1.0 + 2.0 * kept);
        // Two values, 2 apart, in these shares.
        let between = 4.0 * kept * (1.0 - kept);
        close(average.variance, between);
        close(line.yy, between);
        close(average.sigma(), libm::sqrtf(between / (MEMORY - 1) as f32));
    }

    #[test]
    fn the_line_is_that_of_least_squares() {
        let mut line = FadingLine::<MEMORY>::default();
        assert_eq!(line.fit(), None);
        // Off the line y = 5 − 2x by +1 and −1 in turn, at pairs of equal x.
        let off = |k: u32| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        for k in 0..FEWEST {
            assert_eq!(line.fit(), None, "{k} points");
            let x = (k / 2) as f32;
            line.push(x, 5.0 - 2.0 * x + off(k));
        }
        let (slope, square) = line.fit().unwrap();
        close(slope, -2.0);
        // Residuals of 1, and two degrees of freedom spent.
        let count = FEWEST as f32;
        close(square, count / (count - 2.0));
        close(line.x, 0.5 * (count / 2.0 - 1.0));
        close(line.y, 5.0 - 2.0 * line.x);
        // The variance of whole numbers below n is (n² − 1)/12.
        close(line.xx, (count * count / 4.0 - 1.0) / 12.0);
        close(line.xy, -2.0 * line.xx);
        close(line.yy, 4.0 * line.xx + 1.0);
    }

    #[test]
    fn points_above_each_other_and_points_on_a_line_leave_no_scatter() {
        let (mut upright, mut exact) = (
            FadingLine::<MEMORY>::default(),
            FadingLine::<MEMORY>::default(),
        );
        for k in 0..2 * FEWEST {
            upright.push(1.0, k as f32);
            exact.push(k as f32, 3.0 * k as f32);
        }
        assert_eq!(upright.fit(), None);
        let (slope, square) = exact.fit().unwrap();
        close(slope, 3.0);
        assert!((0.0..1e-2).contains(&square), "{square}");
    }
}
