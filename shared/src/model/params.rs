//! The parameters of a rig, in SI units, and the presets of Tables 3.1 to 3.3.

use core::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use crate::model::cart::{CartDrive, LoopParams};
use crate::model::contact::{self, Law, TABLE_3_1};
pub use crate::model::number::ParamError;
use crate::model::number::{Allowed, Number, ensure};

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
        /// Wire length l, m.
        length_m: f64,
        /// Gravity g, m/s².
        gravity_m_per_s2: f64,
        /// ω/2π, Hz: what frequency ratios are relative to. Table 3.2 rounds √(g/l)/2π = 1.8202 to 1.82.
        natural_frequency_hz: f64,
        /// How the contact force turns the pendulum.
        torque: Torque,
    },
    /// Beam springs (3-30): k = mω², c = 2ζmω.
    Beams {
        /// Natural frequency ω/2π, Hz.
        natural_frequency_hz: f64,
        /// Damping ratio ζ of the beams.
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
    /// Contact law between hammer and impact surface, with its parameters.
    pub contact: Law<f64>,
    /// What moves the cart.
    pub cart: CartDrive,
}

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

    /// This rig with its natural frequency scaled: wires through their length, beams directly.
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

    /// This rig at a gap of `gap_mm`, mm.
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
        MASS.check(self.mass_kg)?;
        CART_MASS.check(self.cart_mass_kg)?;
        AMPLITUDE.check(self.amplitude_m)?;
        match self.support {
            SupportParams::Wires {
                length_m,
                gravity_m_per_s2,
                natural_frequency_hz,
                ..
            } => {
                WIRE_LENGTH.check(length_m)?;
                GRAVITY.check(gravity_m_per_s2)?;
                let derived = libm::sqrt(gravity_m_per_s2 / length_m) / TAU;
                ensure(
                    libm::fabs(natural_frequency_hz / derived - 1.0) <= 1e-3,
                    NATURAL_FREQUENCY.key,
                    natural_frequency_hz,
                    "within 0.1 % of what wire_length_mm and gravity_m_per_s2 give (leave one of them out)",
                )?;
                ensure(
                    libm::fabs(self.gap_m) <= 0.5 * length_m,
                    GAP.key,
                    self.gap_m * 1e3,
                    "a number of at most half the wire length, either sign",
                )?;
            }
            SupportParams::Beams {
                natural_frequency_hz,
                damping_ratio,
                cubic_stiffness_n_per_m3,
            } => {
                NATURAL_FREQUENCY.check(natural_frequency_hz)?;
                DAMPING_RATIO.check(damping_ratio)?;
                CUBIC_STIFFNESS.check(cubic_stiffness_n_per_m3.unwrap_or(0.0))?;
            }
        }
        GAP.check(self.gap_m)?;
        if let CartDrive::Loop(held) = &self.cart {
            check_loop(held)?;
        }
        self.contact.check()
    }
}

fn check_loop(held: &LoopParams) -> Result<(), ParamError> {
    LOOP_FREQUENCY.check(held.frequency_hz)?;
    LOOP_DAMPING_RATIO.check(held.damping_ratio)?;
    FEED_FORWARD.check(held.feed_forward)?;
    SHAKER_FORCE.check(held.max_force_n)
}

