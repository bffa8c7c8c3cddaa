//! Ground that gives way.

use files::UserError;
use numerics::NamedRig;
use numerics::drill::GroundUncertainty;
use shared::model::contact::Law;
use shared::model::slider::Slider;

/// The ground, and how well it is known.
#[derive(Clone, Copy, Debug, clap::Args)]
#[command(next_help_heading = "Ground that gives way")]
pub struct GroundArgs {
    /// Contact force at which the ground gives way (Pf), N
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    threshold_n: Option<f64>,

    /// Stiffness of the ground (k), N/m [default: the rig's contact stiffness]
    #[arg(long, value_name = "N_PER_M", allow_negative_numbers = true)]
    ground_stiffness_n_per_m: Option<f64>,

    /// Damping of the ground (c), N·s/m [default: the rig's contact damping]
    #[arg(long, value_name = "N_S_PER_M", allow_negative_numbers = true)]
    ground_damping_n_s_per_m: Option<f64>,

    /// Uncertainty of the threshold, % either way
    #[arg(
        long,
        value_name = "P",
        default_value_t = 20.0,
        allow_negative_numbers = true
    )]
    threshold_percent: f64,

    /// Uncertainty of the ground's stiffness, % either way; its damping goes with it
    #[arg(
        long,
        value_name = "P",
        default_value_t = 20.0,
        allow_negative_numbers = true
    )]
    ground_stiffness_percent: f64,
}

impl GroundArgs {
    /// An option that was given for a ground, if any.
    pub fn given(&self) -> Option<&'static str> {
        let options = [
            ("--threshold-n", self.threshold_n),
            ("--ground-stiffness-n-per-m", self.ground_stiffness_n_per_m),
            ("--ground-damping-n-s-per-m", self.ground_damping_n_s_per_m),
        ];
        let mut given = options.into_iter().filter(|(_, value)| value.is_some());
        given.next().map(|(option, _)| option)
    }

    /// The ground asked for; what is left out is the contact of `rig`.
    ///
    /// # Errors
    /// If there is no threshold, or a value is out of range, or one that the rig's contact does not have is left out.
    pub fn ground(&self, rig: &NamedRig) -> Result<Slider<f64>, UserError> {
        let Some(threshold) = self.threshold_n else {
            return Err(UserError::new(
                "give --threshold-n, the contact force in N at which the ground gives way",
            ));
        };
        let own = match rig.params.contact {
            Law::SpringDashpot { stiffness, damping } => Some((stiffness, damping)),
            _ => None,
        };
        let missing = |option: &str| {
            UserError::new(format!(
                "the contact of rig {} is no spring-dashpot, so the ground needs {option}",
                rig.name
            ))
        };
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

    /// How well it is known.
    ///
    /// # Errors
    /// If a percentage is out of range.
    pub fn uncertainty(&self) -> Result<GroundUncertainty, UserError> {
        for (option, percent) in [
            ("--threshold-percent", self.threshold_percent),
            ("--ground-stiffness-percent", self.ground_stiffness_percent),
        ] {
            if !(0.0..100.0).contains(&percent) {
                return Err(UserError::new(format!(
                    "{option} is {percent}, must be from 0 to below 100"
                )));
            }
        }
        Ok(GroundUncertainty {
            threshold_percent: self.threshold_percent,
            ground_stiffness_percent: self.ground_stiffness_percent,
        })
    }
}
