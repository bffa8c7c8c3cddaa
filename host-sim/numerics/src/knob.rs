//! One number of a rig, by the name that rig files give it: to follow something over any of them.

use std::f64::consts::TAU;

use shared::model::cart::UNLIMITED_N;
use shared::model::number::Number;
use shared::model::params::{RigParams, SupportParams};

/// A number of a rig that can be varied. What it decides for others follows it: the length of the wires decides their
/// natural frequency, and their natural frequency their length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knob(Number);

impl Knob {
    /// All of them, in the order of a rig file.
    pub fn all() -> impl Iterator<Item = Self> {
        RigParams::numbers().map(Self)
    }

    /// The number called `name`; none if there is none.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().find(|knob| knob.name() == name)
    }

    /// Its name, with its unit.
    pub fn name(self) -> &'static str {
        self.0.key
    }

    /// This number of `params`, in the unit of its name. None if such a rig has no such number, or a shaker no such limit.
    pub fn of(self, params: &RigParams) -> Option<f64> {
        let mut rig = *params;
        let value = rig.number_mut(self.name())?;
        let limitless = self.name() == "shaker_max_force_n" && *value >= UNLIMITED_N;
        (!limitless).then(|| in_units(*value, self.0.per_si_unit))
    }

    /// `params` with `value` for this number, in the unit of its name, unchecked. None if such a rig has no such number.
    pub fn set(self, params: &RigParams, value: f64) -> Option<RigParams> {
        let mut rig = *params;
        if let SupportParams::Beams {
            cubic_stiffness_n_per_m3: cubic @ None,
            ..
        } = &mut rig.support
            && self.name() == "cubic_stiffness_n_per_m3"
        {
            *cubic = Some(value);
        }
        *rig.number_mut(self.name())? = value / self.0.per_si_unit;
        if let SupportParams::Wires {
            length_m,
            gravity_m_per_s2,
            natural_frequency_hz,
            ..
        } = &mut rig.support
        {
            match self.name() {
                "natural_frequency_hz" => *length_m = *gravity_m_per_s2 / (TAU * value).powi(2),
                "wire_length_mm" | "gravity_m_per_s2" => {
                    *natural_frequency_hz = (*gravity_m_per_s2 / *length_m).sqrt() / TAU;
                }
                _ => {}
            }
        }
        Some(rig)
    }
}

/// `value` in a unit of which one of its own has `per_unit`, without the last-digit noise of a multiplication.
fn in_units(value: f64, per_unit: f64) -> f64 {
    let converted = value * per_unit;
    let tidy = (converted * 1e9).round() / 1e9;
    if per_unit != 1.0 && (tidy - converted).abs() <= 1e-12 * converted.abs() {
        tidy
    } else {
        converted
    }
}
