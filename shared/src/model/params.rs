//! The parameters of a rig, in SI units, and the presets of Tables 3.1 to 3.3.

use core::f64::consts::TAU;
use core::mem::discriminant;

use serde::{Deserialize, Serialize};

use crate::model::cart::{CartDrive, LoopParams};
use crate::model::contact::Law;

/// Standard gravity as the chapter uses it, m/s².
pub const GRAVITY_M_PER_S2: f64 = 9.81;

/// How the contact force turns the pendulum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Torque {
    /// F l, as equation 3-16 prints it: the chapter's results are computed with this.
    #[default]
    Literal,
    /// F l cos θ, the moment of a horizontal force.
    Cosine,
}

/// What the hammer hangs on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum SupportParams {
    /// Wires: a pendulum (3-15). Its dynamics use g/l.
    Wires {
        /// l, m.
        length_m: f64,
        /// g, m/s².
        gravity_m_per_s2: f64,
        /// ω/2π, Hz: what frequency ratios are relative to. Table 3.2 rounds √(g/l)/2π = 1.8202 to 1.82.
        natural_frequency_hz: f64,
        /// How the contact force turns the pendulum.
        torque: Torque,
    },
    /// Beam springs (3-30): k = mω², c = 2ζmω.
    Beams {
        /// ω/2π, Hz.
        natural_frequency_hz: f64,
        /// ζ.
        damping_ratio: f64,
        /// κ, N/m³; `None`: numerically k, as the chapter writes it.
        cubic_stiffness_n_per_m3: Option<f64>,
    },
}

/// Every parameter of a rig.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RigParams {
    /// What the hammer hangs on.
    pub support: SupportParams,
    /// Hammer mass m, kg.
    pub mass_kg: f64,
    /// Cart mass M, kg. A prescribed cart does not use it; what the shaker must give does, and a cart that recoils.
    pub cart_mass_kg: f64,
    /// Cart amplitude A0, m.
    pub amplitude_m: f64,
    /// Clearance at rest, m. Negative: the hammer rests pressed against the surface.
    pub gap_m: f64,
    /// The contact law.
    pub contact: Law<f64>,
    /// What moves the cart.
    pub cart: CartDrive,
}

/// A parameter out of range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParamError {
    /// Which parameter, with its unit, as the command line and rig files name it.
    pub key: &'static str,
    /// What it was, in the unit of `key`.
    pub value: f64,
    /// What it must be.
    pub must_be: &'static str,
}

impl core::fmt::Display for ParamError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self {
            key,
            value,
            must_be,
        } = self;
        let size = value.abs();
        if size != 0.0 && !(1e-4..1e7).contains(&size) {
            // Without hundreds of digits.
            write!(f, "{key} is {value:e}, must be {must_be}")
        } else {
            write!(f, "{key} is {value}, must be {must_be}")
        }
    }
}

impl core::error::Error for ParamError {}

/// The spring-dashpot of Table 3.1.
pub const TABLE_3_1: Law<f64> = Law::SpringDashpot {
    stiffness: 5.5e6,
    damping: 1.2e3,
};

const fn rig(support: SupportParams) -> RigParams {
    RigParams {
        support,
        mass_kg: 0.298,
        cart_mass_kg: 5.38,
        amplitude_m: 0.89 / 1e3,
        gap_m: 0.0,
        contact: TABLE_3_1,
        cart: CartDrive::Prescribed,
    }
}

const fn beams(natural_frequency_hz: f64) -> RigParams {
    rig(SupportParams::Beams {
        natural_frequency_hz,
        damping_ratio: 0.004,
        cubic_stiffness_n_per_m3: None,
    })
}

/// The hammer on wires (Tables 3.1 and 3.2).
pub const WIRES: RigParams = rig(SupportParams::Wires {
    length_m: 0.075,
    gravity_m_per_s2: GRAVITY_M_PER_S2,
    natural_frequency_hz: 1.82,
    torque: Torque::Literal,
});
/// Beam springs, couplings 170 mm apart (Tables 3.1 and 3.3).
pub const BEAM_170: RigParams = beams(4.50);
/// Beam springs, couplings 150 mm apart (Tables 3.1 and 3.3).
pub const BEAM_150: RigParams = beams(5.25);
/// Beam springs, couplings 135 mm apart (Tables 3.1 and 3.3).
pub const BEAM_135: RigParams = beams(6.50);

