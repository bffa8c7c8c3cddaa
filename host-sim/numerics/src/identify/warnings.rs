//! What to keep in mind about a fit, as values.

use super::{IdentifiedFit, MeasuredImpacts, Misfit};
use shared::model::contact::LawKind;

/// Correlations closer to 1 than this leave only a combination of the two parameters known.
const CLOSE_CORRELATION: f64 = 0.95;

/// What the data do not fix, and what the law cannot do.
#[derive(Clone, Debug, PartialEq)]
pub enum Warning {
    /// Fewer peaks than parameters: many choices of the parameters meet the peaks.
    FewerPeaks {
        /// Number of peaks compared, one for each impact.
        peaks: usize,
        /// Number of parameters sought.
        parameters: usize,
    },
    /// As many peaks as parameters: any law meets the peaks.
    AsManyPeaks {
        /// Peaks compared, and parameters sought.
        peaks: usize,
    },
    /// The interval of a parameter has no end on one side or both.
    Unbounded {
        /// Its key in rig files.
        parameter: &'static str,
    },
    /// A parameter ends at the limit of the range that was searched.
    AtLimit {
        /// Its key in rig files.
        parameter: &'static str,
    },
    /// Two parameters can make up for each other.
    Correlated {
        /// The key of one in rig files.
        parameter: &'static str,
        /// The key of the other.
        other: &'static str,
        /// From −1 to 1.
        correlation: f64,
    },
    /// The law does not fit: it misses the force by far more than noise and sensor explain. There are no intervals.
    DoesNotFit {
        /// What it misses of the force, as a share of it.
        share: f64,
    },
    /// What is left of the misfit is more than twice the noise: something in the sensor is not in its model. There are no
    /// intervals.
    BeyondNoise {
        /// How many times the noise.
        factor: f64,
    },
    /// What is left of the misfit is more than independent noise explains, and the intervals are widened by as much.
    Widened {
        /// How many times worse.
        factor: f64,
    },
    /// The zero steps or wanders: that near each contact is taken off.
    ZeroSteps,
    /// The law loses no energy, but there are several impacts.
    NoEnergyLoss,
    /// The record shows no noise between the impacts: a small share of the largest peak stands for it.
    NoNoise,
}

/// The warnings about `fit`, in the order of [`Warning`], those of parameters parameter by parameter.
pub(super) fn of(fit: &IdentifiedFit, measured: &MeasuredImpacts) -> Vec<Warning> {
    let mut found = Vec::new();
    let peaks = measured.impacts.len();
    let parameters = fit.parameters.len();
    if fit.misfit == Misfit::Peaks && peaks < parameters {
        found.push(Warning::FewerPeaks { peaks, parameters });
    } else if fit.misfit == Misfit::Peaks && peaks == parameters {
        found.push(Warning::AsManyPeaks { peaks });
    }
    if fit.refused {
        let share = fit.misses_share;
        found.push(Warning::DoesNotFit { share });
    } else if !fit.intervals {
        let factor = fit.times_noise;
        found.push(Warning::BeyondNoise { factor });
    }
    for estimate in &fit.parameters {
        let parameter = estimate.key;
        if fit.intervals && (estimate.low.is_none() || estimate.high.is_none()) {
            found.push(Warning::Unbounded { parameter });
        }
        if estimate.at_limit {
            found.push(Warning::AtLimit { parameter });
        }
        if let Some((other, correlation)) = estimate.strongest_correlation
            && correlation.abs() > CLOSE_CORRELATION
            && !found.iter().any(
                |w| matches!(w, Warning::Correlated { parameter: first, .. } if *first == other),
            )
        {
            found.push(Warning::Correlated {
                parameter,
                other,
                correlation,
            });
        }
    }
    if fit.widened > 1.2 && fit.intervals {
        found.push(Warning::Widened {
            factor: fit.widened,
        });
    }
    if measured.zero_steps {
        found.push(Warning::ZeroSteps);
    }
    if fit.law == LawKind::Hertz && peaks > 1 {
        found.push(Warning::NoEnergyLoss);
    }
    if measured.noise_n == 0.0 {
        found.push(Warning::NoNoise);
    }
    found
}
