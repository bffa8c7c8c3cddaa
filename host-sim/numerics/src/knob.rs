//! One number of a rig, by the name that rig files give it: to follow something over any of them.

use std::f64::consts::TAU;

use shared::model::cart::{CartDrive, UNLIMITED_N};
use shared::model::contact::Law;
use shared::model::params::{RigParams, SupportParams};

/// A number of a rig that can be varied. What it decides for others follows it: the length of the wires decides their
/// natural frequency, and their natural frequency their length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Knob(&'static str);

/// The names, as rig files have them.
pub const KNOBS: [&str; 18] = [
    "mass_kg",
    "cart_mass_kg",
    "amplitude_mm",
    "gap_mm",
    "natural_frequency_hz",
    "wire_length_mm",
    "gravity_m_per_s2",
    "damping_ratio",
    "cubic_stiffness_n_per_m3",
    "contact_stiffness_n_per_m",
    "contact_damping_n_s_per_m",
    "contact_exponent",
    "contact_damping_ratio_s_per_m",
    "contact_restitution",
    "shaker_loop_hz",
    "shaker_damping_ratio",
    "shaker_feed_forward",
    "shaker_max_force_n",
];

impl Knob {
    /// All of them, in the order of [`KNOBS`].
    pub fn all() -> impl Iterator<Item = Self> {
        KNOBS.iter().map(|name| Self(name))
    }

    /// The number called `name`; none if there is none.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().find(|knob| knob.0 == name)
    }

    /// Its name, with its unit.
    pub fn name(self) -> &'static str {
        self.0
    }

    /// This number of `params`, in the unit of its name. None if such a rig has no such number, or a shaker no such limit.
    pub fn of(self, params: &RigParams) -> Option<f64> {
        let mut rig = *params;
        let (value, per_unit) = slot(&mut rig, self.0)?;
        let limitless = self.0 == "shaker_max_force_n" && *value >= UNLIMITED_N;
        (!limitless).then(|| in_units(*value, per_unit))
    }

    /// `params` with `value` for this number, in the unit of its name, unchecked. None if such a rig has no such number.
    pub fn set(self, params: &RigParams, value: f64) -> Option<RigParams> {
        let mut rig = *params;
        if let SupportParams::Beams {
            cubic_stiffness_n_per_m3: cubic @ None,
            ..
        } = &mut rig.support
            && self.0 == "cubic_stiffness_n_per_m3"
        {
            *cubic = Some(value);
        }
        let (place, per_unit) = slot(&mut rig, self.0)?;
        *place = value / per_unit;
        if let SupportParams::Wires {
            length_m,
            gravity_m_per_s2,
            natural_frequency_hz,
            ..
        } = &mut rig.support
        {
            match self.0 {
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

/// Where the number called `name` stands in a rig, and how many of its units one of the rig's is.
fn slot<'a>(rig: &'a mut RigParams, name: &str) -> Option<(&'a mut f64, f64)> {
    let place = match name {
        "mass_kg" => &mut rig.mass_kg,
        "cart_mass_kg" => &mut rig.cart_mass_kg,
        "amplitude_mm" => return Some((&mut rig.amplitude_m, 1e3)),
        "gap_mm" => return Some((&mut rig.gap_m, 1e3)),
        name if name.starts_with("contact_") => contact(&mut rig.contact, name)?,
        name if name.starts_with("shaker_") => {
            let CartDrive::Loop(held) = &mut rig.cart else {
                return None;
            };
            match name {
                "shaker_loop_hz" => &mut held.frequency_hz,
                "shaker_damping_ratio" => &mut held.damping_ratio,
                "shaker_feed_forward" => &mut held.feed_forward,
                _ => &mut held.max_force_n,
            }
        }
        name => return support(&mut rig.support, name),
    };
    Some((place, 1.0))
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

fn contact<'a>(law: &'a mut Law<f64>, name: &str) -> Option<&'a mut f64> {
    match (law, name) {
        (
            Law::SpringDashpot { stiffness, .. }
            | Law::Hertz { stiffness, .. }
            | Law::HuntCrossley { stiffness, .. }
            | Law::LankaraniNikravesh { stiffness, .. },
            "contact_stiffness_n_per_m",
        ) => Some(stiffness),
        (Law::SpringDashpot { damping, .. }, "contact_damping_n_s_per_m") => Some(damping),
        (
            Law::Hertz { exponent, .. }
            | Law::HuntCrossley { exponent, .. }
            | Law::LankaraniNikravesh { exponent, .. },
            "contact_exponent",
        ) => Some(exponent),
        (Law::HuntCrossley { damping_ratio, .. }, "contact_damping_ratio_s_per_m") => {
            Some(damping_ratio)
        }
        (Law::LankaraniNikravesh { restitution, .. }, "contact_restitution") => Some(restitution),
        _ => None,
    }
}

fn support<'a>(support: &'a mut SupportParams, name: &str) -> Option<(&'a mut f64, f64)> {
    match (support, name) {
        (
            SupportParams::Wires {
                natural_frequency_hz,
                ..
            }
            | SupportParams::Beams {
                natural_frequency_hz,
                ..
            },
            "natural_frequency_hz",
        ) => Some((natural_frequency_hz, 1.0)),
        (SupportParams::Wires { length_m, .. }, "wire_length_mm") => Some((length_m, 1e3)),
        (
            SupportParams::Wires {
                gravity_m_per_s2, ..
            },
            "gravity_m_per_s2",
        ) => Some((gravity_m_per_s2, 1.0)),
        (SupportParams::Beams { damping_ratio, .. }, "damping_ratio") => Some((damping_ratio, 1.0)),
        (
            SupportParams::Beams {
                cubic_stiffness_n_per_m3,
                ..
            },
            "cubic_stiffness_n_per_m3",
        ) => Some((cubic_stiffness_n_per_m3.as_mut()?, 1.0)),
        _ => None,
    }
}
