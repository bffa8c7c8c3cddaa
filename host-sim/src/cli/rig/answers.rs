//! What `rig new` must be told, as options; the same words are its questions.

use std::path::PathBuf;

use clap::ValueEnum;

/// What the hammer hangs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Support {
    /// Wires: a pendulum
    Wires,
    /// Beam springs
    Beams,
}

impl Support {
    /// As rig files have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wires => "wires",
            Self::Beams => "beams",
        }
    }
}

/// The answers. A reading is 298, or 298+-1, or several with commas between them: 298,299,297.5.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Answers {
    /// What the hammer hangs on
    #[arg(long, value_enum, help_heading = "Hammer")]
    pub support: Option<Support>,

    /// Weight of the hammer with what moves with it, g
    #[arg(
        long,
        value_name = "READING",
        allow_hyphen_values = true,
        help_heading = "Hammer"
    )]
    pub mass_g: Option<String>,

    /// Wires: from where they hang to the hammer's centre of mass, mm
    #[arg(
        long,
        value_name = "READING",
        allow_hyphen_values = true,
        help_heading = "Hammer"
    )]
    pub wire_length_mm: Option<String>,

    /// Full swings that were timed, to and fro, cart held still, without contact
    #[arg(
        long,
        value_name = "N",
        requires = "swing_time_s",
        help_heading = "Hammer"
    )]
    pub swings: Option<u32>,

    /// Their time by the stopwatch, s
    #[arg(
        long,
        value_name = "READING",
        allow_hyphen_values = true,
        requires = "swings",
        help_heading = "Hammer"
    )]
    pub swing_time_s: Option<String>,

    /// Natural frequency, if it is known otherwise, Hz
    #[arg(long, value_name = "READING", allow_hyphen_values = true, conflicts_with_all = ["swings", "wire_length_mm"], help_heading = "Hammer")]
    pub natural_frequency_hz: Option<String>,

    /// Beams, ringing down freely: swing in mm at first, in mm at last, and full swings between: 5:3.1:20
    #[arg(long, value_name = "FROM:TO:SWINGS", conflicts_with_all = ["damping_ratio", "decrement"], help_heading = "Hammer")]
    pub ring_down: Option<String>,

    /// Beams: logarithmic decrement per swing
    #[arg(
        long,
        value_name = "READING",
        allow_hyphen_values = true,
        conflicts_with = "damping_ratio",
        help_heading = "Hammer"
    )]
    pub decrement: Option<String>,

    /// Beams: damping ratio
    #[arg(
        long,
        value_name = "READING",
        allow_hyphen_values = true,
        help_heading = "Hammer"
    )]
    pub damping_ratio: Option<String>,

    /// Stroke of the cart, from end to end, mm
    #[arg(
        long,
        value_name = "READING",
        allow_hyphen_values = true,
        help_heading = "Cart"
    )]
    pub stroke_mm: Option<String>,

    /// Weight of the cart with what moves with it, without the hammer, kg
    #[arg(
        long,
        value_name = "READING",
        allow_hyphen_values = true,
        help_heading = "Cart"
    )]
    pub cart_mass_kg: Option<String>,

    /// Natural frequency of the shaker's position loop with the cart alone, Hz; unknown: the cart is moved as prescribed
    #[arg(
        long,
        value_name = "READING",
        allow_hyphen_values = true,
        help_heading = "Cart"
    )]
    pub shaker_loop_hz: Option<String>,

    /// Damping ratio of that loop [default: assumed]
    #[arg(
        long,
        value_name = "NUMBER",
        requires = "shaker_loop_hz",
        help_heading = "Cart"
    )]
    pub shaker_damping_ratio: Option<f64>,

    /// Clearance between hammer and surface at rest, mm [default: 0+-0.05]
    #[arg(
        long,
        value_name = "READING",
        allow_hyphen_values = true,
        help_heading = "Contact"
    )]
    pub gap_mm: Option<String>,

    /// A drop test for `identify`: CSV with the columns time_s and force_n
    #[arg(long, value_name = "FILE.csv", conflicts_with_all = ["restitution", "contact_time_ms"], help_heading = "Contact")]
    pub drop_test: Option<PathBuf>,

    /// How far the hammer was pulled back in that test, mm; negative: away from the surface [default: as `identify`]
    #[arg(
        long,
        value_name = "MM",
        allow_negative_numbers = true,
        requires = "drop_test",
        help_heading = "Contact"
    )]
    pub release_mm: Option<f64>,

    /// Restitution: with the gap at 0 and the cart still, how far the hammer rebounds over how far it was pulled back
    #[arg(
        long,
        value_name = "READING",
        allow_hyphen_values = true,
        help_heading = "Contact"
    )]
    pub restitution: Option<String>,

    /// How long it touches in one contact, ms
    #[arg(
        long,
        value_name = "READING",
        allow_hyphen_values = true,
        requires = "restitution",
        help_heading = "Contact"
    )]
    pub contact_time_ms: Option<String>,
}
