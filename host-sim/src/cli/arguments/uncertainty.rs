//! How well the rig is known: `--nominal`, the half-widths, samples and seed.

use files::UserError;
use files::rigfile::WIDTHS;
use numerics::NamedRig;
use numerics::uncertainty::{Stated, Uncertainty};

/// How well the rig is known.
#[derive(Clone, Debug, clap::Args)]
#[command(
    next_help_heading = "Uncertainty (an option replaces the value of the rig file's [uncertainty])"
)]
pub struct UncertaintyArgs {
    /// Take the parameters as exact
    #[arg(long, conflicts_with_all = [
        "natural_frequency_percent", "amplitude_percent", "contact_stiffness_percent",
        "contact_stiffness_factor", "contact_damping_percent", "contact_damping_ratio_percent", "gap_tolerance_mm", "mass_percent",
        "cart_mass_percent", "shaker_loop_percent", "shaker_damping_percent", "samples", "seed",
    ])]
    nominal: bool,

    /// Natural frequency, % either way [default: the rig file's, else 2]
    #[arg(long, value_name = "P")]
    natural_frequency_percent: Option<f64>,

    /// Cart amplitude, % either way [default: the rig file's, else 5]
    #[arg(long, value_name = "P")]
    amplitude_percent: Option<f64>,

    /// Contact stiffness, % either way [default: the rig file's, else 20]
    #[arg(long, value_name = "P")]
    contact_stiffness_percent: Option<f64>,

    /// Instead of a percentage: the largest factor, up or down, between the true and the stated contact stiffness
    #[arg(long, value_name = "X")]
    contact_stiffness_factor: Option<f64>,

    /// Contact damping, % either way [default: the rig file's, else 20]
    #[arg(long, value_name = "P")]
    contact_damping_percent: Option<f64>,

    /// Instead: damping ratio of the contact, % either way, if one contact time gave both stiffness and damping
    #[arg(long, value_name = "P")]
    contact_damping_ratio_percent: Option<f64>,

    /// Gap, mm either way [default: the rig file's, else 0.05]
    #[arg(long, value_name = "MM")]
    gap_tolerance_mm: Option<f64>,

    /// Hammer mass, % either way [default: the rig file's, else 0]
    #[arg(long, value_name = "P")]
    mass_percent: Option<f64>,

    /// Cart mass, % either way; only for a recoiling cart [default: the rig file's, else 5]
    #[arg(long, value_name = "P")]
    cart_mass_percent: Option<f64>,

    /// Natural frequency of the shaker's loop, % either way; only for a recoiling cart [default: the rig file's, else
    /// 30]
    #[arg(long, value_name = "P")]
    shaker_loop_percent: Option<f64>,

    /// Damping ratio of that loop, % either way; only for a recoiling cart [default: the rig file's, else 30]
    #[arg(long, value_name = "P")]
    shaker_damping_percent: Option<f64>,

    /// Random rigs within the uncertainty, in addition to its corners
    #[arg(long, value_name = "N", default_value_t = 256)]
    samples: u32,

    /// Seed of the random rigs
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

impl UncertaintyArgs {
    /// Seed of the random rigs.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Refuses an option that is out of range.
    ///
    /// # Errors
    /// If one is.
    pub fn check(&self) -> Result<(), UserError> {
        self.given().map(drop)
    }

    /// The uncertainty of `rig`: what the options say, else what its file states, else the usual. None with `--nominal`.
    ///
    /// # Errors
    /// If an option is out of range.
    pub fn of(&self, rig: &NamedRig) -> Result<Option<Uncertainty>, UserError> {
        let stated = self.given()?.or(&rig.stated);
        let recoils = rig.params.cart.recoils();
        let whole = stated.complete(self.samples, self.seed, recoils);
        whole.check()?;
        Ok((!self.nominal).then_some(whole))
    }

    /// What the options say.
    fn given(&self) -> Result<Stated, UserError> {
        let options = [
            self.natural_frequency_percent,
            self.amplitude_percent,
            self.contact_stiffness_percent,
            self.contact_stiffness_factor,
            self.contact_damping_percent,
            self.contact_damping_ratio_percent,
            self.gap_tolerance_mm,
            self.mass_percent,
            self.cart_mass_percent,
            self.shaker_loop_percent,
            self.shaker_damping_percent,
        ];
        let mut stated = Stated::default();
        for (width, value) in WIDTHS.iter().zip(options) {
            if let Some(value) = value {
                let option = format!("--{}", width.key.replace('_', "-"));
                width.set(&mut stated, &option, value)?;
            }
        }
        Ok(stated)
    }
}
