//! The controller's inputs and outputs: raw codes, their calibration, and the emergency-stop chain.
//!
//! Codes are newtypes and become SI values in one place, [`Channel::read`]. It distinguishes a value from a
//! rail and from an open wire, so that nothing downstream can mistake one for another.

use embedded_hal::digital::InputPin;
use serde::{Deserialize, Serialize};

/// A raw code of the 12-bit ADC, 0 to 4095.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct AdcCode(pub u16);

/// The ADC's full scale.
pub const ADC_FULL_SCALE: u16 = 4095;

/// A raw code for the 12-bit DAC, 0 to 4095; 2048 commands the middle of the shaker's travel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct DacCode(pub u16);

impl DacCode {
    /// The middle of the travel: the set-point of a drive that is off.
    pub const MIDDLE: Self = Self(2048);
}

/// Furthest set-point from the middle, codes: a 12-bit DAC behind its own buffer gives 0.2 V to 3.1 V of 3.3 V, and clips
/// beyond. A code further out would be a cart that does not follow, and nothing would say so.
pub const DAC_REACH: u16 = 1790;

impl Default for DacCode {
    fn default() -> Self {
        Self::MIDDLE
    }
}

/// At or below this code a channel's wire is open: conditioners have a live zero (0.1 V, code 124), and the
/// input's pull-down brings an open wire to 0 V.
pub const OPEN_AT: AdcCode = AdcCode(40);

/// At or below this code (and above [`OPEN_AT`]) a channel is at its lower rail.
pub const LOW_RAIL: AdcCode = AdcCode(124);

/// At or above this code a channel is at its upper rail.
pub const HIGH_RAIL: AdcCode = AdcCode(3971);

/// A channel's calibration: value = (code − `zero_code`) · `unit_per_code`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Channel {
    /// Code at 0 N or 0 m.
    pub zero_code: f32,
    /// N or m per code; for a displacement it may be negative (a sensor mounted the other way round).
    pub unit_per_code: f32,
}

/// The meaning of a code.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading {
    /// A value, N or m.
    Value(f32),
    /// At a rail: the true value is beyond this one, N or m.
    Saturated(f32),
    /// The wire is open: no sensor is connected.
    Open,
}

impl Channel {
    /// The SI value of a code, N or m.
    #[inline]
    pub fn value(&self, code: AdcCode) -> f32 {
        (f32::from(code.0) - self.zero_code) * self.unit_per_code
    }

    /// The lowest and the highest value that can be measured, N or m: those next to the rails.
    pub fn reach(&self) -> (f32, f32) {
        let low = self.value(AdcCode(LOW_RAIL.0 + 1));
        let high = self.value(AdcCode(HIGH_RAIL.0 - 1));
        (low.min(high), low.max(high))
    }

    /// The value of a code, or that it is a rail or an open wire.
    #[inline]
    pub fn read(&self, code: AdcCode) -> Reading {
        if code <= OPEN_AT {
            Reading::Open
        } else if code <= LOW_RAIL || code >= HIGH_RAIL {
            Reading::Saturated(self.value(code))
        } else {
            Reading::Value(self.value(code))
        }
    }
}

/// The raw codes of one control tick, and the emergency-stop chain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Frame {
    /// Code of the contact force.
    pub force: AdcCode,
    /// Hammer displacement in the fixed frame, x.
    pub hammer: AdcCode,
    /// Cart displacement in the fixed frame, y.
    pub cart: AdcCode,
    /// Whether the emergency-stop chain is open (a normally closed contact: a broken wire stops, too).
    pub emergency: bool,
}

/// Set-points of one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Output {
    /// Position set-point of the shaker.
    pub dac: DacCode,
    /// Frequency set-point of a motor drive, Hz; 0 while the drive is off.
    pub frequency_hz: f32,
    /// The drive's enable line.
    pub enable: bool,
}

impl Output {
    /// Off: not enabled, middle of the travel, frequency 0.
    pub const SAFE: Self = Self {
        dac: DacCode::MIDDLE,
        frequency_hz: 0.0,
        enable: false,
    };
}

/// A normally closed emergency-stop chain on a digital input: the line is low while the chain is closed
/// and pulled high when it opens.
#[derive(Clone, Copy, Debug)]
pub struct NormallyClosed<P>(pub P);

impl<P: InputPin> NormallyClosed<P> {
    /// Whether the chain is open. A line that cannot be read counts as open.
    #[inline]
    pub fn is_open(&mut self) -> bool {
        self.0.is_high().unwrap_or(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_hal::digital::{ErrorKind, ErrorType};

    /// An input that reads a level, or fails.
    struct Pin(Result<bool, ErrorKind>);

    impl ErrorType for Pin {
        type Error = ErrorKind;
    }

    impl InputPin for Pin {
        fn is_high(&mut self) -> Result<bool, ErrorKind> {
            self.0
        }
        fn is_low(&mut self) -> Result<bool, ErrorKind> {
            self.0.map(|high| !high)
        }
    }

    #[test]
    fn a_chain_is_closed_only_while_its_line_reads_low() {
        assert!(!NormallyClosed(Pin(Ok(false))).is_open());
        assert!(NormallyClosed(Pin(Ok(true))).is_open());
        assert!(NormallyClosed(Pin(Err(ErrorKind::Other))).is_open());
    }

    #[test]
    fn rails_and_open_wires_are_no_values() {
        let channel = Channel {
            zero_code: 2048.0,
            unit_per_code: -0.5,
        };
        assert_eq!(channel.read(AdcCode(0)), Reading::Open);
        assert_eq!(channel.read(AdcCode(40)), Reading::Open);
        assert!(matches!(channel.read(AdcCode(41)), Reading::Saturated(f) if f > 1000.0));
        assert!(matches!(channel.read(AdcCode(4095)), Reading::Saturated(f) if f < -1000.0));
        assert_eq!(channel.read(AdcCode(2050)), Reading::Value(-1.0));
    }
}
