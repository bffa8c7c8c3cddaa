//! One channel from value to code, with whatever is wrong with it.

use std::collections::VecDeque;

use serde::Deserialize;
use shared::io::{ADC_FULL_SCALE, AdcCode, Channel};

use super::SensorErrors;

/// What the conditioners give at the rails, as codes: past `LOW_RAIL` and `HIGH_RAIL`, short of an open wire.
const RAILS: (f64, f64) = (100.0, 3995.0);

/// Where a bad contact pulls the signal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BadContactEnd {
    /// As an open wire does: code 0.
    #[default]
    Open,
    /// To the upper rail.
    High,
    /// To the lower rail.
    Low,
}

impl BadContactEnd {
    fn code(self) -> AdcCode {
        match self {
            Self::Open => AdcCode(0),
            Self::High => AdcCode(ADC_FULL_SCALE),
            Self::Low => AdcCode(RAILS.0 as u16),
        }
    }
}

/// What is wrong with a sensor. Lengths in m, forces in N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Defect {
    /// The wire is open: code 0.
    Open,
    /// At the upper rail.
    Saturated,
    /// At the lower rail.
    SaturatedLow,
    /// The code stays where it was.
    Frozen,
    /// The value is read this many times too large.
    Gain(f64),
    /// The whole signal, its zero too, is this many times too large: a supply that is not what it should be.
    Supply(f64),
    /// The gain grows by this share of itself per second.
    GainDrift(f64),
    /// The value is read with its sign reversed.
    Reversed,
    /// This is added to the value.
    Offset(f64),
    /// So much is added per second.
    OffsetDrift(f64),
    /// Nothing is measured; noise of this standard deviation remains, or the sensor's own.
    Dead(Option<f64>),
    /// The value is read this many ticks late.
    Delayed(u32),
    /// It is read later by so many seconds each second, from no delay on.
    DelayDrift(f64),
    /// The wires of hammer and cart are exchanged.
    Swapped,
    /// A bad contact: so many ticks of each so many, the signal is at an end.
    Intermittent {
        /// Where the bad contact pulls the signal.
        at: BadContactEnd,
        /// How long the signal is there in each cycle, ticks.
        ticks: u32,
        /// Length of the cycle, ticks.
        of: u32,
    },
}

/// A defect since it came.
#[derive(Clone, Debug)]
struct Active {
    id: usize,
    defect: Defect,
    /// Ticks read since the defect came.
    age: u64,
    /// Values on their way, of a delayed sensor.
    waiting: VecDeque<f64>,
}

impl Active {
    /// What the defect makes of a value; `age_s` is its age, and a tick lasts `tick_s`.
    fn value(&mut self, value: f64, age_s: f64, tick_s: f64) -> f64 {
        match self.defect {
            Defect::Gain(times) => times * value,
            Defect::GainDrift(per_s) => (1.0 + per_s * age_s) * value,
            Defect::Reversed => -value,
            Defect::Offset(by) => value + by,
            Defect::OffsetDrift(per_s) => value + per_s * age_s,
            Defect::Dead(_) => 0.0,
            Defect::Delayed(ticks) => {
                self.waiting.push_back(value);
                let late = self.waiting.front().copied().unwrap_or(value);
                if self.waiting.len() > ticks as usize {
                    self.waiting.pop_front();
                }
                late
            }
            Defect::DelayDrift(per_s) => self.late_by(value, per_s * age_s / tick_s),
            _ => value,
        }
    }
}

impl Active {
    /// The value of `ticks` ago, between two ticks on the line through them. The delay never shrinks.
    fn late_by(&mut self, value: f64, ticks: f64) -> f64 {
        self.waiting.push_back(value);
        let whole = ticks as usize;
        while self.waiting.len() > whole + 2 {
            self.waiting.pop_front();
        }
        // As old as what there is, at most.
        let ago = |n: usize| {
            let i = self.waiting.len().saturating_sub(1 + n);
            self.waiting.get(i).copied().unwrap_or(value)
        };
        let (younger, older) = (ago(whole), ago(whole + 1));
        younger + ticks.fract() * (older - younger)
    }
}

/// One channel from value to code.
#[derive(Clone, Debug)]
pub(super) struct SensorLine {
    believed: Channel,
    errors: SensorErrors,
    defects: Vec<Active>,
    tick_s: f64,
    code: AdcCode,
}

impl SensorLine {
    pub(super) fn new(believed: Channel, errors: SensorErrors, tick_s: f64) -> Self {
        Self {
            believed,
            errors,
            defects: Vec::new(),
            tick_s,
            code: AdcCode(believed.zero_code as u16),
        }
    }

    pub(super) fn begin(&mut self, id: usize, defect: Defect) {
        self.defects.push(Active {
            id,
            defect,
            age: 0,
            waiting: VecDeque::new(),
        });
    }

    pub(super) fn end(&mut self, id: usize) {
        self.defects.retain(|active| active.id != id);
    }

    pub(super) fn is_defective(&self) -> bool {
        !self.defects.is_empty()
    }

    pub(super) fn is_swapped(&self) -> bool {
        self.defects.iter().any(|d| d.defect == Defect::Swapped)
    }

    /// Reads `value` disturbed by `noise` standard deviations.
    #[inline]
    pub(super) fn read(&mut self, value: f64, noise: f64) -> AdcCode {
        let SensorErrors {
            offset,
            gain_error,
            noise: deviation,
        } = self.errors;
        if self.defects.is_empty() {
            let seen = (1.0 + gain_error) * value + offset + deviation * noise;
            self.code = self.to_code(seen, 1.0);
            return self.code;
        }
        let (mut value, mut deviation, mut supply) = (value, deviation, 1.0);
        let mut held = None;
        for active in &mut self.defects {
            let age = active.age;
            active.age += 1;
            value = active.value(value, age as f64 * self.tick_s, self.tick_s);
            match active.defect {
                Defect::Dead(Some(noise)) => deviation = noise,
                Defect::Supply(times) => supply *= times,
                Defect::Frozen => held = Some(self.code),
                Defect::Open => held = Some(BadContactEnd::Open.code()),
                Defect::Saturated => held = Some(BadContactEnd::High.code()),
                Defect::SaturatedLow => held = Some(BadContactEnd::Low.code()),
                Defect::Intermittent { at, ticks, of }
                    if age % u64::from(of) < u64::from(ticks) =>
                {
                    held = Some(at.code());
                }
                _ => {}
            }
        }
        let code = held.unwrap_or_else(|| {
            let seen = (1.0 + gain_error) * value + offset + deviation * noise;
            self.to_code(seen, supply)
        });
        // A wire that opens does not change where a signal froze.
        if held.is_none() {
            self.code = code;
        }
        code
    }

    fn to_code(&self, seen: f64, supply: f64) -> AdcCode {
        let unit = f64::from(self.believed.unit_per_code);
        let code = supply * (f64::from(self.believed.zero_code) + seen / unit);
        // Clamped to the rails, so it fits; NaN reads as the lower one.
        AdcCode((code + 0.5).max(RAILS.0).min(RAILS.1) as u16)
    }
}
