//! What the rig tells of itself while it runs: contact stiffness and damping, natural frequency, gap.
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
//! fade ([`MEMORY`] windows). Offsets of the sensors end in Δ₀; a cart that a blow has shaken does no harm, since
//! its measured motion is what enters.
//!
//! # Contact
//! For the spring-dashpot (3-3) with ω₀ = √(k/m) and ζ = cos ψ the contact lasts 2ψ/(ω₀ sin ψ), rebounds at
//! e = exp(−2ψ/tan ψ) of the approach speed, and its force has its centre of gravity at
//!
//! ```text
//! t̄ = e (2ψ/sin ψ + 2 cos ψ) / ((1 + e) ω₀)
//! ```
//!
//! after the onset (partial integration of F = −m ẍ). e comes from the observer's speeds, t̄ from the force
//! signal. The centre is used and not the time above a threshold: ringing of half the peak moves the first
//! fall through a threshold by as much as it likes.
//!
//! **How good this is.** e is unbiased, so ζ is good. t̄ is some 190 µs, four samples; the anti-alias filter delays it
//! by 45 µs (corrected for a 5 kHz filter), the onset is found late by a share of a tick that depends on
//! threshold over peak (corrected to first order), and ringing that starts other than at its
//! crest moves it. Stiffness goes with 1/t̄²: the tests, in `tests/tests/sense`, find it within 25 % and no
//! better. Its spread is therefore never given as less than [`SYSTEMATIC`]. It is told for the spring-dashpot alone.
//!
//! # Gap
//! The observer's displacement at the onset, averaged. It is relative to the rest position found in the self
//! test.

use crate::contact::Law;
use crate::params::SupportParams;
use crate::sense::{Pulse, Sample};
use crate::settings::{Settings, TICK_S};

/// Windows or contacts that an estimate rests on at most: older ones fade.
pub const MEMORY: u32 = 200;

/// Least relative spread given for stiffness; half of it for damping.
pub const SYSTEMATIC: f32 = 0.15;

/// Largest deviation from what is believed that is taken for true: a factor for stiffness and damping.
pub const CONTACT_RANGE: f32 = 3.0;

/// The same for the natural frequency, a share.
pub const NATURAL_RANGE: f32 = 0.3;

/// The same for the gap, in units of A0.
pub const GAP_RANGE: f32 = 2.0;

/// Delay of the force signal's centre in a second-order Butterworth filter of 5 kHz: √2/ωc, s.
const FILTER_DELAY_S: f32 = 45e-6;

/// How much later than the onset the threshold is crossed, per threshold over peak, s (measured against the
/// reference at peaks of 32, 50 and 128 N, one tick of 50 µs, the same filter).
const CROSSING_S: f32 = 100e-6;

/// Ticks after a contact before a window may open (2 ms).
const SETTLE: u32 = 40;

/// Points needed before a natural frequency is told.
const FEWEST_WINDOWS: u32 = 24;

/// Share of the variance of Y that the line may leave unexplained.
const SCATTER: f32 = 0.03;

/// Contacts needed before anything about the contact is told.
const FEWEST_CONTACTS: u32 = 8;

/// An estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The value, in the unit of the field that holds it.
    pub value: f32,
    /// Its standard error, same unit.
    pub sigma: f32,
    /// Contacts or windows it rests on.
    pub samples: u32,
}

/// What has been identified; none: too little seen, or the result is not plausible.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimates {
    /// Contact stiffness ki of the spring-dashpot, N/m.
    pub stiffness: Option<Estimate>,
    /// Contact damping ci of the spring-dashpot, N·s/m.
    pub damping: Option<Estimate>,
    /// Natural frequency, Hz.
    pub natural_hz: Option<Estimate>,
    /// Gap, m.
    pub gap_m: Option<Estimate>,
}

/// Mean and variance that forget.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Average {
    mean: f32,
    variance: f32,
    count: u32,
}

impl Average {
    fn push(&mut self, value: f32) {
        self.count = self.count.saturating_add(1);
        let weight = 1.0 / self.count.min(MEMORY) as f32;
        let off = value - self.mean;
        self.mean += weight * off;
        self.variance = (1.0 - weight) * (self.variance + weight * off * off);
    }

    /// Standard error of the mean.
    fn sigma(&self) -> f32 {
        let count = self.count.clamp(2, MEMORY);
        libm::sqrtf(self.variance / (count - 1) as f32)
    }
}

/// A straight line through points, older ones fading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Line {
    x: f32,
    y: f32,
    xx: f32,
    xy: f32,
    yy: f32,
    count: u32,
}