/// The presets by name.
pub const PRESETS: [(&str, RigParams); 4] = [
    ("wires", WIRES),
    ("beam-170", BEAM_170),
    ("beam-150", BEAM_150),
    ("beam-135", BEAM_135),
];

/// The contact laws by name, each with parameters that make the contact of Table 3.1 (0.570751 ms and
/// restitution 0.316902 at 0.08 m/s, 0.298 kg against a fixed wall) as far as the law can: Table 3.1's ki
/// is in N/m and fits the spring-dashpot alone. All last as long. Hunt–Crossley also rebounds as much;
/// Hertz loses nothing (restitution 1); Lankarani–Nikravesh rebounds at 0.662962 even at e = 0, its
/// lowest. A test in host-sim solves them anew.
pub const LAWS: [(&str, Law<f64>); 4] = [
    ("spring-dashpot", TABLE_3_1),
    (
        "hertz",
        Law::Hertz {
            stiffness: 2.515_020e9,
            exponent: 1.5,
        },
    ),
    (
        "hunt-crossley",
        Law::HuntCrossley {
            stiffness: 4.520_403e9,
            exponent: 1.5,
            damping_ratio: 35.993_66,
        },
    ),
    (
        "lankarani-nikravesh",
        Law::LankaraniNikravesh {
            stiffness: 2.897_038e9,
            exponent: 1.5,
            restitution: 0.0,
        },
    ),
];

/// The name of a contact law: that of its kind in [`LAWS`].
pub fn law_name(law: &Law<f64>) -> &'static str {
    let same = |known: &Law<f64>| discriminant(known) == discriminant(law);
    let found = LAWS.iter().find(|(_, known)| same(known));
    found.map_or("", |(name, _)| name)
}

/// The preset called `name`.
pub fn preset(name: &str) -> Option<RigParams> {
    let found = PRESETS.iter().find(|(n, _)| *n == name);
    found.map(|(_, params)| *params)
}

impl RigParams {
    /// The mass that a contact turns round, kg: the hammer's, and where the cart recoils that of both against each other.
    // One copy of it in the image is enough.
    #[inline(never)]
    pub fn contact_mass_kg(&self) -> f64 {
        if self.cart.recoils() {
            self.mass_kg / (1.0 + self.mass_kg / self.cart_mass_kg)
        } else {
            self.mass_kg
        }
    }

    /// ω/2π, Hz: what frequency ratios are relative to.
    pub fn natural_frequency_hz(&self) -> f64 {
        match self.support {
            SupportParams::Wires {
                natural_frequency_hz,
                ..
            }
            | SupportParams::Beams {
                natural_frequency_hz,
                ..
            } => natural_frequency_hz,
        }
    }

    /// m g, N: what force ratios are relative to.
    pub fn weight_n(&self) -> f64 {
        let gravity = match self.support {
            SupportParams::Wires {
                gravity_m_per_s2, ..
            } => gravity_m_per_s2,
            SupportParams::Beams { .. } => GRAVITY_M_PER_S2,
        };
        self.mass_kg * gravity
    }

    /// The same rig with its natural frequency scaled: wires through their length, beams directly.
    #[must_use]
    pub fn with_natural_frequency_scaled(mut self, factor: f64) -> Self {
        match &mut self.support {
            SupportParams::Wires {
                length_m,
                natural_frequency_hz,
                ..
            } => {
                *length_m /= factor * factor;
                *natural_frequency_hz *= factor;
            }
            SupportParams::Beams {
                natural_frequency_hz,
                ..
            } => *natural_frequency_hz *= factor,
        }
        self
    }

    /// The same rig at a gap of `gap_mm`, mm.
    ///
    /// # Errors
    /// If any parameter is out of range.
    pub fn with_gap_mm(mut self, gap_mm: f64) -> Result<Self, ParamError> {
        self.gap_m = gap_mm / 1e3;
        self.check()?;
        Ok(self)
    }

