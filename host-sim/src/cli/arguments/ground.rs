//! Ground that gives way, and a bit on it.

use files::ground::GroundAsked;

/// The ground, and how well it is known.
#[derive(Clone, Copy, Debug, clap::Args)]
#[command(next_help_heading = "Ground that gives way")]
pub struct GroundArgs {
    /// Contact force at which the ground gives way (Pf), N
    #[arg(long, value_name = "N")]
    threshold_n: Option<f64>,

    /// Stiffness of the ground (k), N/m [default: the rig's contact stiffness]
    #[arg(long, value_name = "N_PER_M")]
    ground_stiffness_n_per_m: Option<f64>,

    /// Damping of the ground (c), N·s/m [default: the rig's contact damping]
    #[arg(long, value_name = "N_S_PER_M")]
    ground_damping_n_s_per_m: Option<f64>,

    /// Uncertainty of the threshold, % either way
    #[arg(long, value_name = "P", default_value_t = 20.0)]
    threshold_percent: f64,

    /// Uncertainty of the ground's stiffness, % either way; its damping changes with it
    #[arg(long, value_name = "P", default_value_t = 20.0)]
    ground_stiffness_percent: f64,

    /// Mass of a bit between hammer and ground, kg [default: no bit]
    #[arg(long, value_name = "KG")]
    bit_mass_kg: Option<f64>,

    /// With a bit: stiffness of the hammer's contact with it, N/m [default: the rig's contact stiffness]
    #[arg(long, value_name = "N_PER_M")]
    bit_stiffness_n_per_m: Option<f64>,

    /// With a bit: damping of that contact, N·s/m [default: the rig's contact damping]
    #[arg(long, value_name = "N_S_PER_M")]
    bit_damping_n_s_per_m: Option<f64>,

    /// With a bit: static force that presses it on the ground, N [default: its weight]
    #[arg(long, value_name = "N")]
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
        let options = options.into_iter().chain(self.asked().about_the_bit());
        let mut given = options.filter(|(_, value)| value.is_some());
        given.next().map(|(option, _)| option)
    }

    /// What is asked for.
    pub fn asked(&self) -> GroundAsked {
        GroundAsked {
            threshold_n: self.threshold_n,
            ground_stiffness_n_per_m: self.ground_stiffness_n_per_m,
            ground_damping_n_s_per_m: self.ground_damping_n_s_per_m,
            threshold_percent: self.threshold_percent,
            ground_stiffness_percent: self.ground_stiffness_percent,
            bit_mass_kg: self.bit_mass_kg,
            bit_stiffness_n_per_m: self.bit_stiffness_n_per_m,
            bit_damping_n_s_per_m: self.bit_damping_n_s_per_m,
            bit_feed_force_n: self.bit_feed_force_n,
        }
    }
}