impl Line {
    fn push(&mut self, x: f32, y: f32) {
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
    fn fit(&self) -> Option<(f32, f32)> {
        if self.count < FEWEST_WINDOWS || !(self.xx > 0.0) {
            return None;
        }
        let slope = self.xy / self.xx;
        let left = self.yy - slope * self.xy;
        let freedom = 1.0 - 2.0 / self.count.min(MEMORY) as f32;
        Some((slope, if left > 0.0 { left / freedom } else { 0.0 }))
    }
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

/// Identifies the rig from its own contacts and flights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Identify {
    mass_kg: f32,
    believed: Believed,
    on_n: f32,
    /// c/m, 1/s.
    damping: f32,
    /// Least approach speed that is used, m/s.
    slowest: f32,
    window_ticks: u32,
    per_window: f32,
    /// Square of an acceleration too small to call a point an outlier for: 5 % of ω² A0.
    grain: f32,
    window: Window,
    settle: u32,
    line: Line,
    outliers: u32,
    approach: Average,
    restitution: Average,
    centroid: Average,
    gap: Average,
    refused: u32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Believed {
    /// ki and ci, if the law is the spring-dashpot.
    contact: Option<(f32, f32)>,
    natural_hz: f32,
    gap_m: f32,
    amplitude_m: f32,
}

impl Identify {
    /// Around the rig that the settings believe in.
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
            damping: 2.0 * ratio * omega,
            slowest: 0.5 * amplitude_m * omega,
            window_ticks,
            per_window: 1.0 / window_ticks as f32,
            grain: 2.5e-3 * (omega * omega * amplitude_m) * (omega * omega * amplitude_m),
            window: Window::default(),
            settle: SETTLE,
            line: Line::default(),
            outliers: 0,
            approach: Average::default(),
            restitution: Average::default(),
            centroid: Average::default(),
            gap: Average::default(),
            refused: 0,
        }
    }

    /// One tick's samples, and whether a contact is under way ([`crate::sense::Sense::in_contact`]).
    #[inline]
    pub fn flight(&mut self, sample: &Sample, in_contact: bool) {
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
        if let Some((slope, square)) = self.line.fit() {
            let off = y - self.line.y - slope * (x - self.line.x);
            if !(off * off <= 25.0 * (square + self.grain)) {
                self.refused = self.refused.saturating_add(1);
                self.outliers += 1;
                if self.outliers >= FEWEST_WINDOWS {
                    // They agree with each other, then: the rig has changed.
                    self.line = Line::default();
                    self.outliers = 0;
                }
                return;
            }
        }
        self.outliers = 0;
        if x.is_finite() && y.is_finite() {
            self.line.push(x, y);
        }
    }

    /// A contact.
    pub fn pulse(&mut self, pulse: &Pulse) {
        let off = pulse.relative_m - self.believed.gap_m;
        let reach = GAP_RANGE * self.believed.amplitude_m;
        if !(off <= reach && off >= -reach) {
            self.refused = self.refused.saturating_add(1);
            return;
        }
        self.gap.push(pulse.relative_m);
        if !(pulse.approach_m_per_s >= self.slowest) {
            return;
        }
        let restitution = pulse.rebound_m_per_s / pulse.approach_m_per_s;
        let late = CROSSING_S * self.on_n / pulse.peak_n;
        let centroid = pulse.centroid_s - FILTER_DELAY_S + late;
        let plausible = restitution > -0.2
            && restitution < 1.2
            && centroid > 2e-5
            && centroid < 5e-3
            && pulse.peak_n >= self.on_n;
        if !plausible {
            self.refused = self.refused.saturating_add(1);
            return;
        }
        self.approach.push(pulse.approach_m_per_s);
        self.restitution.push(restitution);
        self.centroid.push(centroid);
    }