    /// Checks every parameter.
    ///
    /// # Errors
    /// If a parameter is out of range: the first such.
    pub fn check(&self) -> Result<(), ParamError> {
        within("mass_kg", self.mass_kg, &MASS_KG)?;
        within("cart_mass_kg", self.cart_mass_kg, &MASS_KG)?;
        within("amplitude_mm", self.amplitude_m * 1e3, &AMPLITUDE_MM)?;
        match self.support {
            SupportParams::Wires {
                length_m,
                gravity_m_per_s2,
                natural_frequency_hz,
                ..
            } => {
                within("wire_length_mm", length_m * 1e3, &WIRE_LENGTH_MM)?;
                within("gravity_m_per_s2", gravity_m_per_s2, &GRAVITY)?;
                let derived = libm::sqrt(gravity_m_per_s2 / length_m) / TAU;
                ensure(
                    libm::fabs(natural_frequency_hz / derived - 1.0) <= 1e-3,
                    "natural_frequency_hz",
                    natural_frequency_hz,
                    "within 0.1 % of what wire_length_mm and gravity_m_per_s2 give (leave one of them out)",
                )?;
                ensure(
                    libm::fabs(self.gap_m) <= 0.5 * length_m,
                    "gap_mm",
                    self.gap_m * 1e3,
                    "a number of at most half the wire length, either sign",
                )?;
            }
            SupportParams::Beams {
                natural_frequency_hz,
                damping_ratio,
                cubic_stiffness_n_per_m3,
            } => {
                within(
                    "natural_frequency_hz",
                    natural_frequency_hz,
                    &NATURAL_FREQUENCY_HZ,
                )?;
                let below_one = "a number from 0 to below 1";
                ensure(
                    (0.0..1.0).contains(&damping_ratio),
                    "damping_ratio",
                    damping_ratio,
                    below_one,
                )?;
                let cubic = cubic_stiffness_n_per_m3.unwrap_or(0.0);
                within("cubic_stiffness_n_per_m3", cubic, &CUBIC_STIFFNESS)?;
            }
        }
        ensure(
            libm::fabs(self.gap_m) <= 0.1,
            "gap_mm",
            self.gap_m * 1e3,
            "a number from -100 to 100",
        )?;
        if let CartDrive::Loop(held) = &self.cart {
            check_loop(held)?;
        }
        check_law(&self.contact)
    }
}

fn check_loop(held: &LoopParams) -> Result<(), ParamError> {
    within("shaker_loop_hz", held.frequency_hz, &LOOP_HZ)?;
    within("shaker_damping_ratio", held.damping_ratio, &LOOP_DAMPING)?;
    within("shaker_feed_forward", held.feed_forward, &FEED_FORWARD)?;
    within("shaker_max_force_n", held.max_force_n, &SHAKER_FORCE)
}

fn check_law(law: &Law<f64>) -> Result<(), ParamError> {
    within(
        "contact_stiffness_n_per_m",
        law.stiffness(),
        &CONTACT_STIFFNESS,
    )?;
    if let Law::SpringDashpot { damping, .. } = *law {
        return within("contact_damping_n_s_per_m", damping, &CONTACT_DAMPING);
    }
    within("contact_exponent", law.exponent(), &CONTACT_EXPONENT)?;
    match *law {
        Law::HuntCrossley { damping_ratio, .. } => within(
            "contact_damping_ratio_s_per_m",
            damping_ratio,
            &CONTACT_DAMPING_RATIO,
        ),
        Law::LankaraniNikravesh { restitution, .. } => {
            within("contact_restitution", restitution, &RESTITUTION)
        }
        Law::Hertz { .. } | Law::SpringDashpot { .. } => Ok(()),
    }
}

