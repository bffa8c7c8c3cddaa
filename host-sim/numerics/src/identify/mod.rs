//! Contact parameters from a drop test (section 3.3.2, figures 3.9 and 3.10): the hammer is released at rest, falls
//! back and bounces; sought are the parameters of the law whose impacts are most similar to the measured ones.
//!
//! This is not [`shared::sense::identification`], which is the microcontroller's: there a spring-dashpot follows in closed form
//! from two figures of each impact while the rig runs. Here a whole record is searched on, offline, for any law.

mod by_force;
mod by_peaks;
mod contacts;
pub mod coverage;
mod least_squares;
mod peaks;
mod profile;
mod quiet;
pub mod ring;
mod sensor;
mod shape;
mod unknowns;
mod warnings;
mod whole;

use serde::Serialize;
use shared::model::contact::{Law, LawKind};
use shared::model::params::RigParams;

use crate::error::{Error, RecordError};
use crate::progress::{Progress, step};
use crate::range::within;
use crate::signal::Signal;
pub use contacts::{Impact, MeasuredImpacts};
pub use profile::{Profile, ProfileEstimate};
use ring::Ring;
pub use sensor::FilterKind;
use sensor::SensorModel;
use unknowns::Unknowns;
pub use warnings::Warning;

/// What is made small.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Misfit {
    /// The chapter's: differences of the force peaks, squared and summed
    Peaks,
    /// Differences of the whole force, squared and summed over the samples
    Force,
}

impl Misfit {
    /// Its name in tables and pictures.
    pub fn name(self) -> &'static str {
        match self {
            Self::Peaks => "peaks",
            Self::Force => "force",
        }
    }
}

/// What a fit takes as known of the drop test, and what it seeks beside the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchSettings {
    /// Displacement at the release, m (negative: away from the surface).
    pub release_m: f64,
    /// Seek the release, too.
    pub seek_release: bool,
    /// Seek the exponent n of the nonlinear laws, too.
    pub seek_exponent: bool,
    /// Impacts used, at most.
    pub impacts: usize,
    /// How uncertain the force sensor's gain is: standard deviation, %.
    pub gain_percent: f64,
    /// How uncertain the distance of the release from rest is: standard deviation, %.
    pub release_height_percent: f64,
    /// How uncertain the clock of the samples is: standard deviation, %.
    pub clock_percent: f64,
}

impl SearchSettings {
    /// Released 3 mm out, six impacts, nothing but the law sought; a calibrated force sensor, and a release measured to
    /// 0.03 mm; any crystal for a clock.
    pub const DEFAULT: Self = Self {
        release_m: -3e-3,
        seek_release: false,
        seek_exponent: false,
        impacts: 6,
        gain_percent: 2.0,
        release_height_percent: 1.0,
        clock_percent: 0.02,
    };

    /// Refuses what a fit of a few impacts cannot take as known.
    ///
    /// # Errors
    /// If a number is out of its range.
    pub fn check(&self) -> Result<(), Error> {
        within([
            ("impacts", self.impacts as f64, 1.0, 50.0),
            ("gain-percent", self.gain_percent, 0.0, 100.0),
            (
                "release-height-percent",
                self.release_height_percent,
                0.0,
                50.0,
            ),
            ("clock-percent", self.clock_percent, 0.0, 50.0),
        ])
    }
}

impl Default for SearchSettings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Settings with which [`measure`] finds every contact of a record.
pub(crate) const EVERY_CONTACT: SearchSettings = SearchSettings {
    impacts: usize::MAX,
    ..SearchSettings::DEFAULT
};

/// Where the hammer was released, m: as given in mm, else the record's first displacement, else 3 mm from rest.
///
/// # Errors
/// If what is given is no number.
pub fn release_m(given_mm: Option<f64>, signal: &Signal) -> Result<f64, Error> {
    // A few samples, so that a noisy one does not decide.
    let shown = signal.displacement_mm.as_ref().map(|d| {
        let first = &d[..d.len().min(5)];
        first.iter().sum::<f64>() / first.len() as f64
    });
    // No sensor resolves less than a nanometre.
    let shown = shown.map(|mm| (mm * 1e6).round() / 1e6);
    let mm = given_mm.or(shown).unwrap_or(-3.0);
    if !mm.is_finite() {
        return Err(Error::Release(mm));
    }
    Ok(mm * 1e-3)
}

/// Fits each law with each misfit; a step of progress is a fit.
///
/// # Errors
/// As [`measure`] and [`fit`]; if the work is interrupted.
pub fn identify(
    signal: &Signal,
    params: &RigParams,
    laws: &[LawKind],
    misfits: &[Misfit],
    settings: &SearchSettings,
    progress: &dyn Progress,
) -> Result<(MeasuredImpacts, Vec<IdentifiedFit>), Error> {
    let measured = measure(signal, settings)?;
    let mut fits = Vec::with_capacity(laws.len() * misfits.len());
    for law in laws {
        for misfit in misfits {
            fits.push(fit(&measured, params, *law, *misfit, settings)?);
            step(progress, 1)?;
        }
    }
    Ok((measured, fits))
}

/// One measured impact beside the model's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ImpactRow {
    /// Which impact of the record it is, counted from 1.
    pub impact: usize,
    /// First sample over the threshold, s.
    pub measured_at_s: f64,
    /// The model's onset, s since the release.
    pub model_at_s: f64,
    /// Largest sample of the measured impact, the offset taken off, N.
    pub measured_peak_n: f64,
    /// What the largest sample of the model's impact would be on average, noise included, N.
    pub model_peak_n: f64,
    /// The model's contact time, ms.
    pub model_contact_time_ms: f64,
    /// ∫F dt of the samples in the window compared, N·s.
    pub measured_impulse_n_s: f64,
    /// ∫F dt of the model's whole contact, N·s; 0 where the model has none.
    pub model_impulse_n_s: f64,
    /// Root mean square of the difference in the window compared, N.
    pub residual_n: f64,
}

