//! What the beams' bending modes change about an answer, in lines, and the options for their springs.

use files::UserError;
use files::range::below;
use numerics::modes::{Beam, TipJoint};
use numerics::pick::{PickAnswer, Springs};

const SPRINGS_MASS: f64 = 0.1;
const SPRINGS_MASS_PERCENT: f64 = 20.0;

/// The beam springs.
#[derive(Clone, Copy, Debug, clap::Args)]
#[command(next_help_heading = "Beam springs")]
pub struct SpringsArgs {
    /// Mass of the beam springs over the hammer's (assumed: the chapter gives none)
    #[arg(long, value_name = "RATIO", default_value_t = SPRINGS_MASS)]
    springs_mass: f64,

    /// Uncertainty of that mass, % either way
    #[arg(long, value_name = "P", default_value_t = SPRINGS_MASS_PERCENT)]
    springs_mass_percent: f64,
}

impl SpringsArgs {
    /// An option that asks for other springs than the usual ones, if any.
    pub fn given(&self) -> Option<&'static str> {
        let options = [
            ("--springs-mass", self.springs_mass != SPRINGS_MASS),
            (
                "--springs-mass-percent",
                self.springs_mass_percent != SPRINGS_MASS_PERCENT,
            ),
        ];
        let mut given = options.into_iter().filter(|(_, given)| *given);
        given.next().map(|(option, _)| option)
    }

    /// The springs.
    ///
    /// # Errors
    /// If a number is out of range.
    pub fn springs(&self) -> Result<Springs, UserError> {
        Ok(Springs {
            beam: Beam {
                tip: TipJoint::Guided,
                mass_ratio: below("--springs-mass", self.springs_mass, 0.002, 5.0)?,
            },
            mass_percent: below(
                "--springs-mass-percent",
                self.springs_mass_percent,
                0.0,
                50.0,
            )?,
        })
    }
}

/// The lines about bending modes; none for wires.
pub fn lines(a: &PickAnswer) -> Vec<(&'static str, String)> {
    let b = &a.bending;
    if !b.on_beams {
        return Vec::new();
    }
    let (Some(modes), Some(springs), Some(ratio), Some(second)) = (
        b.modes,
        b.springs_mass_ratio,
        b.modes_force_ratio,
        b.second_mode_hz,
    ) else {
        let what = "one: force and safe band are for the springs' first mode alone; with more modes the force may be a fifth less at some frequencies of the band (host-sim modes)";
        return vec![("bending modes", what.to_owned())];
    };
    let mut force = format!(
        "{modes} {}, {}: {ratio:.2} times the weight",
        if modes == 1 { "mode" } else { "modes" },
        a.cart.words()
    );
    if let (Some(low), Some(high), Some(percent), Some(rigs), Some(one_one)) = (
        b.modes_force_ratio_worst,
        b.modes_force_ratio_largest,
        b.springs_mass_percent,
        b.modes_rigs,
        b.modes_rigs_one_one,
    ) {
        force += &format!(
            "; {low:.2} to {high:.2} times over the uncertainty and {percent} % of the springs' mass ({one_one} of {rigs} rigs have a stable 1/1)"
        );
    }
    let limit = a.limits.iter().find(|limit| limit.name == "max_force_n");
    let most = limit.and_then(|limit| limit.limit);
    let largest = b.modes_force_ratio_largest.unwrap_or(ratio);
    let largest_n = largest * a.force_n / a.force_ratio;
    if most.is_some_and(|most| largest_n > most) {
        force += &format!(
            "; max_force_n is kept with one mode, but not by every rig with {modes}: up to {largest_n:.1} N"
        );
    }
    let mut lines = vec![
        ("bending modes", force),
        (
            "springs",
            format!("assumed to weigh {springs} of the hammer, second mode at {second:.1} Hz"),
        ),
    ];
    if let (Some([low, high]), Some(share), Some(weak)) = (
        b.one_mode_safe_band_hz,
        b.one_mode_safe_band_force_share,
        &b.modes_weak_hz,
    ) {
        let met = match weak.as_slice() {
            [] => String::new(),
            weak => {
                let weak: Vec<_> = weak.iter().map(|hz| format!("{hz:.2}")).collect();
                format!(
                    "; weakest near {} Hz, a multiple of which is the second mode's frequency",
                    weak.join(" and ")
                )
            }
        };
        lines.push((
            "one mode alone",
            format!(
                "safe band {low:.4} to {high:.4} Hz, in which {modes} modes have down to {:.0} % of the force{met}",
                100.0 * share
            ),
        ));
    }
    if let (Some(share), Some(percent)) =
        (b.safe_band_force_share_any_springs, b.springs_mass_percent)
        && share < 0.9
    {
        lines.push((
            "springs' mass",
            format!(
                "over its {percent} % the weak frequencies move through the safe band: down to {:.0} % of the force; measure the second mode's frequency and give the mass that has it (--springs-mass, --springs-mass-percent)",
                100.0 * share
            ),
        ));
    }
    lines
}
