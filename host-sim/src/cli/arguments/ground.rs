//! Ground that gives way, and a bit on it.

use files::UserError;
use numerics::NamedRig;
use numerics::drill::GroundUncertainty;
use shared::model::bit::Bit;
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

    /// Mass of a bit between hammer and ground, kg [default: no bit]
    #[arg(long, value_name = "KG", allow_negative_numbers = true)]
    bit_mass_kg: Option<f64>,

    /// With a bit: stiffness of the hammer's contact with it, N/m [default: the rig's contact stiffness]
    #[arg(long, value_name = "N_PER_M", allow_negative_numbers = true)]
    bit_stiffness_n_per_m: Option<f64>,

    /// With a bit: damping of that contact, N·s/m [default: the rig's contact damping]
    #[arg(long, value_name = "N_S_PER_M", allow_negative_numbers = true)]
    bit_damping_n_s_per_m: Option<f64>,

    /// With a bit: static force that presses it on the ground, N [default: its weight]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    bit_feed_force_n: Option<f64>,
}

impl GroundArgs {
    /// An option that was given for a ground, if any.
    pub fn given(&self) -> Option<&'static str> {
        let options = [
            ("--threshold-n", self.threshold_n),
            ("--ground-stiffness-n-per-m", self.ground_stiffness_n_per_m),
            ("--ground-damping-n-s-per-m", self.ground_damping_n_s_per_m),
            ("--bit-mass-kg", self.bit_mass_kg),
        ];
        let options = options.into_iter().chain(self.about_the_bit());
        let mut given = options.filter(|(_, value)| value.is_some());
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
    fn about_the_bit(&self) -> [(&'static str, Option<f64>); 3] {
        [
            ("--bit-stiffness-n-per-m", self.bit_stiffness_n_per_m),
            ("--bit-damping-n-s-per-m", self.bit_damping_n_s_per_m),
            ("--bit-feed-force-n", self.bit_feed_force_n),
        ]
    }

    /// The bit asked for on `ground`; what is left out is the contact of `rig`, and the bit's weight.
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
