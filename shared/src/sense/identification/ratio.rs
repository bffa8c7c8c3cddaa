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

/// Square of the distance from the plane, over its mean, of a point that is left out.
const GATE: f32 = 25.0;
/// Share of the variance of Y that counts as scatter in any case.
const GRAIN: f32 = 0.002;

/// The plane, and the window under way.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ratio {
    /// Ticks until the window begins, and since it began.
    wait: u32,
    ticks: u32,
    turn: u32,
    origin_m: f32,
    curvature: f32,
    slope: f32,
    hammer: f32,
    cart: f32,
    plane: Plane,
}

impl Ratio {
    /// One tick's samples; `in_contact`: a contact is under way. Windows of `window_ticks` begin `settle` ticks after it
    /// or later; the motion loses `damping` times the window's length of its rate in a window.
    #[inline]
    pub fn flight(
        &mut self,
        sample: &Sample,
        in_contact: bool,
        (window_ticks, settle): (u32, u32),
        damping: f32,
    ) {
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
            self.slope = 0.0;
            self.hammer = 0.0;
            self.cart = 0.0;
        }
        let s = (self.ticks as f32 + 0.5) / window_ticks as f32;
        let past = s * (1.0 - s);
        let hammer_m = sample.hammer_m - self.origin_m;
        self.curvature += (2.0 - 12.0 * past) * hammer_m;
        self.slope += past * (2.0 - 4.0 * s) * (sample.hammer_m - sample.cart_m);
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
                -scale * (self.curvature - damping * self.slope),
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
    outliers: u32,
}

impl Plane {
    /// A point; one that is further off the plane than its scatter allows, as a push makes it, is left out.
    fn push(&mut self, point: [f32; 3]) {
        if !point.iter().all(|x| x.is_finite()) {
            return;
        }
        let mut off = [0.0; 3];
        for ((off, mean), value) in off.iter_mut().zip(self.mean).zip(point) {
            *off = value - mean;
        }
        let [h, c, y] = off;
        if let Some(fit) = self.fit() {
            let apart = y - fit.by_hammer * h - fit.by_cart * c;
            if apart * apart > GATE * (fit.left + GRAIN * self.yy) {
                self.outliers += 1;
                if self.outliers >= FEWEST {
                    // They are the rule by now: sensors or rig have changed.
                    *self = Self::default();
                }
                return;
            }
        }
        self.outliers = 0;
        self.count = self.count.saturating_add(1);
        let weight = 1.0 / self.count.min(MEMORY) as f32;
        let keep = 1.0 - weight;
        for (mean, off) in self.mean.iter_mut().zip(off) {
            *mean += weight * off;
        }
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

    /// The plane, if there are points enough.
    fn fit(&self) -> Option<Fit> {
        let determinant = self.hh * self.cc - self.hc * self.hc;
        if self.count < FEWEST || determinant <= 1e-4 * self.hh * self.cc {
            return None;
        }
        let by_hammer = (self.hy * self.cc - self.cy * self.hc) / determinant;
        let by_cart = (self.cy * self.hh - self.hy * self.hc) / determinant;
        let left = self.yy - by_hammer * self.hy - by_cart * self.cy;
        Some(Fit {
            determinant,
            by_hammer,
            by_cart,
            left: left.max(0.0),
        })
    }

    fn ratio(&self, least: f32) -> Option<f32> {
        let fit = self.fit()?;
        let (hh, cc) = (self.hh, self.cc);
        let known = fit.determinant > least * hh && fit.determinant > least * cc;
        // The standard errors of both slopes, squared, against the first: with sensors alike they are of one size.
        let per_point = fit.left / (fit.determinant * (self.count.min(MEMORY) - 3) as f32);
        let largest = LARGEST_ERROR * LARGEST_ERROR * fit.by_hammer * fit.by_hammer;
        let sure = per_point * cc <= largest && per_point * hh <= largest;
        let plain = fit.left <= SCATTER * self.yy && fit.by_hammer != 0.0;
        let ratio = -fit.by_cart / fit.by_hammer;
        (known && sure && plain && ratio.is_finite()).then_some(ratio)
    }
}

/// A plane through the points.
#[derive(Clone, Copy, Debug)]
struct Fit {
    determinant: f32,
    by_hammer: f32,
    by_cart: f32,
    /// Mean square distance of the points.
    left: f32,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The ratio found after `seconds` of a hammer that strikes at Δ = 0, with sensors of gains `gains` (hammer, cart).
    fn found(
        natural_hz: f64,
        drive: f64,
        damping_ratio: f64,
        gains: (f64, f64),
        grain_m: f64,
        noise_m: f64,
    ) -> Option<f32> {
        const TICK: f64 = 50e-6;
        let omega = core::f64::consts::TAU * natural_hz;
        let pace = drive * omega;
        let amplitude = 0.89e-3;
        let mut ratio = Ratio::default();
        let window = (1.0 / (6.0 * natural_hz * TICK)) as u32;
        let (mut delta, mut rate, mut since) = (-1e-3_f64, 0.0_f64, 0_u32);
        let mut seed = 1_u32;
        let mut noise = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (f64::from(seed >> 8) / 8_388_608.0 - 1.0) * noise_m * 3.0_f64.sqrt()
        };
        for k in 0..400_000_u32 {
            let t = f64::from(k) * TICK;
            let cart = amplitude * (pace * t).sin();
            let inertial = pace * pace * cart;
            let pull = -omega * omega * delta - 2.0 * damping_ratio * omega * rate;
            rate += TICK * (inertial + pull);
            delta += TICK * rate;
            since += 1;
            if delta > 0.0 && rate > 0.0 {
                rate *= -0.317;
                since = 0;
            }
            let read = |value: f64| (value / grain_m).round() * grain_m;
            let sample = Sample {
                force_n: 0.0,
                hammer_m: read(gains.0 * (cart + delta) + noise()) as f32,
                cart_m: read(gains.1 * cart + noise()) as f32,
            };
            let damping = 2.0 * damping_ratio * omega * TICK * f64::from(window);
            ratio.flight(&sample, since < 40, (window, 40), damping as f32);
        }
        ratio.gain(amplitude as f32)
    }

    #[test]
    fn the_ratio_comes_out_with_damping_noise_and_codes() {
        for (hz, drive) in [(1.82, 2.01), (6.5, 1.39), (6.5, 1.62), (8.4, 1.55)] {
            for (damping, noise) in [(0.0, 0.0), (0.004, 9e-6), (0.004, 18e-6)] {
                for gains in [(1.0, 1.0), (0.8, 1.0), (1.0, 0.8), (0.5, 1.0), (-1.0, 1.0)] {
                    let ratio = found(hz, drive, damping, gains, 6e-6, noise).unwrap();
                    let off = f64::from(ratio) * gains.1 / gains.0 - 1.0;
                    assert!(
                        off.abs() < 0.03,
                        "{hz} {drive} {damping} {noise} {gains:?}: {ratio}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_hammer_that_never_touches_tells_nothing() {
        let mut ratio = Ratio::default();
        for k in 0..400_000_u32 {
            let sin = libm::sinf(core::f32::consts::TAU * 6.5e-5 * 2.1 * k as f32);
            let sample = Sample {
                force_n: 0.0,
                hammer_m: -0.3e-3 * sin,
                cart_m: 0.89e-3 * sin,
            };
            ratio.flight(&sample, false, (512, 40), 0.0);
        }
        assert_eq!(ratio.gain(0.89e-3), None);
    }
}
