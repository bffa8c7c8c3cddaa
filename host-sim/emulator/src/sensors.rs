//! From true values to the codes of the ADC.
//!
//! Force: contact force at every tenth of a tick, plus the surface's ringing, through the anti-alias filter.
//! Displacements: through theirs. Then gain error, offset, Gaussian noise, the conditioner's rails and 12 bits.

mod line;

use std::f64::consts::TAU;

use numerics::drop_test::{RINGING_DECAY_S, RINGING_HZ};
use numerics::noise::Noise;
use serde::Deserialize;
use shared::io::AdcCode;
use shared::settings::Settings;

use super::filter::Butterworth;
use super::plant::{INNER, Plant, PlantBlow};
use line::SensorLine;
pub use line::{BadContactEnd, Defect};

/// Below this, N, the force signal's filter and ringing are at rest.
const QUIET_N: f64 = 1e-6;

/// One sensor's errors, in the sensor's unit (N or m).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorErrors {
    /// Added to the value.
    pub offset: f64,
    /// The value is read 1 + this times as large as it is.
    pub gain_error: f64,
    /// Standard deviation of a sample.
    pub noise: f64,
}

/// Errors of the three sensors, their anti-alias filters, and the surface's ringing in the force signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorParams {
    /// Errors of the force sensor, in N.
    pub force: SensorErrors,
    /// Errors of the hammer's displacement sensor, in m.
    pub hammer: SensorErrors,
    /// Errors of the cart's displacement sensor, in m.
    pub cart: SensorErrors,
    /// Corner of the force signal's anti-alias filter, Hz.
    pub force_filter_hz: f64,
    /// Corner of the displacements' anti-alias filters, Hz.
    pub displacement_filter_hz: f64,
    /// The surface's ringing, Hz.
    pub ringing_hz: f64,
    /// Its first amplitude as a share of the contact's peak.
    pub ringing_share: f64,
    /// Its time constant, s.
    pub ringing_decay_s: f64,
}

impl EmulatedSensor {
    /// All, in the order of their codes.
    pub const ALL: [Self; 3] = [Self::Force, Self::Hammer, Self::Cart];
}

impl Default for SensorParams {
    fn default() -> Self {
        Self {
            force: SensorErrors::default(),
            hammer: SensorErrors::default(),
            cart: SensorErrors::default(),
            force_filter_hz: 6000.0,
            displacement_filter_hz: 2000.0,
            ringing_hz: RINGING_HZ,
            ringing_share: 0.5,
            ringing_decay_s: RINGING_DECAY_S,
        }
    }
}

/// A sensor; as a number, its place among the codes of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EmulatedSensor {
    /// The sensor of the contact force.
    Force,
    /// The sensor of the hammer's displacement.
    Hammer,
    /// The sensor of the cart's displacement.
    Cart,
}

/// The surface's ringing: after each contact's largest force it swings about zero, falling first.
#[derive(Clone, Debug)]
struct Ringing {
    decay_per_s: f64,
    omega: f64,
    share: f64,
    /// Over one inner step: what the phasor is turned and shrunk by.
    turn: (f64, f64),
    phasor: (f64, f64),
}

impl Ringing {
    fn new(params: &SensorParams, step_s: f64) -> Self {
        let mut ringing = Self {
            decay_per_s: 1.0 / params.ringing_decay_s,
            omega: TAU * params.ringing_hz,
            share: params.ringing_share,
            turn: (1.0, 0.0),
            phasor: (0.0, 0.0),
        };
        ringing.turn = ringing.after(1.0, step_s);
        ringing
    }

    /// A phasor of `amplitude` after `s`.
    fn after(&self, amplitude: f64, s: f64) -> (f64, f64) {
        let size = amplitude * (-self.decay_per_s * s).exp();
        let (sin, cos) = (self.omega * s).sin_cos();
        (size * cos, size * sin)
    }

    fn is_quiet(&self) -> bool {
        self.phasor.0.abs() < QUIET_N && self.phasor.1.abs() < QUIET_N
    }

