//! Contact parameters from a drop test (section 3.3.2, figures 3.9 and 3.10): the hammer is released at rest, falls
//! back and bounces; sought are the parameters of the law whose impacts are most similar to the measured ones.
//!
//! This is not [`shared::sense::identification`], which is the microcontroller's: there a spring-dashpot follows in closed form
//! from two figures of each impact while the rig runs. Here a whole record is searched on, offline, for any law.

mod contacts;
mod likeness;
mod profile;
pub mod ring;
mod search;
mod unknowns;
mod warnings;

use serde::Serialize;
use shared::model::contact::Law;
use shared::model::params::RigParams;
use shared::model::rig::Rig;

use crate::error::{Error, RecordError};
use crate::signal::Signal;
pub use contacts::{Impact, Measured};
pub use likeness::{Aligned, Likeness};
pub use profile::{Estimate, Profile};
pub use unknowns::Unknowns;
pub use warnings::Warning;

/// A kind of contact law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Family {
    /// F = ki δ + ci δ̇ (3-3): ki and ci
    SpringDashpot,
    /// F = ki δⁿ (3-2): ki
    Hertz,
    /// F = ki δⁿ(1 + λ δ̇) (3-4): ki and λ
    HuntCrossley,
    /// F = ki δⁿ(1 + ¾(1 − e²) δ̇/δ̇⁻) (3-5): ki and e
    LankaraniNikravesh,
}

impl Family {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::SpringDashpot,
        Self::Hertz,
        Self::HuntCrossley,
        Self::LankaraniNikravesh,
    ];

    /// Its name, as rig files have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::SpringDashpot => "spring-dashpot",
            Self::Hertz => "hertz",
            Self::HuntCrossley => "hunt-crossley",
            Self::LankaraniNikravesh => "lankarani-nikravesh",
        }
    }
}

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
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Peaks => "peaks",
            Self::Force => "force",
        }
    }
}

/// How to search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Displacement at the release, m (negative: away from the surface).
    pub release_m: f64,
    /// Seek the release, too.
    pub seek_release: bool,
    /// Seek the exponent n of the nonlinear laws, too.
    pub seek_exponent: bool,
    /// Impacts used, at most.
    pub impacts: usize,
}

/// Settings with which [`measure`] finds every contact of a record.
pub(crate) const EVERY_CONTACT: Settings = Settings {
    release_m: 0.0,
    seek_release: false,
    seek_exponent: false,
    impacts: usize::MAX,
};

/// One measured impact beside the model's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ImpactRow {
    /// Counted from 1.
    pub impact: usize,
    /// First sample over the threshold, s.
    pub measured_at_s: f64,
    /// The model's onset, s since the release.
    pub model_at_s: f64,
    /// Largest sample, N.
    pub measured_peak_n: f64,
    /// What the largest sample of the model's impact would be on average, noise included, N.
    pub model_peak_n: f64,
    /// The model's contact time, ms.
    pub model_contact_time_ms: f64,
    /// ∫F dt of the samples in the window compared, N·s.
    pub measured_impulse_n_s: f64,
    /// The model's, N·s.
    pub model_impulse_n_s: f64,
    /// Root mean square of the difference in the window compared, N.
    pub residual_n: f64,
}

/// What one search found.
#[derive(Clone, Debug, Serialize)]
pub struct Fit {
    /// The law.
    pub law: Family,
    /// What was made small.
    pub misfit: Misfit,
    /// What was sought, with 95 % profile likelihood intervals.
    pub parameters: Vec<Estimate>,
    /// Root mean square misfit: of the peaks, or of the samples, N.
    pub rms_n: f64,
    /// The noise a peak, or a sample, has, N.
    pub noise_n: f64,
    /// Data less unknowns.
    pub degrees_of_freedom: usize,
    /// What the intervals were widened by because the law fits worse than the noise explains; 1: not.
    pub widened: f64,
    /// Searches begun, and how many ended at the best.
    pub starts: usize,
    /// How many of them ended at the best.
    pub starts_agreeing: usize,
    /// Drop tests simulated.
    pub simulations: u64,
    /// Impact by impact.
    pub impacts: Vec<ImpactRow>,
    /// What the data do not fix, and what the law cannot do.
    #[serde(skip)]
    pub warnings: Vec<Warning>,
    /// The law found.
    #[serde(skip)]
    pub found: Law<f64>,
    /// The release found or given, m.
    #[serde(skip)]
    pub release_m: f64,
    /// Of each parameter.
    #[serde(skip)]
    pub profiles: Vec<Profile>,
}

