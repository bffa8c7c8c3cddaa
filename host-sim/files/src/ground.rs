//! Ground that gives way, and a bit on it, as they are asked for: what is left out is the rig's own contact.

use numerics::NamedRig;
use numerics::drill::{Feed, GroundUncertainty};
use serde::Serialize;
use shared::model::bit::Bit;
use shared::model::contact::Law;
use shared::model::slider::Slider;

use crate::UserError;
use crate::range::below;

/// Fastest feed that may be asked for, mm/s.
const FASTEST_MM_PER_S: f64 = 1000.0;

/// What is asked for. Errors name the command line's options.
#[derive(Clone, Copy, Debug, Default)]
pub struct GroundAsked {
    /// Contact force at which the ground gives way, N.
    pub threshold_n: Option<f64>,
    /// Stiffness of the ground, N/m.
    pub ground_stiffness_n_per_m: Option<f64>,
    /// Damping of the ground, N·s/m.
    pub ground_damping_n_s_per_m: Option<f64>,
    /// Uncertainty of the threshold, % either way.
    pub threshold_percent: f64,
    /// Uncertainty of the ground's stiffness, % either way.
    pub ground_stiffness_percent: f64,
    /// Mass of a bit between hammer and ground, kg.
    pub bit_mass_kg: Option<f64>,
    /// Stiffness of the hammer's contact with the bit, N/m.
    pub bit_stiffness_n_per_m: Option<f64>,
    /// Damping of that contact, N·s/m.
    pub bit_damping_n_s_per_m: Option<f64>,
    /// Static force that presses the bit on the ground, N; its weight, if none is given.
    pub bit_feed_force_n: Option<f64>,
}

impl GroundAsked {
    /// The ground on which `rig` drills.
    ///
    /// # Errors
    /// If there is no threshold, or a value is out of range, or one that the rig's contact does not have is left out.
    pub fn ground(&self, rig: &NamedRig) -> Result<Slider<f64>, UserError> {
        let Some(threshold) = self.threshold_n else {
            return Err(UserError::new(
                "give --threshold-n, the contact force in N at which the ground gives way",
            ));
        };
        let own = own(rig);
        let missing = |option: &str| needed(rig, "ground", option);
        let stiffness = self.ground_stiffness_n_per_m.or(own.map(|o| o.0));
        let damping = self.ground_damping_n_s_per_m.or(own.map(|o| o.1));
        let ground = Slider {
            stiffness: stiffness.ok_or_else(|| missing("--ground-stiffness-n-per-m"))?,
            damping: damping.ok_or_else(|| missing("--ground-damping-n-s-per-m"))?,
            threshold,
        };
        ground.check().map_err(numerics::Error::from)?;
        Ok(ground)
    }

