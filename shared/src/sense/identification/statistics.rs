//! Means and straight lines whose old points fade.

use super::FEWEST_WINDOWS as FEWEST;
use super::MEMORY;

/// Mean and variance that forget: of the last `M` values, older ones faded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Average<const M: u32 = MEMORY> {
    pub mean: f32,
    pub variance: f32,
    pub count: u32,
}

impl<const M: u32> Average<M> {
    pub fn push(&mut self, value: f32) {
        self.count = self.count.saturating_add(1);
        let weight = 1.0 / self.count.min(M) as f32;
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

/// A straight line through points, older ones fading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Line {
    pub x: f32,
    pub y: f32,
    pub xx: f32,
    pub xy: f32,
    pub yy: f32,
    pub count: u32,
}

impl Line {
    pub fn push(&mut self, x: f32, y: f32) {
        self.count = self.count.saturating_add(1);
        let weight = 1.0 / self.count.min(MEMORY) as f32;
        let (dx, dy) = (x - self.x, y - self.y);
        self.x += weight * dx;
        self.y += weight * dy;
        let keep = 1.0 - weight;
        self.xx = keep * (self.xx + weight * dx * dx);
        self.xy = keep * (self.xy + weight * dx * dy);
        self.yy = keep * (self.yy + weight * dy * dy);
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