/// Range of a parameter: lowest, highest, and the range in words. It is far wider than any rig; beyond it the
/// arithmetic overflows.
pub(super) struct Allowed(pub(super) f64, pub(super) f64, pub(super) &'static str);

const MASS_KG: Allowed = Allowed(1e-6, 1e6, "a positive number from 1e-6 to 1e6");
const AMPLITUDE_MM: Allowed = Allowed(1e-6, 100.0, "a positive number from 1e-6 to 100");
const WIRE_LENGTH_MM: Allowed = Allowed(0.1, 1e5, "a positive number from 0.1 to 1e5");
const GRAVITY: Allowed = Allowed(1e-3, 1e3, "a positive number from 0.001 to 1000");
const NATURAL_FREQUENCY_HZ: Allowed = Allowed(1e-6, 1e4, "a positive number from 1e-6 to 1e4");
const LOOP_HZ: Allowed = Allowed(0.1, 1e4, "a number from 0.1 to 1e4");
const LOOP_DAMPING: Allowed = Allowed(0.0, 100.0, "a number from 0 to 100");
const FEED_FORWARD: Allowed = Allowed(0.0, 2.0, "a number from 0 to 2");
const SHAKER_FORCE: Allowed = Allowed(1e-3, 1e9, "a number from 0.001 to 1e9");
const CUBIC_STIFFNESS: Allowed = Allowed(0.0, 1e15, "a number from 0 to 1e15");
const CONTACT_STIFFNESS: Allowed = Allowed(1e-3, 1e18, "a positive number from 0.001 to 1e18");
const CONTACT_DAMPING: Allowed = Allowed(0.0, 1e12, "a number from 0 to 1e12");
const CONTACT_EXPONENT: Allowed = Allowed(1.0, 4.0, "a number from 1 to 4");
const CONTACT_DAMPING_RATIO: Allowed = Allowed(0.0, 1e6, "a number from 0 to 1e6");
const RESTITUTION: Allowed = Allowed(0.0, 1.0, "a number from 0 to 1");

pub(super) fn within(key: &'static str, value: f64, allowed: &Allowed) -> Result<(), ParamError> {
    let Allowed(from, to, must_be) = *allowed;
    ensure((from..=to).contains(&value), key, value, must_be)
}

fn ensure(
    holds: bool,
    key: &'static str,
    value: f64,
    must_be: &'static str,
) -> Result<(), ParamError> {
    if holds {
        Ok(())
    } else {
        Err(ParamError {
            key,
            value,
            must_be,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_valid_and_found_by_name() {
        for (name, params) in PRESETS {
            assert_eq!(params.check(), Ok(()), "{name}");
            assert_eq!(preset(name), Some(params));
            for (_, contact) in LAWS {
                assert_eq!(RigParams { contact, ..params }.check(), Ok(()));
            }
        }
        assert_eq!(preset("rope"), None);
    }

    #[test]
    fn bad_parameters_are_named() {
        let key = |params: RigParams| params.check().unwrap_err().key;
        assert_eq!(
            key(RigParams {
                mass_kg: -1.0,
                ..WIRES
            }),
            "mass_kg"
        );
        assert_eq!(
            key(RigParams {
                mass_kg: f64::NAN,
                ..WIRES
            }),
            "mass_kg"
        );
        assert_eq!(
            key(RigParams {
                gap_m: f64::INFINITY,
                ..BEAM_170
            }),
            "gap_mm"
        );
        for amplitude_m in [0.0, 1e-300, 0.2] {
            assert_eq!(
                key(RigParams {
                    amplitude_m,
                    ..WIRES
                }),
                "amplitude_mm"
            );
        }
        let heavy = RigParams {
            mass_kg: 1e300,
            ..WIRES
        };
        assert_eq!(
            std::format!("{}", heavy.check().unwrap_err()),
            "mass_kg is 1e300, must be a positive number from 1e-6 to 1e6"
        );
        let contact = Law::SpringDashpot {
            stiffness: 5.5e6,
            damping: -1.0,
        };
        assert_eq!(
            key(RigParams { contact, ..WIRES }),
            "contact_damping_n_s_per_m"
        );
    }

    #[test]
    fn scaling_the_natural_frequency_of_wires_goes_through_their_length() {
        let scaled = WIRES.with_natural_frequency_scaled(1.02);
        assert_eq!(scaled.check(), Ok(()));
        let SupportParams::Wires { length_m, .. } = scaled.support else {
            panic!("wires stay wires");
        };
        assert!((length_m - 0.075 / 1.0404).abs() < 1e-12);
    }
}
