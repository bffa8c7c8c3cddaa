//! The hammer between contacts: a Kalman observer of its displacement and rate relative to the cart.
//!
//! The model is linear (small angles for wires), with the believed natural frequency and damping:
//!
//! ```text
//! Δ̈ = −ω² Δ − 2ζω Δ̇ + Ω² (a sin φ + b cos φ) + d
//! ```
//!
//! a and b are the measured parts of the cart's motion ([`super::harmonic`]), φ the commanded phase. The
//! third state d, a disturbance acceleration that wanders slowly, absorbs the errors of the model: a
//! natural frequency 10 % off, offsets, a cart whose speed a contact has changed.
//!
//! Prediction runs every tick. The difference between measured and predicted displacement is averaged
//! over [`DECIMATION`] ticks, and then corrects; the covariance runs at that lower rate.
//!
//! A contact turns the rate round within half a millisecond. At its onset the observer notes the rate (the
//! approach speed), sets a guess of the rebound, opens the rate's covariance by as much as the jump, and
//! ignores the samples until the contact is over. Innovations beyond five standard deviations are clipped; if
//! that happens four times in a row, the observer is wrong and not the sensor (a contact too weak
//! to be detected), and the covariance is opened.

use nalgebra::{Matrix3, Vector3};

use super::contact_omega;
use crate::model::params::SupportParams;
use crate::settings::Settings;

/// Ticks whose mean innovation makes one correction.
pub const DECIMATION: u32 = 8;

/// Clipped innovations in a row after which the observer starts anew.
const CLIPS: u32 = 4;

/// Innovations beyond so many standard deviations are clipped.
const GATE: f32 = 5.0;

/// Noise of the displacement difference in units of A0: 2 % of a stroke of about five A0.
const NOISE_PER_AMPLITUDE: f32 = 0.1;

/// Size of the disturbance acceleration in units of ω² A0: a natural frequency 10 % off at a stroke of
/// two A0 about the mean.
const DISTURBANCE: f32 = 0.4;

/// Restitution guessed right after a contact (Table 3.1: 0.317).
const RESTITUTION: f32 = 0.3;

/// By how much the hammer's sensor may be late, s: after a contact it still comes closer for as long, and where it is must not
/// be taken for how fast it leaves. Of more than 0.3 ms the rebound would scatter by more than 10 % at the noise above.
const LATE_S: f32 = 0.2e-3;

/// A Kalman observer of the hammer's displacement and rate relative to the cart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observer {
    tick_s: f32,
    omega2: f32,
    damping: f32,
    step: Matrix3<f32>,
    wander: Vector3<f32>,
    noise: f32,
    rate_scale: f32,
    state: Vector3<f32>,
    covariance: Matrix3<f32>,
    acceleration: f32,
    innovation: f32,
    seen: u32,
    hold: u32,
    hold_ticks: u32,
    clipped: u32,
    health: f32,
    /// Rate gained since the release, m/s, and ticks since.
    gained: f32,
    flown: u32,
    started: bool,
}

impl Observer {
    /// An observer for the rig that the settings believe in.
    pub fn new(settings: &Settings, tick_s: f32) -> Self {
        let rig = &settings.rig;
        let omega = (core::f64::consts::TAU * rig.natural_frequency_hz()) as f32;
        let ratio = match rig.support {
            SupportParams::Wires { .. } => 0.0,
            SupportParams::Beams { damping_ratio, .. } => damping_ratio as f32,
        };
        let amplitude = rig.amplitude_m as f32;
        let omega2 = omega * omega;
        let damping = 2.0 * ratio * omega;
        let span = tick_s * DECIMATION as f32;
        let step = Matrix3::new(
            1.0,
            span,
            0.5 * span * span,
            -omega2 * span,
            1.0 - damping * span,
            span,
            0.0,
            0.0,
            1.0,
        );
        let disturbance = DISTURBANCE * omega2 * amplitude;
        let grain = settings.hammer.unit_per_code;
        let cart_grain = settings.cart.unit_per_code;
        let sigma = NOISE_PER_AMPLITUDE * amplitude;
        let noise = sigma * sigma + (grain * grain + cart_grain * cart_grain) / 12.0;
        let mut observer = Self {
            tick_s,
            omega2,
            damping,
            step,
            wander: Vector3::new(
                0.0,
                0.01 * disturbance * disturbance / omega * span,
                2.0 * disturbance * disturbance * omega * span,
            ),
            noise: noise / DECIMATION as f32,
            rate_scale: amplitude * omega,
            state: Vector3::zeros(),
            covariance: Matrix3::zeros(),
            acceleration: 0.0,
            innovation: 0.0,
            seen: 0,
            hold: 0,
            hold_ticks: hold_ticks(settings, tick_s),
            clipped: 0,
            health: 1.0,
            gained: 0.0,
            flown: 0,
            started: false,
        };
        observer.reset();
        observer
    }

    /// Forgets everything; the next sample says where the hammer is.
    pub fn reset(&mut self) {
        let d = DISTURBANCE * self.omega2 * self.rate_scale / libm::sqrtf(self.omega2);
        self.state = Vector3::zeros();
        self.covariance = Matrix3::from_diagonal(&Vector3::new(
            self.noise * DECIMATION as f32,
            self.rate_scale * self.rate_scale,
            d * d,
        ));
        self.acceleration = 0.0;
        self.innovation = 0.0;
        self.seen = 0;
        self.hold = 0;
        self.clipped = 0;
        self.health = 1.0;
        self.gained = 0.0;
        self.flown = u32::MAX;
        self.started = false;
    }