    /// The options of a bit beside its mass.
    pub fn about_the_bit(&self) -> [(&'static str, Option<f64>); 3] {
        [
            ("--bit-stiffness-n-per-m", self.bit_stiffness_n_per_m),
            ("--bit-damping-n-s-per-m", self.bit_damping_n_s_per_m),
            ("--bit-feed-force-n", self.bit_feed_force_n),
        ]
    }

    /// The bit on `ground`, if there is one.
    ///
    /// # Errors
    /// If a value is out of range, one that the rig's contact does not have is left out, or one is given without a mass.
    pub fn bit(&self, rig: &NamedRig, ground: &Slider<f64>) -> Result<Option<Bit<f64>>, UserError> {
        let Some(mass) = self.bit_mass_kg else {
            let mut others = self.about_the_bit().into_iter();
            return match others.find(|(_, value)| value.is_some()) {
                None => Ok(None),
                Some((option, _)) => Err(UserError::new(format!(
                    "{option} is for a bit; give its mass with --bit-mass-kg"
                ))),
            };
        };
        let own = own(rig);
        let missing = |option: &str| needed(rig, "bit", option);
        let stiffness = self.bit_stiffness_n_per_m.or(own.map(|o| o.0));
        let damping = self.bit_damping_n_s_per_m.or(own.map(|o| o.1));
        let weight_n = Bit::weight_n(mass);
        let bit = Bit {
            mass,
            stiffness: stiffness.ok_or_else(|| missing("--bit-stiffness-n-per-m"))?,
            damping: damping.ok_or_else(|| missing("--bit-damping-n-s-per-m"))?,
            feed_force: self.bit_feed_force_n.unwrap_or(weight_n),
        };
        bit.check(ground).map_err(numerics::Error::from)?;
        Ok(Some(bit))
    }

    /// How well it is known.
    ///
    /// # Errors
    /// If a percentage is out of range.
    pub fn uncertainty(&self) -> Result<GroundUncertainty, UserError> {
        for (option, percent) in [
            ("--threshold-percent", self.threshold_percent),
            ("--ground-stiffness-percent", self.ground_stiffness_percent),
        ] {
            below(option, percent, 0.0, 100.0)?;
        }
        Ok(GroundUncertainty {
            threshold_percent: self.threshold_percent,
            ground_stiffness_percent: self.ground_stiffness_percent,
        })
    }
}

/// Stiffness and damping of the rig's own contact, if it is a spring-dashpot.
fn own(rig: &NamedRig) -> Option<(f64, f64)> {
    match rig.params.contact {
        Law::SpringDashpot { stiffness, damping } => Some((stiffness, damping)),
        _ => None,
    }
}

fn needed(rig: &NamedRig, what: &str, option: &str) -> UserError {
    UserError::new(format!(
        "the contact of rig {} is no spring-dashpot, so the {what} needs {option}",
        rig.name
    ))
}

/// The bit as an answer has it.
#[derive(Debug, Serialize)]
pub struct BitWords {
    /// Mass of the bit, kg.
    pub bit_mass_kg: f64,
    /// Stiffness of the hammer's contact with it, N/m.
    pub bit_stiffness_n_per_m: f64,
    /// Damping of that contact, N·s/m.
    pub bit_damping_n_s_per_m: f64,
    /// Static force that presses it on the ground, N.
    pub bit_feed_force_n: f64,
}

impl From<Bit<f64>> for BitWords {
    fn from(bit: Bit<f64>) -> Self {
        Self {
            bit_mass_kg: bit.mass,
            bit_stiffness_n_per_m: bit.stiffness,
            bit_damping_n_s_per_m: bit.damping,
            bit_feed_force_n: bit.feed_force,
        }
    }
}

/// How the gap is kept: cart, ground, steady, or a speed in mm/s. None if `text` is none of these.
pub fn feed(text: &str) -> Option<Feed> {
    Some(match text {
        "cart" => Feed::Cart,
        "ground" => Feed::Ground,
        "steady" => Feed::Steady,
        _ => {
            let speed: f64 = text.trim().parse().ok()?;
            (0.0..=FASTEST_MM_PER_S)
                .contains(&speed)
                .then_some(Feed::Speed(1e-3 * speed))?
        }
    })
}

/// What [`feed`] takes, in words.
pub const FEEDS: &str = "cart, ground, steady, or a speed from 0 to 1000 mm/s";

/// The words for a feed.
pub fn feed_name(feed: Feed) -> String {
    match feed {
        Feed::Cart => "cart".to_owned(),
        Feed::Ground => "ground".to_owned(),
        Feed::Steady => "steady".to_owned(),
        Feed::Speed(speed) => format!("{:?} mm/s", numerics::row::tidy(1e3 * speed)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn feeds_are_read() {
        assert_eq!(feed("ground"), Some(Feed::Ground));
        assert_eq!(feed("0.05"), Some(Feed::Speed(5e-5)));
        for wrong in ["-1", "nan", "inf", "1001", "Cart", ""] {
            assert_eq!(feed(wrong), None, "{wrong}");
        }
    }
}
