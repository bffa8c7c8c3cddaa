//! The two parameters of a plane, and the rig and drive at each of its points.

use shared::model::params::RigParams;

use crate::continuation::FamilyDrive;
use crate::knob::Knob;

/// What a parameter is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Varied {
    /// Drive frequency over the natural frequency, Ω/ω.
    Ratio,
    /// The drive frequency, Hz.
    Frequency,
    /// A number of the rig.
    Rig(Knob),
}

impl Varied {
    /// Its name, with its unit.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ratio => "frequency_ratio",
            Self::Frequency => "frequency_hz",
            Self::Rig(knob) => knob.name(),
        }
    }

    /// Whether it is the drive's.
    pub fn drives(self) -> bool {
        !matches!(self, Self::Rig(_))
    }
}

/// How a parameter is measured along a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// By its value, one being this much of it.
    Even(f64),
    /// By its natural logarithm, one being this much of it.
    Log(f64),
}

/// One parameter with its range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dimension {
    /// Which number of the drive or of the rig it is.
    pub varied: Varied,
    /// From and to, in its unit.
    pub range: (f64, f64),
    /// How it is measured.
    pub scale: Scale,
}

/// How long a range is along a curve that has no unit of its own: about as long as three of Ω/ω.
const RANGE: f64 = 3.0;

impl Dimension {
    /// `varied` from `range.0` to `range.1`, even or by factors. Ω/ω and gap are measured in their own units.
    pub fn new(varied: Varied, range: (f64, f64), by_factors: bool, params: &RigParams) -> Self {
        let (from, to) = range;
        let gap = Knob::named("gap_mm").map(Varied::Rig);
        let scale = if by_factors {
            Scale::Log((to / from).ln() / RANGE)
        } else {
            Scale::Even(match varied {
                Varied::Ratio => 1.0,
                Varied::Frequency => params.natural_frequency_hz(),
                _ if Some(varied) == gap => params.amplitude_m * 1e3,
                Varied::Rig(_) => (to - from) / RANGE,
            })
        };
        Self {
            varied,
            range,
            scale,
        }
    }

    /// The value at a place along a curve.
    pub fn value(&self, place: f64) -> f64 {
        match self.scale {
            Scale::Even(unit) => unit * place,
            Scale::Log(unit) => (unit * place).exp(),
        }
    }

    /// The place of a value.
    pub fn place(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Even(unit) => value / unit,
            Scale::Log(unit) => value.ln() / unit,
        }
    }

    /// The places of both ends of the range.
    pub fn limits(&self) -> (f64, f64) {
        (self.place(self.range.0), self.place(self.range.1))
    }

    /// `count` values over the range, both ends among them; one: the middle.
    pub fn spread(&self, count: usize) -> Vec<f64> {
        let (from, to) = self.limits();
        if count < 2 {
            return vec![self.value(0.5 * (from + to))];
        }
        let at = |i: usize| match i {
            0 => self.range.0,
            i if i == count - 1 => self.range.1,
            i => self.value(from + (to - from) * i as f64 / (count - 1) as f64),
        };
        (0..count).map(at).collect()
    }
}

/// A rig over two parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// The rig; what is varied of it is not used.
    pub params: RigParams,
    /// The drive, where neither parameter is the drive's.
    pub drive: FamilyDrive,
    /// The parameters: the one of the one-parameter curves, and the other.
    pub dimensions: [Dimension; 2],
}

impl Plane {
    /// The rig and drive frequency (Hz) at two values. None if the rig has no such number.
    pub fn at(&self, values: [f64; 2]) -> Option<(RigParams, f64)> {
        let mut params = self.params;
        let mut drive = self.drive;
        for (dimension, value) in self.dimensions.iter().zip(values) {
            match dimension.varied {
                Varied::Ratio => drive = FamilyDrive::Ratio(value),
                Varied::Frequency => drive = FamilyDrive::Hz(value),
                Varied::Rig(knob) => params = knob.set(&params, value)?,
            }
        }
        Some((params, drive.hz(&params)))
    }

    /// Values, rig and drive frequency (Hz) at two places along a curve. None if one of them is out of range.
    pub fn at_places(&self, places: [f64; 2]) -> Option<([f64; 2], RigParams, f64)> {
        let values = [0, 1].map(|i| self.dimensions[i].value(places[i]));
        let (params, frequency_hz) = self.at(values)?;
        let sound = frequency_hz > 0.0 && frequency_hz.is_finite() && params.check().is_ok();
        sound.then_some((values, params, frequency_hz))
    }
}
