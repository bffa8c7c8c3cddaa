//! Online identification: contact stiffness and damping, natural frequency and gap of the running rig.
//!
//! # Natural frequency
//! In flight the hammer's absolute acceleration is −ω² (Δ − Δ₀) − c Δ̇ with Δ = x − y, whatever the cart does.
//! Over a window of length T, a sixth of the natural period, this is multiplied by φ = s²(1 − s)², s = t/T
//! (a modulating function: it and its slope vanish at both ends), and integrated by parts, so that
//! nothing is ever differentiated and no initial state is needed:
//!
//! ```text
//! Y = −(∫ φ̈ x dt − c ∫ φ̇ Δ dt) / ∫ φ dt = ω² (X − Δ₀),   X = ∫ φ Δ dt / ∫ φ dt
//! ```
//!
//! Each window without a contact gives a point (X, Y); the slope of the line through them is ω². Old points
//! fade ([`MEMORY`] windows). The newest `FEWEST_WINDOWS` begin the line anew if they lie on another one, by an F test:
//! a natural frequency that jumps is not mixed with the one before. Measured with 2 % noise over 100 drive periods: within
//! 1 % near 1.5 times the natural frequency, within 2 % at 2.4, where a flight holds two windows only, and at 3.8, where a
//! pendulum's large strokes lower its frequency. If contacts too weak to be detected hide in the flights, no natural
//! frequency is given.
//! Offsets of the sensors enter Δ₀ alone. A cart shaken by a contact does no harm, since its measured motion
//! enters.
//!
//! # Contact
//! For the spring-dashpot (3-3) with ω₀ = √(k/m) and ζ = cos ψ the contact lasts 2ψ/(ω₀ sin ψ) and rebounds at
//! e = exp(−2ψ/tan ψ) of the approach speed v. Its force starts at 2ζ m ω₀ v; before the end it falls through a
//! threshold F₁ by a time τ with ω₀τ + ζ(ω₀τ)² = F₁/(m ω₀ e v) (from the motion's third and fourth derivatives at
//! the release). e is the ratio of the observer's speeds, and where the cart recoils, which the observer does not know of,
//! e = (1 + ratio) (1 + m/M) − 1, since the contact has changed the hammer's speed by M/(m + M) of 1 + e. ω₀ follows from the time
//! above the threshold, in a few steps of iteration.
//!
//! **How good this is.** Damping ratio: good, e is unbiased. Stiffness: goes with 1/duration², and the duration is
//! eleven samples, seen through an anti-alias filter, with ringing of half the peak on top. The ringing is
//! taken out of the falling edge at its known 3 kHz ([`crate::sense::pulse`]); the rising edge's delay
//! is corrected as measured against the reference (`LATE_S`). What is left depends on how the surface rings: with 2 % noise,
//! `tests/tests/sense` finds stiffness within 15 % and damping within 8 % if it does not ring or rings from the force's peak
//! on, within 40 % and 20 % if the ringing is a mode that the force itself excites. So a spread below
//! [`SYSTEMATIC`] is never given. Only the spring-dashpot is identified.
//!
//! # Gap
//! `gap.rs` says how.

pub mod contact;
mod gap;
mod ratio;
mod statistics;

use crate::model::contact::Law;
use crate::model::params::SupportParams;
use crate::sense::{Pulse, Sample, contact_omega};
use crate::settings::{Settings, TICK_S};
use contact::{Above, spring_dashpot};
pub use gap::GAP_MEMORY;
use gap::Gap;
use ratio::Ratio;
use statistics::{Average, FadingLine};

/// Largest number of windows or contacts in an estimate: older ones fade.
pub const MEMORY: u32 = 200;

/// Least relative spread given for stiffness; half of it for damping.
pub const SYSTEMATIC: f32 = 0.2;

/// Largest deviation from the believed value that is accepted: a factor for stiffness and damping.
pub const CONTACT_RANGE: f32 = 3.0;

/// Largest deviation from the believed natural frequency that is accepted, as a share of it.
pub const NATURAL_RANGE: f32 = 0.3;

/// Largest distance from the believed gap at which a contact is accepted, in units of A0.
pub const GAP_RANGE: f32 = 4.0;

/// Excess of the measured time above the threshold, s: the first less the second times threshold over initial force.
/// Measured against the reference through a second-order filter of 5 kHz at initial forces of 38 to
/// 128 N and a threshold of 14 N, contacts of 0.49 to 0.71 ms; within 6 µs.
const LATE_S: (f32, f32) = (85e-6, 235e-6);