    /// What has been identified. Some thousand instructions: for now and then.
    pub fn estimates(&self) -> Estimates {
        let (stiffness, damping) = self.contact();
        Estimates {
            stiffness,
            damping,
            natural_hz: self.natural(),
            gap_m: (self.gap.count >= FEWEST_CONTACTS).then(|| Estimate {
                value: self.gap.mean,
                sigma: self.gap.sigma(),
                samples: self.gap.count,
            }),
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
        self.line = Line::default();
        self.outliers = 0;
        self.approach = Average::default();
        self.restitution = Average::default();
        self.centroid = Average::default();
        self.gap = Average::default();
    }

    fn natural(&self) -> Option<Estimate> {
        let (slope, square) = self.line.fit()?;
        // Contacts too weak to be detected, one per period, leave a scatter that no noise does.
        let straight = square < SCATTER * self.line.yy;
        if !(slope > 0.0 && straight) {
            return None;
        }
        let omega = libm::sqrtf(slope);
        let value = omega * (1.0 / core::f32::consts::TAU);
        let count = self.line.count.min(MEMORY) as f32;
        let sigma_slope = libm::sqrtf(square / (self.line.xx * count));
        let sigma = sigma_slope / (2.0 * omega) * (1.0 / core::f32::consts::TAU);
        let believed = self.believed.natural_hz;
        let off = value / believed - 1.0;
        (off <= NATURAL_RANGE && off >= -NATURAL_RANGE).then_some(Estimate {
            value,
            sigma,
            samples: self.line.count,
        })
    }

    fn contact(&self) -> (Option<Estimate>, Option<Estimate>) {
        let Some((stiffness, damping)) = self.believed.contact else {
            return (None, None);
        };
        let samples = self.restitution.count;
        if samples < FEWEST_CONTACTS {
            return (None, None);
        }
        let Some(law) = spring_dashpot(self.restitution.mean, self.centroid.mean) else {
            return (None, None);
        };
        let k = self.mass_kg * law.omega * law.omega;
        let c = 2.0 * law.damping_ratio * self.mass_kg * law.omega;
        let centroid = self.centroid.sigma() / self.centroid.mean;
        let restitution = self.restitution.sigma() / self.restitution.mean;
        let spread = SYSTEMATIC + 2.0 * centroid;
        let within = |value: f32, believed: f32| {
            value < CONTACT_RANGE * believed && value * CONTACT_RANGE > believed
        };
        let estimate = |value: f32, believed: f32, spread: f32| {
            within(value, believed).then_some(Estimate {
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

/// A spring-dashpot contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// ω₀ = √(k/m), rad/s.
    pub omega: f32,
    /// ζ.
    pub damping_ratio: f32,
    /// How long it lasts, s.
    pub duration_s: f32,
}

/// The spring-dashpot that rebounds at `restitution` of the approach speed and whose force has its centre
/// `centroid_s` after the onset; none for a restitution below e⁻² = 0.135, which no underdamped contact has,
/// or of 1 and above.
pub fn spring_dashpot(restitution: f32, centroid_s: f32) -> Option<Contact> {
    if !(restitution > 0.14 && restitution < 0.99 && centroid_s > 0.0) {
        return None;
    }
    let psi = libm::sqrtf(angle_squared(-0.5 * libm::logf(restitution)));
    let (sin, cos) = (libm::sinf(psi), libm::cosf(psi));
    if !(sin > 0.0) {
        return None;
    }
    let turns = 2.0 * psi / sin;
    let centre = restitution * (turns + 2.0 * cos) / (1.0 + restitution);
    let omega = centre / centroid_s;
    Some(Contact {
        omega,
        damping_ratio: cos,
        duration_s: turns / omega,
    })
}

/// u = ψ² with ψ cot ψ = `half`, 0 to 1, for ψ up to π/2: five Newton steps on the series
/// ψ cot ψ = 1 − u/3 − u²/45 − 2u³/945 − …, whose terms fall by u/π², at least fourfold.
fn angle_squared(half: f32) -> f32 {
    const SERIES: [f32; 10] = [
        1.0 / 3.0,
        1.0 / 45.0,
        2.0 / 945.0,
        1.0 / 4_725.0,
        2.0 / 93_555.0,
        1_382.0 / 638_512_875.0,
        4.0 / 18_243_225.0,
        3_617.0 / 162_820_783_125.0,
        87_734.0 / 38_979_295_480_125.0,
        349_222.0 / 1_531_329_465_290_625.0,
    ];
    let wanted = 1.0 - half;
    let mut u = 3.0 * wanted;
    for _ in 0..5 {
        let (mut value, mut slope) = (0.0_f32, 0.0_f32);
        for term in SERIES.iter().rev() {
            slope = slope * u + value;
            value = value * u + term;
        }
        // value is the series over u.
        let excess = u * value - wanted;
        u -= excess / (value + u * slope);
        u = if u > 0.0 { u } else { 0.0 };
    }
    u
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::WIRES;

    #[test]
    fn the_closed_form_gives_back_table_3_1() {
        // k 5.5e6, c 1.2e3, m 0.298: ω0 4296.0956, ζ 0.468666, restitution 0.316902, 0.570751 ms.
        let (omega, zeta) = (4_296.095_6_f64, 0.468_666_f64);
        let psi = zeta.acos();
        let restitution = (-2.0 * psi / psi.tan()).exp();
        let turns = 2.0 * psi / psi.sin();
        let centroid = restitution * (turns + 2.0 * zeta) / ((1.0 + restitution) * omega);
        let found = spring_dashpot(restitution as f32, centroid as f32).unwrap();
        assert!((f64::from(found.omega) / omega - 1.0).abs() < 1e-5);
        assert!((f64::from(found.damping_ratio) / zeta - 1.0).abs() < 1e-5);
        assert!((f64::from(found.duration_s) - 0.570_751e-3).abs() < 2e-8);
    }

    #[test]
    fn the_series_is_inverted_over_its_whole_range() {
        for i in 1..=100 {
            let psi = f64::from(i) * 0.0155;
            let half = psi / psi.tan();
            let found = f64::from(angle_squared(half as f32)).sqrt();
            // Near ψ = 0 the square of ψ is the difference of two numbers near 1.
            assert!((found - psi).abs() < 2e-5 + 1e-7 / psi, "{psi}: {found}");
        }
    }

    /// The hammer swinging freely in a cart that moves as it likes.
    fn swing(identify: &mut Identify, natural_hz: f64, seconds: f64) {
        let omega = std::f64::consts::TAU * natural_hz;
        let h = TICK_S;
        let (mut x, mut v) = (2e-3_f64, 0.0_f64);
        for k in 0..(seconds / h) as u32 {
            let t = f64::from(k) * h;
            let y = 0.9e-3 * (17.0 * t).sin() + 0.2e-3 * (41.0 * t).cos();
            v -= h * omega * omega * (x - y);
            x += h * v;
            let sample = Sample {
                force_n: 0.0,
                hammer_m: (x + 1e-4) as f32,
                cart_m: y as f32,
            };
            identify.flight(&sample, false);
        }
    }

    #[test]
    fn natural_frequency_ten_percent_off_is_found_whatever_the_cart_does() {
        let settings = Settings::for_rig(&WIRES);
        for factor in [0.9, 1.0, 1.1] {
            let mut identify = Identify::new(&settings);
            swing(&mut identify, factor * 1.82, 10.0);
            let found = identify.estimates().natural_hz.unwrap();
            // The integrator above is of first order: 5e-5 relative at this step.
            let off = f64::from(found.value) / (factor * 1.82) - 1.0;
            assert!(off.abs() < 1e-3, "{factor}: {found:?}");
            assert_eq!(identify.refused(), 0);
        }
    }

    #[test]
    fn a_rig_that_changes_is_followed_and_an_implausible_one_is_not_told() {
        let settings = Settings::for_rig(&WIRES);
        let mut identify = Identify::new(&settings);
        swing(&mut identify, 1.82, 10.0);
        swing(&mut identify, 2.0, 60.0);
        let found = identify.estimates().natural_hz.unwrap();
        assert!((found.value - 2.0).abs() < 0.01, "{found:?}");
        assert!(identify.refused() > 0);
        let mut identify = Identify::new(&settings);
        swing(&mut identify, 2.6, 10.0);
        assert_eq!(identify.estimates().natural_hz, None);
    }

    #[test]
    fn implausible_contacts_are_refused_and_counted() {
        let settings = Settings::for_rig(&WIRES);
        let mut identify = Identify::new(&settings);
        let good = Pulse {
            peak_n: 96.0,
            approach_m_per_s: 0.08,
            rebound_m_per_s: 0.025,
            centroid_s: 220e-6,
            relative_m: 1e-5,
            ..Pulse::default()
        };
        for _ in 0..10 {
            identify.pulse(&good);
        }
        let before = identify.estimates();
        assert!(before.stiffness.is_some() && before.damping.is_some());
        assert_eq!(identify.refused(), 0);
        for bad in [
            Pulse {
                relative_m: -5e-3,
                ..good
            },
            Pulse {
                rebound_m_per_s: 0.2,
                ..good
            },
            Pulse {
                centroid_s: 0.0,
                ..good
            },
            Pulse {
                relative_m: f32::NAN,
                ..good
            },
            Pulse {
                rebound_m_per_s: f32::NAN,
                ..good
            },
        ] {
            identify.pulse(&bad);
        }
        assert_eq!(identify.refused(), 5);
        assert_eq!(identify.estimates().stiffness, before.stiffness);
    }
}
