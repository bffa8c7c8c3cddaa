//! What an identification of contact parameters found, with sentences about its fits.

use numerics::NamedRig;
use numerics::identify::ring::Ring;
use numerics::identify::{
    IdentifiedFit, MeasuredImpacts, Misfit, SearchSettings, Warning, free_cart_percent,
};
use numerics::row::tidy;
use serde::Serialize;

/// The whole answer, as JSON has it.
#[derive(Serialize)]
pub struct IdentifyAnswer<'a> {
    /// Name of the record.
    pub file: &'a str,
    /// Name of the rig.
    pub rig: &'a str,
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// Displacement at the release, mm.
    pub release_mm: f64,
    /// Impacts fitted.
    pub impacts: usize,
    /// Samples per second.
    pub sampling_hz: f64,
    /// Standard deviation of the force without contact, N.
    pub noise_n: f64,
    /// The force channel's reading without force, N.
    pub offset_n: f64,
    /// The ringing that the best fit found.
    pub ring: Option<Ring>,
    /// How fast that reading rises, N/s.
    pub drift_n_per_s: f64,
    /// How uncertain the sensor's gain is taken to be, %.
    pub gain_percent: f64,
    /// How uncertain the distance of the release is taken to be, %.
    pub release_height_percent: f64,
    /// How uncertain the clock of the samples is taken to be, %.
    pub clock_percent: f64,
    /// How much less stiffness and damping are if the cart was free to move: m over m + M, %.
    pub free_cart_percent: f64,
    /// The fits, law by law.
    pub fits: Vec<WordedFit<'a>>,
}

impl<'a> IdentifyAnswer<'a> {
    /// The answer that these fits make.
    pub fn new(
        rig: &'a NamedRig,
        measured: &'a MeasuredImpacts,
        settings: &SearchSettings,
        fits: &'a [IdentifiedFit],
    ) -> Self {
        Self {
            file: &measured.name,
            rig: &rig.name,
            gap_mm: tidy(rig.params.gap_m * 1e3),
            release_mm: tidy(settings.release_m * 1e3),
            impacts: measured.impacts.len(),
            sampling_hz: tidy(1.0 / measured.sample_s),
            noise_n: measured.noise_n,
            offset_n: measured.offset_n,
            ring: best(fits).and_then(|fit| fit.ring),
            drift_n_per_s: measured.drift_n_per_s,
            gain_percent: settings.gain_percent,
            release_height_percent: settings.release_height_percent,
            clock_percent: settings.clock_percent,
            free_cart_percent: free_cart_percent(&rig.params),
            fits: fits.iter().map(WordedFit::from).collect(),
        }
    }
}

/// The fit whose shape is closest to the record's.
pub fn best(fits: &[IdentifiedFit]) -> Option<&IdentifiedFit> {
    let shaped = fits.iter().filter(|f| f.misfit == Misfit::Force);
    let least = shaped.min_by(|a, b| a.rms_n.total_cmp(&b.rms_n));
    least.or(fits.first())
}

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