const POSITIVE_MASS: Allowed = Allowed(1e-6, 1e6, "a positive number from 1e-6 to 1e6");
const MASS: Number = Number::new("mass_kg", "hammer mass m", &POSITIVE_MASS);
const CART_MASS: Number = Number::new(
    "cart_mass_kg",
    "cart mass M (determines the shaker's force and the cart's recoil)",
    &POSITIVE_MASS,
);
const AMPLITUDE: Number = Number::new(
    "amplitude_mm",
    "cart amplitude A0",
    &Allowed(1e-6, 100.0, "a positive number from 1e-6 to 100"),
)
.in_mm();
const GAP: Number = Number::new(
    "gap_mm",
    "clearance at rest; negative: pressed on",
    &Allowed(-100.0, 100.0, "a number from -100 to 100"),
)
.in_mm();
const NATURAL_FREQUENCY: Number = Number::new(
    "natural_frequency_hz",
    "natural frequency; sets the wire length on wires",
    &Allowed(1e-6, 1e4, "a positive number from 1e-6 to 1e4"),
);
const WIRE_LENGTH: Number = Number::new(
    "wire_length_mm",
    "wire length l; sets the natural frequency",
    &Allowed(0.1, 1e5, "a positive number from 0.1 to 1e5"),
)
.in_mm();
const GRAVITY: Number = Number::new(
    "gravity_m_per_s2",
    "gravity g (wires)",
    &Allowed(1e-3, 1e3, "a positive number from 0.001 to 1000"),
);
const DAMPING_RATIO: Number = Number::new(
    "damping_ratio",
    "damping ratio of the beams",
    &Allowed(0.0, 1.0 - f64::EPSILON / 2.0, "a number from 0 to below 1"),
);
const CUBIC_STIFFNESS: Number = Number::new(
    "cubic_stiffness_n_per_m3",
    "cubic stiffness of the beams; left out: numerically k",
    &Allowed(0.0, 1e15, "a number from 0 to 1e15"),
);
const LOOP_FREQUENCY: Number = Number::new(
    "shaker_loop_hz",
    "natural frequency of the shaker's position loop with the cart alone; left out: the cart does not recoil",
    &Allowed(0.1, 1e4, "a number from 0.1 to 1e4"),
);
const LOOP_DAMPING_RATIO: Number = Number::new(
    "shaker_damping_ratio",
    "damping ratio of that loop",
    &Allowed(0.0, 100.0, "a number from 0 to 100"),
);
const FEED_FORWARD: Number = Number::new(
    "shaker_feed_forward",
    "share of the force on the cart's mass that the shaker feeds forward",
    &Allowed(0.0, 2.0, "a number from 0 to 2"),
);
const SHAKER_FORCE: Number = Number::new(
    "shaker_max_force_n",
    "largest force that the shaker can give",
    &Allowed(1e-3, 1e9, "a number from 0.001 to 1e9"),
);

impl RigParams {
    /// The numbers that every rig has.
    pub const OWN_NUMBERS: [Number; 4] = [MASS, CART_MASS, AMPLITUDE, GAP];

    /// The numbers that a rig may have, in the order of a rig file.
    pub fn numbers() -> impl Iterator<Item = Number> {
        let support = [
            NATURAL_FREQUENCY,
            WIRE_LENGTH,
            GRAVITY,
            DAMPING_RATIO,
            CUBIC_STIFFNESS,
        ];
        let shaker = [
            LOOP_FREQUENCY,
            LOOP_DAMPING_RATIO,
            FEED_FORWARD,
            SHAKER_FORCE,
        ];
        let all = Self::OWN_NUMBERS.into_iter().chain(support);
        all.chain(contact::NUMBERS).chain(shaker)
    }

    /// Where the number called `key` stands, in SI units. None if there is none, or such a rig has none.
    pub fn number_mut(&mut self, key: &str) -> Option<&mut f64> {
        let held = match &mut self.cart {
            CartDrive::Loop(held) => Some(held),
            CartDrive::Prescribed => None,
        };
        let is = |number: Number| number.key == key;
        match &mut self.support {
            SupportParams::Wires {
                natural_frequency_hz: hz,
                ..
            }
            | SupportParams::Beams {
                natural_frequency_hz: hz,
                ..
            } if is(NATURAL_FREQUENCY) => return Some(hz),
            SupportParams::Wires { length_m, .. } if is(WIRE_LENGTH) => return Some(length_m),
            SupportParams::Wires {
                gravity_m_per_s2: g,
                ..
            } if is(GRAVITY) => return Some(g),
            SupportParams::Beams { damping_ratio, .. } if is(DAMPING_RATIO) => {
                return Some(damping_ratio);
            }
            SupportParams::Beams {
                cubic_stiffness_n_per_m3: cubic,
                ..
            } if is(CUBIC_STIFFNESS) => return cubic.as_mut(),
            _ => {}
        }
        match held {
            Some(held) if is(LOOP_FREQUENCY) => Some(&mut held.frequency_hz),
            Some(held) if is(LOOP_DAMPING_RATIO) => Some(&mut held.damping_ratio),
            Some(held) if is(FEED_FORWARD) => Some(&mut held.feed_forward),
            Some(held) if is(SHAKER_FORCE) => Some(&mut held.max_force_n),
            _ if is(MASS) => Some(&mut self.mass_kg),
            _ if is(CART_MASS) => Some(&mut self.cart_mass_kg),
            _ if is(AMPLITUDE) => Some(&mut self.amplitude_m),
            _ if is(GAP) => Some(&mut self.gap_m),
            _ => self.contact.number_mut(key),
        }
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
            for (_, contact) in contact::LAWS {
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