/// Ticks after a contact before a window may open (2 ms).
const SETTLE: u32 = 40;

/// Restitution below which a surface is lossy: its force is largest at the onset, and has fallen before the sensor's filter has
/// followed.
const LOSSY: f32 = 0.31;
/// By how much the true peak is larger for each unit of restitution below that, in units of ω₀ s: fitted to the emulator's contacts
/// of restitution 0.14 to 0.3 (spring-dashpot).
const HIDES: f32 = 0.55e-3;

/// Points needed for a natural frequency.
const FEWEST_WINDOWS: u32 = 24;

/// Contacts needed for a restitution, as many as for the surface's ringing.
const FEW_CONTACTS: u32 = 4;

/// Contacts needed for stiffness and damping.
const FEWEST_CONTACTS: u32 = 8;

/// An estimate, with its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnlineEstimate {
    /// The value, in the unit of the field that holds it.
    pub value: f32,
    /// Its standard error, same unit.
    pub sigma: f32,
    /// Contacts or windows it rests on.
    pub samples: u32,
}

/// The estimates; `None` if there are too few samples or the result is not plausible.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimates {
    /// Contact stiffness ki of the spring-dashpot, N/m.
    pub stiffness: Option<OnlineEstimate>,
    /// Contact damping ci of the spring-dashpot, N·s/m.
    pub damping: Option<OnlineEstimate>,
    /// Natural frequency of the hammer on its support, Hz.
    pub natural_hz: Option<OnlineEstimate>,
    /// Gap between the surface and the hammer at rest, m.
    pub gap_m: Option<OnlineEstimate>,
}

/// One window in flight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Window {
    ticks: u32,
    /// x at its start: taken off, so that sums stay small.
    origin_m: f32,
    /// Sums of φ̈ T² x, φ̇ T Δ, φ Δ.
    curvature: f32,
    slope: f32,
    level: f32,
}

/// Identifies the rig from its contacts and flights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Identification {
    mass_kg: f32,
    believed: Believed,
    on_n: f32,
    /// 1 + m/M of a cart that recoils.
    recoil: f32,
    /// [`HIDES`] for this contact.
    hides: f32,
    /// Damping c/m of the support, 1/s; 0 on wires.
    damping: f32,
    /// Least approach speed that is used, m/s.
    slowest: f32,
    window_ticks: u32,
    /// c/m times the window's length.
    window_damping: f32,
    per_window: f32,
    /// Square of an acceleration too small to call a point an outlier for: 5 % of ω² A0.
    grain: f32,
    window: Window,
    settle: u32,
    line: FadingLine,
    /// The newest points, up to `FEWEST_WINDOWS`, those that were refused among them.
    newest: FadingLine,
    /// Those that were refused.
    outliers: u32,
    approach: Average,
    restitution: Average,
    duration: Average,
    gap: Gap,
    refused: u32,
    ratio: Ratio,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Believed {
    /// ki and ci, if the law is the spring-dashpot.
    contact: Option<(f32, f32)>,
    natural_hz: f32,
    gap_m: f32,
    amplitude_m: f32,
}

impl Identification {
    /// Starts from the rig of the settings.
    pub fn new(settings: &Settings) -> Self {
        let rig = &settings.rig;
        let natural_hz = rig.natural_frequency_hz() as f32;
        let omega = core::f32::consts::TAU * natural_hz;
        let ratio = match rig.support {
            SupportParams::Wires { .. } => 0.0,
            SupportParams::Beams { damping_ratio, .. } => damping_ratio as f32,
        };
        let contact = match rig.contact {
            Law::SpringDashpot { stiffness, damping } => Some((stiffness as f32, damping as f32)),
            _ => None,
        };
        let amplitude_m = rig.amplitude_m as f32;
        let ticks = 1.0 / (6.0 * natural_hz * TICK_S as f32);
        let window_ticks = if ticks < 60_000.0 {
            (ticks as u32).max(64)
        } else {
            60_000
        };
        Self {
            mass_kg: rig.mass_kg as f32,
            believed: Believed {
                contact,
                natural_hz,
                gap_m: rig.gap_m as f32,
                amplitude_m,
            },
            on_n: settings.detection.on_n,
            recoil: (rig.mass_kg / rig.contact_mass_kg()) as f32,
            hides: HIDES * contact_omega(rig) as f32,
            damping: 2.0 * ratio * omega,
            slowest: 0.5 * amplitude_m * omega,
            window_ticks,
            window_damping: 2.0 * ratio * omega * window_ticks as f32 * TICK_S as f32,
            per_window: 1.0 / window_ticks as f32,
            grain: 2.5e-3 * (omega * omega * amplitude_m) * (omega * omega * amplitude_m),
            window: Window::default(),
            settle: SETTLE,
            line: FadingLine::default(),
            newest: FadingLine::default(),
            outliers: 0,
            approach: Average::default(),
            restitution: Average::default(),
            duration: Average::default(),
            gap: Gap::new(amplitude_m),
            refused: 0,
            ratio: Ratio::default(),
        }
    }

