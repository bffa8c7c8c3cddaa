//! Ground that gives way, as a scenario says it.

use serde::Deserialize;
use shared::model::contact::Law;
use shared::model::params::RigParams;
use shared::model::slider::Slider;

use super::complaint::out_of_range;
use crate::ground::PlantGround;
use files::UserError;

/// The table `[ground]`: ground that gives way.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GroundTable {
    threshold_n: f64,
    stiffness_n_per_m: Option<f64>,
    damping_n_s_per_m: Option<f64>,
    #[serde(default = "half_a_second")]
    feed_s: f64,
}

fn half_a_second() -> f64 {
    0.5
}

impl GroundTable {
    /// The ground under `rig`, whose contact it has where it says nothing else.
    ///
    /// # Errors
    /// A number is out of its range, or missing where the rig's contact is no spring-dashpot.
    pub fn of(&self, rig: &RigParams) -> Result<PlantGround, UserError> {
        let own = match rig.contact {
            Law::SpringDashpot { stiffness, damping } => (stiffness, damping),
            _ => (f64::NAN, f64::NAN),
        };
        let slider = Slider {
            stiffness: self.stiffness_n_per_m.unwrap_or(own.0),
            damping: self.damping_n_s_per_m.unwrap_or(own.1),
            threshold: self.threshold_n,
        };
        slider.check()?;
        if !(1e-3..=1e6).contains(&self.feed_s) {
            return Err(out_of_range("feed_s", self.feed_s, "0.001 to 1000000"));
        }
        Ok(PlantGround {
            slider,
            feed_s: self.feed_s,
            slipping: false,
        })
    }
}