    /// One tick: the measured displacement x − y, m, and the cart's inertial acceleration −ÿ, m/s².
    #[inline]
    pub fn tick(&mut self, relative_m: f32, drive_m_per_s2: f32) {
        if !self.started {
            self.started = true;
            self.state.x = relative_m;
        }
        if self.hold > 0 {
            self.hold -= 1;
            // In contact the hammer stays where it is, within a hundredth of a millimetre.
            if self.hold < MARGIN {
                self.predict(drive_m_per_s2);
            }
            return;
        }
        self.predict(drive_m_per_s2);
        self.innovation += relative_m - self.state.x;
        self.seen += 1;
        if self.seen >= DECIMATION {
            self.correct();
        }
    }

    #[inline]
    fn predict(&mut self, drive_m_per_s2: f32) {
        let h = self.tick_s;
        let (x, v, d) = (self.state.x, self.state.y, self.state.z);
        let a = drive_m_per_s2 + d - self.omega2 * x - self.damping * v;
        let gain = h * a;
        self.acceleration = a;
        self.state.x = x + h * (v + 0.5 * gain);
        self.state.y = v + gain;
        self.gained += gain;
        self.flown = self.flown.saturating_add(1);
    }

    fn correct(&mut self) {
        let mean = self.innovation * (1.0 / DECIMATION as f32);
        let mean = if mean.is_finite() { mean } else { 0.0 };
        self.innovation = 0.0;
        self.seen = 0;
        self.covariance = self.step * self.covariance * self.step.transpose()
            + Matrix3::from_diagonal(&self.wander);
        let p = &self.covariance;
        let column = Vector3::new(p.m11, p.m21, p.m31);
        let variance = column.x + self.noise;
        let inverse = 1.0 / variance;
        let square = mean * mean * inverse;
        let square = if square < 100.0 { square } else { 100.0 };
        self.health += (square - self.health) * (1.0 / 64.0);
        let mean = self.gate(mean, variance, square);
        let gain = column * inverse;
        self.state += gain * mean;
        let updated = self.covariance - gain * column.transpose();
        // Symmetric and with a positive diagonal, whatever rounding did.
        self.covariance = (updated + updated.transpose()) * 0.5;
        for i in 0..3 {
            if let Some(value) = self.covariance.get_mut((i, i))
                && (*value <= 0.0 || value.is_nan())
            {
                *value = 1e-12;
            }
        }
    }

    /// The innovation, clipped; opens the covariance when clipping does not end.
    fn gate(&mut self, mean: f32, variance: f32, square: f32) -> f32 {
        if square <= GATE * GATE {
            self.clipped = 0;
            return mean;
        }
        self.clipped += 1;
        if self.clipped >= CLIPS {
            self.clipped = 0;
            self.covariance.m11 += mean * mean;
            self.covariance.m22 += self.rate_scale * self.rate_scale;
            return mean;
        }
        let limit = GATE * libm::sqrtf(variance);
        if mean > 0.0 { limit } else { -limit }
    }

    /// A contact began `ago_s` seconds before the last sample: its approach speed, m/s.
    pub fn contact(&mut self, ago_s: f32) -> f32 {
        // The prediction has run on past the onset, without the contact's force.
        let approach = self.state.y - self.acceleration * ago_s;
        self.state.x -= self.state.y * ago_s;
        self.state.y = -RESTITUTION * approach;
        let slip = approach * LATE_S;
        self.covariance.m11 += slip * slip;
        self.covariance.m22 += approach * approach + 0.01 * self.rate_scale * self.rate_scale;
        self.innovation = 0.0;
        self.seen = 0;
        self.clipped = 0;
        self.hold = self.hold_ticks;
        self.gained = 0.0;
        self.flown = 0;
        approach
    }

    /// Speed away from the surface at the last release, m/s, from the rate now and what it has gained
    /// since, and how long ago the release was, ticks.
    #[inline]
    pub fn rebound(&self) -> (f32, u32) {
        (self.gained - self.state.y, self.flown)
    }

    /// Displacement, m, and rate, m/s.
    #[inline]
    pub fn relative(&self) -> (f32, f32) {
        (self.state.x, self.state.y)
    }

    /// Innovation in standard deviations, root mean square over some 25 ms: about 1 if sensors and model agree,
    /// 10 at most.
    pub fn health(&self) -> f32 {
        libm::sqrtf(self.health)
    }
}

/// Ticks after the believed release for which the observer still looks away: filter delay, a softer contact.
const MARGIN: u32 = 5;

/// Ticks to look away for: a contact of half a period of the surface's spring, less what damping
/// shortens it by (Table 3.1: 0.78 of it), and a margin.
fn hold_ticks(settings: &Settings, tick_s: f32) -> u32 {
    let half_period = core::f64::consts::PI / contact_omega(&settings.rig);
    let ticks = 0.78 * half_period as f32 / tick_s;
    (if ticks < 400.0 { ticks as u32 } else { 400 }) + MARGIN
}

#[cfg(test)]
mod tests;