/// The sensor as a fit has it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SensorFound {
    /// What it reads over the true force: 1 unless the data say otherwise.
    pub gain: f64,
    /// Its kind of filter.
    pub filter: FilterKind,
    /// The filter's −3 dB corner, Hz; none: too fast to be seen in this record.
    pub filter_hz: Option<f64>,
    /// How fast its zero rises, N/s.
    pub drift_n_per_s: f64,
}

impl SensorFound {
    fn new(sensor: &SensorModel, measured: &MeasuredImpacts) -> Self {
        Self {
            gain: sensor.gain,
            filter: sensor.model,
            filter_hz: sensor.corner().map(|cycles| cycles / measured.sample_s),
            drift_n_per_s: measured.drift_n_per_s,
        }
    }
}

/// What one search found.
#[derive(Clone, Debug, Serialize)]
pub struct IdentifiedFit {
    /// Kind of law whose parameters were sought.
    pub law: LawKind,
    /// What was made small.
    pub misfit: Misfit,
    /// Whether the law is refused, because it does not fit the record: the values are then the best it can do and
    /// have no intervals.
    pub refused: bool,
    /// Whether there are intervals: not where the law is refused, nor where more than twice the noise is left.
    pub intervals: bool,
    /// What is left of the whole force over the noise (root mean squares).
    pub times_noise: f64,
    /// What was sought, with 95 % profile likelihood intervals.
    pub parameters: Vec<ProfileEstimate>,
    /// Root mean square misfit: of the peaks, or of the samples, N.
    pub rms_n: f64,
    /// The noise a peak, or a sample, has, N.
    pub noise_n: f64,
    /// Samples or peaks compared, less the numbers sought; 0 at least.
    pub degrees_of_freedom: usize,
    /// What the intervals were widened by because the law fits worse than the noise explains; 1: not.
    pub widened: f64,
    /// Searches begun, each from another start.
    pub starts: usize,
    /// How many of them ended at the best.
    pub starts_agreeing: usize,
    /// Drop tests simulated by all searches and for the intervals.
    pub simulations: u64,
    /// What the law misses of the force, noise apart, as a share of it (root mean squares over the impacts).
    pub misses_share: f64,
    /// The sensor as the fit has it.
    pub sensor: SensorFound,
    /// Each measured impact beside the model's, in time.
    pub impacts: Vec<ImpactRow>,
    /// What the data do not fix, and what the law cannot do.
    #[serde(skip)]
    pub warnings: Vec<Warning>,
    /// The ringing after the contacts.
    #[serde(skip)]
    pub ring: Option<Ring>,
    /// What model and sensor show in the window of each impact, or somewhat beyond it, N.
    #[serde(skip)]
    pub shown: Vec<Vec<f64>>,
    /// The law with the parameters found.
    #[serde(skip)]
    pub found: Law<f64>,
    /// The release found or given, m.
    #[serde(skip)]
    pub release_m: f64,
    /// The misfit over each parameter, in the order of `parameters`.
    #[serde(skip)]
    pub profiles: Vec<Profile>,
}

/// The parameters of `family` with which the impacts of the rig `params` are most similar to `measured`.
///
/// # Errors
/// If a parameter or the release is out of range, or if the hammer released there has no contact.
pub fn fit(
    measured: &MeasuredImpacts,
    params: &RigParams,
    family: LawKind,
    misfit: Misfit,
    settings: &SearchSettings,
) -> Result<IdentifiedFit, Error> {
    let unknowns = Unknowns::new(measured, params, family, settings)?;
    let whole = whole::fit(measured, params, &unknowns, settings);
    let whole = whole.ok_or(Error::Record {
        record: measured.name.clone(),
        what: RecordError::NothingToSearch,
    })?;
    let mut fit = match misfit {
        Misfit::Force => by_force::fit(measured, &unknowns, &whole),
        Misfit::Peaks => by_peaks::fit(measured, params, &unknowns, &whole),
    }
    .ok_or(Error::SearchLeftRange)?;
    fit.law = family;
    if !fit.intervals {
        for estimate in &mut fit.parameters {
            (estimate.low, estimate.high) = (None, None);
        }
    }
    fit.warnings = warnings::of(&fit, measured);
    Ok(fit)
}

/// How much less stiffness and damping are than [`fit`] finds if the cart was free to move, %: the fit takes it to be held, and
/// then finds those of the reduced mass m M/(m + M).
pub fn free_cart_percent(params: &RigParams) -> f64 {
    100.0 * params.mass_kg / (params.mass_kg + params.cart_mass_kg)
}

/// The impacts of a record.
///
/// # Errors
/// If the record has no force, or no impact stands out in it.
pub fn measure(signal: &Signal, settings: &SearchSettings) -> Result<MeasuredImpacts, Error> {
    contacts::measure(signal, settings.impacts)
}

/// The force that model and sensor of a fit show at the times of an impact's window: (time since the window's first sample
/// in s, measured in N, model in N).
pub fn beside(measured: &MeasuredImpacts, fit: &IdentifiedFit) -> Vec<Vec<[f64; 3]>> {
    let one = |(impact, shown): (&Impact, &Vec<f64>)| {
        let times = &measured.time_s[impact.window.clone()];
        let forces = &measured.force_n[impact.window.clone()];
        let triples = times.iter().zip(forces).zip(shown);
        triples.map(|((t, f), s)| [t - times[0], *f, *s]).collect()
    };
    measured.impacts.iter().zip(&fit.shown).map(one).collect()
}

#[cfg(test)]
mod release_test;
#[cfg(test)]
mod tests;
