//! Gain of the hammer's sensor over the cart's, with its sign, from the flights.
//!
//! In flight ẍ = −ω² (x − y − Δ₀). With readings h x and g y, and the modulating function φ of [the module](super),
//!
//! ```text
//! Y = −∫ φ̈ hx dt / ∫ φ dt = ω² H − ω² (h/g) C + constant,   H = ∫ φ hx dt / ∫ φ dt,  C = ∫ φ gy dt / ∫ φ dt
//! ```
//!
//! so a plane through the points (H, C, Y) gives h/g from its two slopes. In a 1/1 that repeats itself, windows that
//! began at the same time after each contact would give one and the same point; so they begin a different time after
//! each ([`STAGGER`]). Neither the mass, nor the force, nor the believed frequency enters.

use crate::sense::Sample;

/// Parts of a window by which the beginnings differ.
const STAGGER: u32 = 8;
/// Windows in the plane: older ones fade.
const MEMORY: u32 = 48;
/// Windows before the plane says anything.
const FEWEST: u32 = 32;
/// Least spread of the part of H, and of C, that the other does not explain, in units of A0. A hammer that swings
/// without touching at one frequency shows none.
const LEAST_SPREAD: f32 = 0.05;
/// Largest standard error of either slope, relative to that of H.
const LARGEST_ERROR: f32 = 0.05;
/// Share of the variance of Y that the plane may leave unexplained.
const SCATTER: f32 = 0.1;

/// The plane, and the window under way.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ratio {
    /// Ticks until the window begins, and since it began.
    wait: u32,
    ticks: u32,
    turn: u32,
    origin_m: f32,
    curvature: f32,
    hammer: f32,
    cart: f32,
    plane: Plane,
}

impl Ratio {
    /// One tick's samples; `in_contact`: a contact is under way. Windows of `window_ticks` begin `settle` ticks after it
    /// or later.
    #[inline]
    pub fn flight(&mut self, sample: &Sample, in_contact: bool, window_ticks: u32, settle: u32) {
        if in_contact {
            self.turn = if self.ticks == 0 && self.wait > 0 {
                self.turn
            } else {
                (self.turn + 1) % STAGGER
            };
            self.ticks = 0;
            self.wait = settle + window_ticks / STAGGER * self.turn;
            return;
        }
        if self.wait > 0 {
            self.wait -= 1;
            return;
        }
        if self.ticks == 0 {
            self.origin_m = sample.hammer_m;
            self.curvature = 0.0;
            self.hammer = 0.0;
            self.cart = 0.0;
        }
        let s = (self.ticks as f32 + 0.5) / window_ticks as f32;
        let past = s * (1.0 - s);
        let hammer_m = sample.hammer_m - self.origin_m;
        self.curvature += (2.0 - 12.0 * past) * hammer_m;
        self.hammer += past * past * hammer_m;
        self.cart += past * past * sample.cart_m;
        self.ticks += 1;
        if self.ticks >= window_ticks {
            self.ticks = 0;
            let scale = 30.0 / window_ticks as f32;
            let point = [
                scale * self.hammer + self.origin_m,
                scale * self.cart,
                // In units of the window's length squared.
                -scale * self.curvature,
            ];
            self.plane.push(point);
        }
    }

    /// Gain of the hammer's sensor over the cart's, if the flights of a rig with A0 = `amplitude_m` tell it.
    pub fn gain(&self, amplitude_m: f32) -> Option<f32> {
        let spread_m = LEAST_SPREAD * amplitude_m;
        self.plane.ratio(spread_m * spread_m)
    }

    /// Points in the plane so far.
    pub fn windows(&self) -> u32 {
        self.plane.count
    }

    /// Forgets everything.
    pub fn reset(&mut self) {
        *self = Self::default();
    }
}

/// Means and covariances of the points, fading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Plane {
    mean: [f32; 3],
    hh: f32,
    hc: f32,
    cc: f32,
    hy: f32,
    cy: f32,
    yy: f32,
    count: u32,
}

impl Plane {
    fn push(&mut self, point: [f32; 3]) {
        if !point.iter().all(|x| x.is_finite()) {
            return;
        }
        self.count = self.count.saturating_add(1);
        let weight = 1.0 / self.count.min(MEMORY) as f32;
        let keep = 1.0 - weight;
        let mut off = [0.0; 3];
        for ((off, mean), value) in off.iter_mut().zip(&mut self.mean).zip(point) {
            *off = value - *mean;
            *mean += weight * *off;
        }
        let [h, c, y] = off;
        for (sum, product) in [
            (&mut self.hh, h * h),
            (&mut self.hc, h * c),
            (&mut self.cc, c * c),
            (&mut self.hy, h * y),
            (&mut self.cy, c * y),
            (&mut self.yy, y * y),
        ] {
            *sum = keep * (*sum + weight * product);
        }
    }

    fn ratio(&self, least: f32) -> Option<f32> {
        let (hh, hc, cc) = (self.hh, self.hc, self.cc);
        let determinant = hh * cc - hc * hc;
        let known = determinant > least * hh && determinant > least * cc && least > 0.0;
        if self.count < FEWEST || !known {
            return None;
        }
        let by_hammer = (self.hy * cc - self.cy * hc) / determinant;
        let by_cart = (self.cy * hh - self.hy * hc) / determinant;
        let left = self.yy - by_hammer * self.hy - by_cart * self.cy;
        // The standard errors of both slopes, squared, against the first: with sensors alike they are of one size.
        let per_point = left / (determinant * (self.count.min(MEMORY) - 3) as f32);
        let largest = LARGEST_ERROR * LARGEST_ERROR * by_hammer * by_hammer;
        let sure = per_point * cc <= largest && per_point * hh <= largest;
        let plain = left <= SCATTER * self.yy && sure && by_hammer != 0.0;
        let ratio = -by_cart / by_hammer;
        (plain && ratio.is_finite()).then_some(ratio)
    }
}
