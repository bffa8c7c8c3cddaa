//! One number of a rig, by the name that rig files give it: to follow something over any of them.

use std::f64::consts::TAU;

use shared::model::cart::CartDrive;
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
    /// The number called `name`; none if there is none.
    pub fn named(name: &str) -> Option<Self> {
        let found = KNOBS.iter().find(|known| **known == name);
        found.map(|known| Self(known))
    }

    /// Its name, with its unit.
    pub fn name(self) -> &'static str {
        self.0
    }

    /// `params` with `value` for this number, in the unit of its name, unchecked. None if such a rig has no such number.
    pub fn set(self, params: &RigParams, value: f64) -> Option<RigParams> {
        let mut rig = *params;
        match self.0 {
            "mass_kg" => rig.mass_kg = value,
            "cart_mass_kg" => rig.cart_mass_kg = value,
            "amplitude_mm" => rig.amplitude_m = value / 1e3,
            "gap_mm" => rig.gap_m = value / 1e3,
            name if name.starts_with("contact_") => {
                *contact(&mut rig.contact, name)? = value;
            }
            name if name.starts_with("shaker_") => {
                let CartDrive::Loop(held) = &mut rig.cart else {
                    return None;
                };
                *match name {
                    "shaker_loop_hz" => &mut held.frequency_hz,
                    "shaker_damping_ratio" => &mut held.damping_ratio,
                    "shaker_feed_forward" => &mut held.feed_forward,
                    _ => &mut held.max_force_n,
                } = value;
            }
            name => support(&mut rig.support, name, value)?,
        }
        Some(rig)
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

fn support(support: &mut SupportParams, name: &str, value: f64) -> Option<()> {
    match support {
        SupportParams::Wires {
            length_m,
            gravity_m_per_s2,
            natural_frequency_hz,
            ..
        } => match name {
            "natural_frequency_hz" => {
                *natural_frequency_hz = value;
                *length_m = *gravity_m_per_s2 / (TAU * value).powi(2);
            }
            "wire_length_mm" => {
                *length_m = value / 1e3;
                *natural_frequency_hz = (*gravity_m_per_s2 / *length_m).sqrt() / TAU;
            }
            "gravity_m_per_s2" => {
                *gravity_m_per_s2 = value;
                *natural_frequency_hz = (value / *length_m).sqrt() / TAU;
            }
            _ => return None,
        },
        SupportParams::Beams {
            natural_frequency_hz,
            damping_ratio,
            cubic_stiffness_n_per_m3,
        } => match name {
            "natural_frequency_hz" => *natural_frequency_hz = value,
            "damping_ratio" => *damping_ratio = value,
            "cubic_stiffness_n_per_m3" => *cubic_stiffness_n_per_m3 = Some(value),
            _ => return None,
        },
    }
    Some(())
}
