//! What `rig new` must be told, as options; the same words are its questions.

use std::path::PathBuf;

use clap::ValueEnum;
use clap::builder::RangedI64ValueParser;

use crate::own_rig::reading::{
    CONTACT_TIME, DAMPING_RATIO, FORCE, FREQUENCY, GAP, LOOP_DAMPING, MASS, OwnReading,
    RESTITUTION, STROKE, SWING_TIME, WIRE_LENGTH,
};
use crate::own_rig::surface;

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

/// Swings that ring down: as written, and their logarithmic decrement.
#[derive(Clone, Debug, PartialEq)]
pub struct RingDown {
    /// The answer as it was written, without blanks around it.
    pub text: String,
    /// Logarithmic decrement of a full swing: ln(FROM/TO)/SWINGS.
    pub decrement: f64,
}

/// Reads FROM:TO:SWINGS.
///
/// # Errors
/// In words that name the mend.
pub fn ring_down(text: &str) -> Result<RingDown, String> {
    let parts: Vec<f64> = text
        .split(':')
        .filter_map(|part| part.trim().parse().ok().filter(|x: &f64| x.is_finite()))
        .collect();
    match parts[..] {
        [from, to, swings]
            if text.split(':').count() == 3 && to > 0.0 && from > to && swings >= 1.0 =>
        {
            Ok(RingDown {
                text: text.trim().to_owned(),
                decrement: (from / to).ln() / swings,
            })
        }
        _ => Err("write FROM:TO:SWINGS, the swing in mm at first, a smaller one at last, and full swings between: 5:3.1:20".to_owned()),
    }
}

/// How many swings were timed.
pub fn swings() -> RangedI64ValueParser<u32> {
    clap::value_parser!(u32).range(1..=100_000)
}

/// The answers. A reading is 298g, or 298+-1g, or several with blanks or ; between them: "298 299 297.5 g".
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Answers {
    /// Suspension of the hammer
    #[arg(long, value_enum, help_heading = "Hammer")]
    pub support: Option<Support>,

    /// Weight of the hammer with what moves with it: 298g, 298+-1g or "298 299 297.5 g"
    #[arg(long, value_name = "READING", value_parser = |text: &str| MASS.read(text), allow_hyphen_values = true, help_heading = "Hammer")]
    pub mass: Option<OwnReading>,

    /// Wires: from their suspension to the hammer's centre of mass: 75mm
    #[arg(long, value_name = "READING", value_parser = |text: &str| WIRE_LENGTH.read(text), allow_hyphen_values = true, help_heading = "Hammer")]
    pub wire_length: Option<OwnReading>,

    /// Number of timed full swings, to and fro, cart held still, without contact
    #[arg(long, value_name = "N", value_parser = swings(), requires = "swing_time", help_heading = "Hammer")]
    pub swings: Option<u32>,

    /// Their time by the stopwatch: 10.99s
    #[arg(long, value_name = "READING", value_parser = |text: &str| SWING_TIME.read(text), allow_hyphen_values = true, requires = "swings", help_heading = "Hammer")]
    pub swing_time: Option<OwnReading>,

    /// Natural frequency, if you measured it in another way: 1.82Hz
    #[arg(long, value_name = "READING", value_parser = |text: &str| FREQUENCY.read(text), allow_hyphen_values = true, conflicts_with_all = ["swings", "wire_length"], help_heading = "Hammer")]
    pub natural_frequency: Option<OwnReading>,

    /// Beams, ringing down freely: swing in mm at first, in mm at last, and full swings between: 5:3.1:20
    #[arg(long, value_name = "FROM:TO:SWINGS", value_parser = ring_down, conflicts_with = "damping_ratio", help_heading = "Hammer")]
    pub ring_down: Option<RingDown>,

    /// Beams: damping ratio
    #[arg(long, value_name = "READING", value_parser = |text: &str| DAMPING_RATIO.read(text), allow_hyphen_values = true, help_heading = "Hammer")]
    pub damping_ratio: Option<OwnReading>,

    /// Stroke of the cart, from end to end: 1.8mm
    #[arg(long, value_name = "READING", value_parser = |text: &str| STROKE.read(text), allow_hyphen_values = true, help_heading = "Cart")]
    pub stroke: Option<OwnReading>,

    /// Weight of the cart with what moves with it, without the hammer: 5.4kg
    #[arg(long, value_name = "READING", value_parser = |text: &str| MASS.read(text), allow_hyphen_values = true, help_heading = "Cart")]
    pub cart_mass: Option<OwnReading>,

    /// Natural frequency of the shaker's position loop with the cart alone: 50Hz; unknown: the cart is moved as prescribed
    #[arg(long, value_name = "READING", value_parser = |text: &str| FREQUENCY.read(text), allow_hyphen_values = true, help_heading = "Cart")]
    pub shaker_loop: Option<OwnReading>,

    /// Damping ratio of that loop [default: assumed]
    #[arg(long, value_name = "READING", value_parser = |text: &str| LOOP_DAMPING.read(text), allow_hyphen_values = true, requires = "shaker_loop", help_heading = "Cart")]
    pub shaker_damping_ratio: Option<OwnReading>,

    /// Largest force that the shaker can give: 60N; unknown: it limits nothing
    #[arg(long, value_name = "READING", value_parser = |text: &str| FORCE.read(text), allow_hyphen_values = true, requires = "shaker_loop", help_heading = "Cart")]
    pub shaker_force: Option<OwnReading>,

    /// Clearance between hammer and surface at rest [default: 0+-0.05mm]
    #[arg(long, value_name = "READING", value_parser = |text: &str| GAP.read(text), allow_hyphen_values = true, help_heading = "Contact")]
    pub gap: Option<OwnReading>,

    /// A drop test for `identify`: CSV with the columns time_s and force_n
    #[arg(long, value_name = "FILE.csv", conflicts_with_all = ["surface", "restitution", "contact_time"], help_heading = "Contact")]
    pub drop_test: Option<PathBuf>,

    /// Displacement at the release in that test, mm; negative: away from the surface [default: as `identify`]
    #[arg(
        long,
        value_name = "MM",
        requires = "drop_test",
        help_heading = "Contact"
    )]
    pub release_mm: Option<f64>,

    /// Duration of one contact: 0.57ms
    #[arg(long, value_name = "READING", value_parser = |text: &str| CONTACT_TIME.read(text), allow_hyphen_values = true, help_heading = "Contact")]
    pub contact_time: Option<OwnReading>,

    /// Restitution: with a gap of 0 and the cart still, the hammer's rebound over the distance that you pulled it back
    #[arg(long, value_name = "READING", value_parser = |text: &str| RESTITUTION.read(text), allow_hyphen_values = true, help_heading = "Contact")]
    pub restitution: Option<OwnReading>,

    /// Material that the steel hammer strikes: gives the stiffness without a contact time, and the restitution if you did
    /// not measure it
    #[arg(long, value_enum, help_heading = "Contact")]
    pub surface: Option<surface::SurfaceChoice>,
}