/// The parameters of `family` with which the impacts of the rig `params` are most similar to `measured`.
///
/// # Errors
/// If a parameter or the release is out of range, or if the hammer released there has no contact.
pub fn fit(
    measured: &Measured,
    params: &RigParams,
    family: Family,
    misfit: Misfit,
    settings: &Settings,
) -> Result<Fit, Error> {
    let unknowns = Unknowns::new(measured, params, family, settings)?;
    let likeness = Likeness::new(measured, params, misfit);
    let cost = |x: &[f64]| match unknowns.read(x) {
        Some((law, release_m)) => likeness.cost(law, release_m),
        None => unknowns.beyond(x),
    };
    let searched = search::from_all(&cost, &unknowns.starts(), unknowns.steps());
    let searched = searched.ok_or(Error::Record {
        record: measured.name.clone(),
        what: RecordError::NothingToSearch,
    })?;
    let mut best = searched.best;
    let degrees = likeness.data().saturating_sub(best.x.len());
    let at = |x: &[f64]| unknowns.read(x).map(|(law, m)| likeness.aligned(law, m));
    let noise_n = at(&best.x).map_or(f64::NAN, |seen| likeness.deviation_n(&seen));
    let noise = profile::Noise::new(
        &best,
        degrees,
        (noise_n / likeness.unit_n()).powi(2),
        measured.noise_n > 0.0,
    );
    let (profiles, sought) = profile::all(&cost, &unknowns, &mut best, &noise);
    let (law, release_m) = unknowns.read(&best.x).ok_or(Error::SearchLeftRange)?;
    let seen = likeness.aligned(law, release_m);
    let parameters: Vec<_> = profiles.iter().map(|p| p.estimate.clone()).collect();
    let data = likeness.data() as f64;
    let mut fit = Fit {
        law: family,
        misfit,
        rms_n: (likeness.sum_of_squares(&seen) / data).sqrt(),
        noise_n,
        parameters,
        degrees_of_freedom: degrees,
        widened: noise.widened,
        starts: searched.starts,
        starts_agreeing: searched.agreeing,
        simulations: searched.evaluations + sought,
        impacts: impact_rows(measured, &seen),
        warnings: Vec::new(),
        found: law,
        release_m,
        profiles,
    };
    fit.warnings = warnings::of(&fit, measured);
    Ok(fit)
}

fn impact_rows(measured: &Measured, seen: &[Aligned]) -> Vec<ImpactRow> {
    let row = |(i, (impact, model)): (usize, (&Impact, &Aligned))| {
        let course = model.course.as_ref().map(|b| b.contact);
        ImpactRow {
            impact: i + 1,
            measured_at_s: impact.at_s,
            model_at_s: course.map_or(f64::NAN, |b| b.onset_s),
            measured_peak_n: impact.peak_n,
            model_peak_n: model.peak_n,
            model_contact_time_ms: course.map_or(0.0, |b| b.duration_s * 1e3),
            measured_impulse_n_s: impact.impulse_n_s,
            model_impulse_n_s: course.map_or(0.0, |b| b.impulse_n_s),
            residual_n: (model.squares / impact.window.len() as f64).sqrt(),
        }
    };
    measured
        .impacts
        .iter()
        .zip(seen)
        .enumerate()
        .map(row)
        .collect()
}

/// The impacts of a record.
///
/// # Errors
/// If the record has no force, or no impact stands out in it.
pub fn measure(signal: &Signal, settings: &Settings) -> Result<Measured, Error> {
    contacts::measure(signal, settings.impacts)
}

/// The force a fit's model has at the times of an impact's window: (time since the window's first sample in s,
/// measured in N, model in N).
pub fn beside(measured: &Measured, params: &RigParams, fit: &Fit) -> Vec<Vec<[f64; 3]>> {
    let params = RigParams {
        contact: fit.found,
        ..*params
    };
    let Ok(rig) = Rig::<f64>::new(&params) else {
        return Vec::new();
    };
    let likeness = Likeness::new(measured, &params, Misfit::Force);
    let seen = likeness.aligned(fit.found, fit.release_m);
    let one = |(impact, model): (&Impact, &Aligned)| {
        let times = &measured.time_s[impact.window.clone()];
        let forces = &measured.force_n[impact.window.clone()];
        let row = |(t, f): (&f64, &f64)| {
            let model_n = model
                .course
                .as_ref()
                .map_or(0.0, |b| b.force(&rig, t - model.onset_s));
            [t - times[0], *f, model_n]
        };
        times.iter().zip(forces).map(row).collect()
    };
    measured.impacts.iter().zip(&seen).map(one).collect()
}

#[cfg(test)]
mod tests;