    /// The ringing after one more inner step, in which `blow` fell `late_s` before its end.
    fn next(&mut self, blow: Option<(f64, f64)>) -> f64 {
        let ((a, b), (c, d)) = (self.phasor, self.turn);
        self.phasor = (a * c - b * d, a * d + b * c);
        if let Some((peak_n, late_s)) = blow {
            let new = self.after(self.share * peak_n, late_s);
            self.phasor = (self.phasor.0 + new.0, self.phasor.1 + new.1);
        }
        -self.phasor.1
    }
}

/// Force and displacement sensors.
#[derive(Clone, Debug)]
pub struct Sensors {
    lines: [SensorLine; 3],
    force_filter: Butterworth,
    filters: [Butterworth; 2],
    ringing: Ringing,
    tick_s: f64,
    noise: Noise,
    noisy: bool,
    swapped: bool,
}

impl Sensors {
    /// Sensors with the calibration of `settings`, in error by `params`; a tick lasts `tick_s`.
    pub fn new(params: &SensorParams, settings: &Settings, tick_s: f64, seed: u64) -> Self {
        let inner_s = tick_s / INNER as f64;
        let displacement = Butterworth::new(params.displacement_filter_hz, tick_s);
        Self {
            lines: [
                SensorLine::new(settings.force, params.force, tick_s),
                SensorLine::new(settings.hammer, params.hammer, tick_s),
                SensorLine::new(settings.cart, params.cart, tick_s),
            ],
            force_filter: Butterworth::new(params.force_filter_hz, inner_s),
            filters: [displacement.clone(), displacement],
            ringing: Ringing::new(params, inner_s),
            tick_s,
            noise: Noise::new(seed),
            noisy: [params.force, params.hammer, params.cart]
                .iter()
                .any(|e| e.noise != 0.0),
            swapped: false,
        }
    }

    /// A sensor gets a defect, on top of those it has; `id` ends it again.
    pub fn begin(&mut self, sensor: EmulatedSensor, id: usize, defect: Defect) {
        self.noisy |= matches!(defect, Defect::Dead(Some(_)));
        self.lines[sensor as usize].begin(id, defect);
        self.wire();
    }

    /// The defects of this `id` are over.
    pub fn end(&mut self, id: usize) {
        self.lines.iter_mut().for_each(|line| line.end(id));
        self.wire();
    }

    fn wire(&mut self) {
        self.swapped = self.lines.iter().any(SensorLine::is_swapped);
    }

    /// Whether a sensor is defective.
    pub fn is_defective(&self) -> bool {
        self.lines.iter().any(SensorLine::is_defective)
    }

    /// Codes of force, hammer and cart at the end of the plant's tick.
    #[inline]
    pub fn read(&mut self, plant: &Plant) -> [AdcCode; 3] {
        let force = self.force(plant.touched(), plant.inner_forces_n(), plant.blows());
        let [hammer_filter, cart_filter] = &mut self.filters;
        let values = [
            force,
            hammer_filter.next(plant.hammer_m()),
            cart_filter.next(plant.cart_m()),
        ];
        let mut codes = [AdcCode::default(); 3];
        for ((code, line), value) in codes.iter_mut().zip(&mut self.lines).zip(values) {
            let noise = if self.noisy { self.noise.sample() } else { 0.0 };
            *code = line.read(value, noise);
        }
        if self.swapped {
            codes.swap(
                EmulatedSensor::Hammer as usize,
                EmulatedSensor::Cart as usize,
            );
        }
        codes
    }

    /// The force signal at the end of a tick, N.
    #[inline]
    fn force(&mut self, touched: bool, inner: &[f64; INNER], blows: &[PlantBlow]) -> f64 {
        if !touched && self.ringing.is_quiet() && self.force_filter.is_below(QUIET_N) {
            return 0.0;
        }
        let width = self.tick_s / INNER as f64;
        let mut out = 0.0;
        for (k, force) in inner.iter().enumerate() {
            let end = (k + 1) as f64 * width;
            let within = |b: &&PlantBlow| b.at_s > end - width && b.at_s <= end;
            let blow = blows.iter().find(within);
            let ringing = self.ringing.next(blow.map(|b| (b.peak_n, end - b.at_s)));
            out = self.force_filter.next(force + ringing);
        }
        out
    }
}