    /// The amplitude has been reached: flights before that told little of the sensors.
    pub fn at_amplitude(&mut self) {
        self.ratio.reset();
        self.gap.at_amplitude();
    }

    /// Gain of the hammer's sensor over the cart's, with its sign, if the flights tell it, and from how many windows.
    pub fn hammer_over_cart(&self) -> Option<(f32, u32)> {
        let gain = self.ratio.gain(self.believed.amplitude_m)?;
        Some((gain, self.ratio.windows()))
    }

    /// One tick's samples, and whether a contact is under way ([`crate::sense::Sense::in_contact`]).
    #[inline]
    pub fn flight(&mut self, sample: &Sample, in_contact: bool) {
        let timing = (self.window_ticks, SETTLE);
        self.ratio
            .flight(sample, in_contact, timing, self.window_damping);
        if in_contact {
            self.settle = SETTLE;
            self.window.ticks = 0;
            return;
        }
        if self.settle > 0 {
            self.settle -= 1;
            return;
        }
        let window = &mut self.window;
        if window.ticks == 0 {
            *window = Window {
                origin_m: sample.hammer_m,
                ..Window::default()
            };
        }
        let s = (window.ticks as f32 + 0.5) * self.per_window;
        let past = s * (1.0 - s);
        let relative = sample.hammer_m - sample.cart_m;
        window.curvature += (2.0 - 12.0 * past) * (sample.hammer_m - window.origin_m);
        window.slope += past * (2.0 - 4.0 * s) * relative;
        window.level += past * past * relative;
        window.ticks += 1;
        if window.ticks >= self.window_ticks {
            self.point();
        }
    }

    /// A window is full.
    fn point(&mut self) {
        let window = core::mem::take(&mut self.window);
        let length = self.window_ticks as f32 * TICK_S as f32;
        // Σ φ = N/30.
        let scale = 30.0 * self.per_window;
        let x = scale * window.level;
        let per_s = 1.0 / length;
        let y = -scale * per_s * (per_s * window.curvature - self.damping * window.slope);
        if !(x.is_finite() && y.is_finite()) {
            self.refused = self.refused.saturating_add(1);
            return;
        }
        if self.line.is_off(x, y, self.grain) {
            self.refused = self.refused.saturating_add(1);
            self.outliers += 1;
        } else {
            self.line.push(x, y);
        }
        self.gap.window((x, y), self.grain);
        self.newest.push(x, y);
        if self.newest.count >= FEWEST_WINDOWS {
            self.compare();
        }
    }

    /// The newest points begin the line anew if they lie on another one, or most of them were refused: the rig has changed.
    fn compare(&mut self) {
        let newest = core::mem::take(&mut self.newest);
        let outliers = core::mem::take(&mut self.outliers);
        if 2 * outliers > FEWEST_WINDOWS || self.line.differs_from(&newest, self.grain) {
            self.line = newest;
        }
    }

    /// Takes in a contact: where the surface is and, if it was fast enough, restitution and duration.
    pub fn pulse(&mut self, pulse: &Pulse) {
        let off = pulse.relative_m - self.believed.gap_m;
        let reach = GAP_RANGE * self.believed.amplitude_m;
        if !(-reach..=reach).contains(&off) {
            self.refused = self.refused.saturating_add(1);
            return;
        }
        self.gap.contact(pulse.relative_m);
        let fast = pulse.approach_m_per_s >= self.slowest;
        if !fast {
            return;
        }
        let left = pulse.rebound_m_per_s / pulse.approach_m_per_s;
        let restitution = (1.0 + left) * self.recoil - 1.0;
        let duration = pulse.duration_s;
        // Nothing is known of the rebound where the next contact came first.
        let plausible = pulse.rebound_m_per_s != 0.0
            && restitution > -0.2
            && restitution < 1.2
            && duration > 5e-5
            && duration < 1e-2
            && pulse.peak_n >= self.on_n;
        if !plausible {
            self.refused = self.refused.saturating_add(1);
            return;
        }
        self.approach.push(pulse.approach_m_per_s);
        self.restitution.push(restitution);
        self.duration.push(duration);
    }

