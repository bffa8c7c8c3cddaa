//! Gain of the hammer's sensor over the cart's, with its sign, from the flights.
//!
//! In flight ẍ = −ω² (x − y − Δ₀). With readings h x and g y, the latter later by δ, and the modulating function φ of
//! [the module](super),
//!
//! ```text
//! Y = −∫ φ̈ hx dt / ∫ φ dt = ω² H − ω² (h/g) (C + δ D) + constant,
//! H = ∫ φ hx dt / ∫ φ dt,   C = ∫ φ gy dt / ∫ φ dt,   D = −∫ φ̇ gy dt / ∫ φ dt
//! ```
//!
//! so a plane through the points (H, C + δ D, Y) gives h/g from its two slopes. The lag δ is learnt, slowly, from what
//! the plane leaves of Y that goes with D (taken for 0, 1 ms at 13 Hz counts as up to 6 % of gain). A third slope in its
//! place would scatter: in a 1/1, H and C explain nearly all of D. In a 1/1 that repeats
//! itself, windows that began at the same time after each contact would give one and the same point; so they begin a
//! different time after each ([`STAGGER`]). Neither the mass, nor the force, nor the believed frequency enters.

use crate::sense::Sample;

/// Parts of a window by which the beginnings differ.
const STAGGER: u32 = 8;
/// Windows in the plane: older ones fade.
const MEMORY: u32 = 48;
/// Windows in which the lag would be learnt if H and C explained nothing of D. They explain all but a hundredth of its
/// square, so it takes minutes; noise of 2 % of A0 moves the lag by a tenth of a millisecond.
const LAG_MEMORY: f32 = 32.0;
/// Covariance of Y and H by white noise of the hammer's sensor, over the variance of Y by it: ∫φ̇² dt / ∫φ̈² dt, time in windows.
const NOISE_OF_Y_IN_H: f32 = 1.0 / 42.0;
/// Largest lag that is learnt, either way, ticks (0.6 ms): a gain that has just changed is taken for one at first, by as much.
const LARGEST_LAG: f32 = 12.0;
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
    hammer: f32,
    hammer_rate: f32,
    cart: f32,
    cart_rate: f32,
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
            self.hammer = 0.0;
            self.hammer_rate = 0.0;
            self.cart = 0.0;
            self.cart_rate = 0.0;
        }
        let s = (self.ticks as f32 + 0.5) / window_ticks as f32;
        let past = s * (1.0 - s);
        let (level, rate) = (past * past, past * (2.0 - 4.0 * s));
        let hammer_m = sample.hammer_m - self.origin_m;
        self.curvature += (2.0 - 12.0 * past) * hammer_m;
        self.hammer += level * hammer_m;
        self.hammer_rate += rate * hammer_m;
        self.cart += level * sample.cart_m;
        self.cart_rate += rate * sample.cart_m;
        self.ticks += 1;
        if self.ticks >= window_ticks {
            self.ticks = 0;
            let scale = 30.0 / window_ticks as f32;
            let point = [
                scale * self.hammer + self.origin_m,
                scale * self.cart,
                // In units of the window's length, and of its square.
                -scale * self.cart_rate,
                -scale * (self.curvature - damping * (self.hammer_rate - self.cart_rate)),
            ];
            self.plane.push(point, LARGEST_LAG / window_ticks as f32);
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

    /// Forgets everything but the lag.
    pub fn reset(&mut self) {
        self.plane.reset();
        *self = Self {
            plane: self.plane,
            ..Self::default()
        };
    }
}

/// Means and covariances of the points, fading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Plane {
    /// How much later the cart's sensor is than the hammer's, in units of the window's length.
    lag: f32,
    /// Of the last point: its distance from the plane, and what H and C do not explain of D.
    last: [f32; 2],
    mean: [f32; 4],
    hh: f32,
    hc: f32,
    cc: f32,
    hy: f32,
    cy: f32,
    yy: f32,
    hd: f32,
    cd: f32,
    dd: f32,
    count: u32,
    outliers: u32,
}

impl Plane {
    /// Forgets all points; the lag is one of the sensors.
    fn reset(&mut self) {
        *self = Self {
            lag: self.lag,
            ..Self::default()
        };
    }

    /// A point H, C, D, Y; one that is further off the plane than its scatter allows, as a push makes it, is left out.
    fn push(&mut self, [h, c, d, y]: [f32; 4], largest_lag: f32) {
        let point = [h, c + self.lag * d, d, y];
        if !point.iter().all(|x| x.is_finite()) {
            return;
        }
        let mut off = [0.0; 4];
        for ((off, mean), value) in off.iter_mut().zip(self.mean).zip(point) {
            *off = value - mean;
        }
        let [h, c, d, y] = off;
        if let Some(fit) = self.fit() {
            let apart = y - fit.by_hammer * h - fit.by_cart * c;
            if apart * apart > GATE * (fit.left + GRAIN * self.yy) {
                self.outliers += 1;
                if self.outliers >= FEWEST {
                    // They are the rule by now: sensors or rig have changed.
                    self.reset();
                }
                return;
            }
            self.learn_lag(&fit, apart, [h, c, d], largest_lag);
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
            (&mut self.hd, h * d),
            (&mut self.cd, c * d),
            (&mut self.dd, d * d),
        ] {
            *sum = keep * (*sum + weight * product);
        }
    }

