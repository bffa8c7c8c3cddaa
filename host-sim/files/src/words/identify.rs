//! Sentences about a fit of contact parameters.

use numerics::identify::{IdentifiedFit, Warning};
use serde::Serialize;

/// A fit with its warnings in words, as JSON has it.
#[derive(Serialize)]
pub struct WordedFit<'a> {
    /// The fitted contact parameters; in JSON its fields stand beside `warnings`.
    #[serde(flatten)]
    pub fit: &'a IdentifiedFit,
    /// The fit's warnings, a sentence each.
    pub warnings: Vec<String>,
}

impl<'a> From<&'a IdentifiedFit> for WordedFit<'a> {
    fn from(fit: &'a IdentifiedFit) -> Self {
        Self {
            fit,
            warnings: fit.warnings.iter().map(warning).collect(),
        }
    }
}

fn warning(warning: &Warning) -> String {
    match *warning {
        Warning::FewerPeaks { peaks, parameters } => format!(
            "{peaks} peak{} cannot fix {parameters} parameters: the values are one choice of many; use --misfit force or more impacts",
            if peaks == 1 { "" } else { "s" }
        ),
        Warning::AsManyPeaks { peaks } => format!(
            "{peaks} peaks for {peaks} parameters: they are met whatever the law, so nothing tells whether it is right"
        ),
        Warning::Unbounded { parameter } => {
            format!("the data do not bound {parameter} on both sides")
        }
        Warning::AtLimit { parameter } => format!(
            "{parameter} ends at the limit of its range: the law cannot do what the data ask for"
        ),
        Warning::Correlated {
            parameter,
            other,
            correlation,
        } => format!(
            "{parameter} and {other} can stand in for each other (correlation {correlation:.3}): the data fix a combination of them better than either"
        ),
        Warning::DoesNotFit { share } => format!(
            "this law does not fit: it misses {:.0} % of the force, far more than noise and sensor explain; its values have no intervals; try another law, and check the units of time and force, --rig, --gap and --release-mm; a filter in the sensor's converter that is not in the model may be why, too",
            100.0 * share
        ),
        Warning::BeyondNoise { factor } => format!(
            "what is left of the misfit is {factor:.1} times the noise: something in sensor or converter is not in the model, and the values have no intervals"
        ),
        Warning::ZeroSteps => {
            "the force without contact steps or wanders; near each contact its own is taken off"
                .to_owned()
        }
        Warning::Widened { factor } => format!(
            "what is left of the misfit is {factor:.1} times what independent noise explains; the intervals are widened by as much"
        ),
        Warning::NoEnergyLoss => {
            "this law loses no energy; a hammer that strikes ever more softly is not it".to_owned()
        }
        Warning::NoNoise => {
            "no noise is seen between the impacts: 1e-5 of the largest peak stands for it"
                .to_owned()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_peak_is_singular_and_several_are_plural() {
        let says = |peaks| {
            warning(&Warning::FewerPeaks {
                peaks,
                parameters: 4,
            })
        };
        assert!(says(1).starts_with("1 peak cannot fix 4 parameters"));
        assert!(says(2).starts_with("2 peaks cannot fix 4 parameters"));
    }
}