    /// Where the last contacts found the surface, from the rest position of the self test, m; none before there are enough.
    pub fn surface_m(&self) -> Option<f32> {
        self.gap.surface_m()
    }

    /// The gap, m: the surface from where the hammer would rest now.
    pub fn gap_m(&self) -> Option<f32> {
        self.gap.gap_m()
    }

    /// How many times what the force sensor shows of it a contact's true peak may be on a surface as lossy as this one.
    pub fn hidden_peak(&self) -> f32 {
        if self.restitution.count < FEW_CONTACTS {
            return 1.0;
        }
        1.0 + self.hides * (LOSSY - self.restitution.mean).clamp(0.0, LOSSY)
    }

    /// What has been identified. Some thousand instructions: for now and then.
    pub fn estimates(&self) -> Estimates {
        let (stiffness, damping) = self.contact();
        Estimates {
            stiffness,
            damping,
            natural_hz: self.natural(),
            gap_m: self.gap.estimate(),
        }
    }

    /// Contacts and windows refused as implausible.
    pub fn refused(&self) -> u32 {
        self.refused
    }

    /// Forgets what it has learnt.
    pub fn reset(&mut self) {
        self.window = Window::default();
        self.settle = SETTLE;
        self.line = FadingLine::default();
        self.newest = FadingLine::default();
        self.outliers = 0;
        self.approach = Average::default();
        self.restitution = Average::default();
        self.duration = Average::default();
        self.gap = Gap::new(self.believed.amplitude_m);
        self.ratio.reset();
    }

    fn natural(&self) -> Option<OnlineEstimate> {
        let (slope, square) = self.line.straight()?;
        let omega = libm::sqrtf(slope);
        let value = omega * (1.0 / core::f32::consts::TAU);
        let count = self.line.count.min(MEMORY) as f32;
        let sigma_slope = libm::sqrtf(square / (self.line.xx * count));
        let sigma = sigma_slope / (2.0 * omega) * (1.0 / core::f32::consts::TAU);
        let believed = self.believed.natural_hz;
        let off = value / believed - 1.0;
        (-NATURAL_RANGE..=NATURAL_RANGE)
            .contains(&off)
            .then_some(OnlineEstimate {
                value,
                sigma,
                samples: self.line.count,
            })
    }

    fn contact(&self) -> (Option<OnlineEstimate>, Option<OnlineEstimate>) {
        let Some((stiffness, damping)) = self.believed.contact else {
            return (None, None);
        };
        let samples = self.restitution.count;
        if samples < FEWEST_CONTACTS {
            return (None, None);
        }
        let force_per_rate = self.mass_kg * self.approach.mean;
        let above = Above {
            duration_s: self.duration.mean,
            threshold: self.on_n / force_per_rate,
            late_s: LATE_S,
        };
        let guess = libm::sqrtf(stiffness / self.mass_kg);
        let Some(law) = spring_dashpot(self.restitution.mean, &above, guess) else {
            return (None, None);
        };
        let k = self.mass_kg * law.omega * law.omega;
        let c = 2.0 * law.damping_ratio * self.mass_kg * law.omega;
        let duration = self.duration.sigma() / self.duration.mean;
        let restitution = self.restitution.sigma() / self.restitution.mean;
        let spread = SYSTEMATIC + 2.0 * duration;
        let within = |value: f32, believed: f32| {
            value < CONTACT_RANGE * believed && value * CONTACT_RANGE > believed
        };
        let estimate = |value: f32, believed: f32, spread: f32| {
            within(value, believed).then_some(OnlineEstimate {
                value,
                sigma: value * spread,
                samples,
            })
        };
        (
            estimate(k, stiffness, spread + restitution),
            estimate(c, damping, 0.5 * spread + restitution),
        )
    }
}

#[cfg(test)]
mod tests;