    /// Moves the lag by the share of `apart` that goes with the part of D that H and C do not explain, both less what
    /// they were at the last point: a zero that drifts, or a gain that has just changed, is no lag.
    fn learn_lag(&mut self, fit: &Fit, apart: f32, [h, c, d]: [f32; 3], largest: f32) {
        let (by_hammer, by_cart) = self.slopes(self.hd, self.cd, fit.determinant);
        let part = d - by_hammer * h - by_cart * c;
        let [apart_before, part_before] = core::mem::replace(&mut self.last, [apart, part]);
        // The hammer's noise is in Y and, through H, in what D leaves: by itself it would draw the lag away.
        let by_noise = -2.0 * NOISE_OF_Y_IN_H * fit.left * by_hammer;
        let product = (apart - apart_before) * (part - part_before) - by_noise;
        // Over D's whole square: where little of D is left, little is learnt.
        let lag = self.lag + product / (fit.by_cart * self.dd * LAG_MEMORY);
        if lag.is_finite() {
            self.lag = lag.min(largest).max(-largest);
        }
    }

    /// Slopes over H and C of what has these covariances with them.
    fn slopes(&self, with_h: f32, with_c: f32, determinant: f32) -> (f32, f32) {
        (
            (with_h * self.cc - with_c * self.hc) / determinant,
            (with_c * self.hh - with_h * self.hc) / determinant,
        )
    }

    /// The plane, if there are points enough.
    fn fit(&self) -> Option<Fit> {
        let determinant = self.hh * self.cc - self.hc * self.hc;
        if self.count < FEWEST || determinant <= 1e-4 * self.hh * self.cc {
            return None;
        }
        let (by_hammer, by_cart) = self.slopes(self.hy, self.cy, determinant);
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

    /// The ratio found after 20 s of a hammer that strikes at Δ = 0, with sensors of gains `gains` (hammer, cart) that are
    /// `late` by so many ticks.
    fn found(
        natural_hz: f64,
        drive: f64,
        damping_ratio: f64,
        gains: (f64, f64),
        late: (u32, u32),
        noise_m: f64,
    ) -> Option<f32> {
        const GRAIN_M: f64 = 6e-6;
        const TICK: f64 = 50e-6;
        let omega = core::f64::consts::TAU * natural_hz;
        let pace = drive * omega;
        let amplitude = 0.89e-3;
        let mut ratio = Ratio::default();
        let window = (1.0 / (6.0 * natural_hz * TICK)) as u32;
        let (mut delta, mut rate, mut since) = (-1e-3_f64, 0.0_f64, 0_u32);
        // The last 32 ticks of hammer and cart.
        let mut past = [(0.0, 0.0); 32];
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
            let read = |value: f64| (value / GRAIN_M).round() * GRAIN_M;
            past[k as usize % 32] = (cart + delta, cart);
            let ago = |ticks: u32| past[k.wrapping_sub(ticks) as usize % 32];
            let sample = Sample {
                force_n: 0.0,
                hammer_m: read(gains.0 * ago(late.0).0 + noise()) as f32,
                cart_m: read(gains.1 * ago(late.1).1 + noise()) as f32,
            };
            let damping = 2.0 * damping_ratio * omega * TICK * f64::from(window);
            ratio.flight(&sample, since < 40, (window, 40), damping as f32);
        }
        ratio.gain(amplitude as f32)
    }

    #[test]
    fn the_ratio_comes_out_with_damping_noise_and_codes_whichever_sensor_is_later() {
        let none = (0, 0);
        for (hz, drive) in [(1.82, 2.01), (6.5, 1.39), (6.5, 1.62), (8.4, 1.55)] {
            for (damping, noise) in [(0.0, 0.0), (0.004, 9e-6), (0.004, 18e-6)] {
                for (gains, late) in [
                    ((1.0, 1.0), none),
                    ((0.8, 1.0), none),
                    ((1.0, 0.8), none),
                    ((0.5, 1.0), none),
                    ((-1.0, 1.0), none),
                    // 1 ms.
                    ((1.0, 1.0), (20, 0)),
                    ((1.2, 1.0), (20, 0)),
                    ((0.8, 1.0), (0, 20)),
                ] {
                    let ratio = found(hz, drive, damping, gains, late, noise).unwrap();
                    let off = f64::from(ratio) * gains.1 / gains.0 - 1.0;
                    assert!(
                        off.abs() < 0.03,
                        "{hz} {drive} {damping} {noise} {gains:?} {late:?}: {ratio}"
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
