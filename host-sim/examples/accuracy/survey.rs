//! Random periodic points over all four rigs: the f32 switch model against the reference.

use std::f64::consts::TAU;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use shared::model::params::{PRESETS, RigParams};
use shared::model::regime::Regime;

use numerics::engine::{Plan, Setting, Start};
use numerics::{Error, parallel};

use crate::outcome::{PeriodsOutcome, SETTLING, real_frequency, settle, settle_reference};

/// How long each point runs from rest: 600 drive periods, the last 120 recorded.
pub const PLAN: Plan = SETTLING;

/// Largest clearance drawn, mm.
pub const GAP_MM: f64 = 3.56;

/// Frequency ratios drawn.
pub const RATIOS: std::ops::Range<f64> = 0.8..4.6;

/// What the largest recorded force may be off by, relative to the reference.
pub const REQUIREMENT: f64 = 2e-4;

/// How far the start is moved to show that a point lies on the edge between two attractors, m.
pub const NUDGE_M: f64 = 1e-9;

/// A point of the survey.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurveyPoint {
    /// Index into [`PRESETS`].
    pub rig: usize,
    /// Gap, mm.
    pub gap_mm: f64,
    /// Drive frequency over natural frequency.
    pub ratio: f64,
}

impl SurveyPoint {
    /// The rig's preset name.
    pub fn rig_name(&self) -> &'static str {
        PRESETS[self.rig].0
    }

    /// Its parameters.
    pub fn params(&self) -> RigParams {
        RigParams {
            gap_m: self.gap_mm * 1e-3,
            ..PRESETS[self.rig].1
        }
    }

    /// The drive frequency asked for, Hz.
    pub fn frequency_hz(&self) -> f64 {
        self.ratio * self.params().natural_frequency_hz()
    }
}

/// The first `count` points of the seeded sequence at which the reference finds z = p/n from rest.
///
/// # Errors
/// If a simulation fails, which none of the presets does.
pub fn points(seed: u64, count: usize) -> Result<Vec<SurveyPoint>, Error> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut found = Vec::new();
    let mut drawn = 0;
    while found.len() < count {
        let batch: Vec<SurveyPoint> = (0..64)
            .map(|i| SurveyPoint {
                rig: (drawn + i) % PRESETS.len(),
                gap_mm: rng.random_range(0.0..GAP_MM),
                ratio: rng.random_range(RATIOS),
            })
            .collect();
        drawn += batch.len();
        let outcomes = parallel::try_map(&batch, |p| {
            settle_reference(&p.params(), p.frequency_hz(), Start::Rest, PLAN)
        })?;
        let periodic = batch
            .into_iter()
            .zip(outcomes)
            .filter(|(_, o)| matches!(o.regime, Regime::Periodic { .. }));
        found.extend(periodic.map(|(p, _)| p));
    }
    found.truncate(count);
    Ok(found)
}

/// A point as both engines see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compared {
    /// The point.
    pub point: SurveyPoint,
    /// The reference, at the frequency the switch model really runs at.
    pub truth: PeriodsOutcome,
    /// The switch model.
    pub seen: PeriodsOutcome,
}

impl Compared {
    /// |relative error of the largest force|.
    pub fn error(&self) -> f64 {
        self.seen.force_error(&self.truth).abs()
    }
}

/// Runs both engines from rest at every point.
///
/// # Errors
/// If a simulation fails, which none of the presets does at a tick that resolves the drive.
pub fn compare(points: &[SurveyPoint], setting: Setting) -> Result<Vec<Compared>, Error> {
    let one = |point: &SurveyPoint| {
        let params = point.params();
        let frequency_hz = real_frequency(setting, point.frequency_hz())?;
        Ok(Compared {
            point: *point,
            truth: settle_reference(&params, frequency_hz, Start::Rest, PLAN)?,
            seen: settle(setting, &params, point.frequency_hz(), Start::Rest, PLAN)?,
        })
    };
    parallel::try_map(points, one)
}

/// Directions of the nudges: around a circle of [`NUDGE_M`] in the plane of displacement and rate/Ω.
pub const NUDGES: usize = 8;

/// The reference from rest, and from [`NUDGES`] starts [`NUDGE_M`] around it.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceEdge {
    /// From rest.
    pub rest: PeriodsOutcome,
    /// From the nudged starts, counter-clockwise from a nudge towards the surface.
    pub nudged: Vec<PeriodsOutcome>,
}

impl ReferenceEdge {
    /// Nudges the reference's start at a compared point.
    ///
    /// # Errors
    /// If a simulation fails, which none of the presets does.
    pub fn of(compared: &Compared) -> Result<Self, Error> {
        let params = compared.point.params();
        let frequency_hz = compared.truth.frequency_hz;
        let nudge = |k: usize| {
            let (sin, cos) = (TAU * k as f64 / NUDGES as f64).sin_cos();
            let rate = NUDGE_M * sin * TAU * frequency_hz;
            let start = Start::Moving(NUDGE_M * cos, rate);
            settle_reference(&params, frequency_hz, start, PLAN)
        };
        Ok(Self {
            rest: compared.truth,
            nudged: (0..NUDGES).map(nudge).collect::<Result<_, _>>()?,
        })
    }

    /// The nudged outcomes that differ from the one from rest: in regime, or in force by more than the
    /// requirement.
    pub fn strayed(&self) -> impl Iterator<Item = &PeriodsOutcome> {
        let rest = &self.rest;
        let strays = move |o: &&PeriodsOutcome| {
            o.regime != rest.regime || o.force_error(rest).abs() > REQUIREMENT
        };
        self.nudged.iter().filter(strays)
    }

    /// Whether a nudge decides where the hammer ends.
    pub fn decides(&self) -> bool {
        self.strayed().next().is_some()
    }
}

/// Median, 95th percentile, largest, and how many exceed [`REQUIREMENT`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorSpread {
    /// Median error.
    pub median: f64,
    /// 95 % of the errors are at most this.
    pub p95: f64,
    /// Largest error.
    pub max: f64,
    /// Errors above [`REQUIREMENT`].
    pub above: usize,
}

impl ErrorSpread {
    /// Of some errors.
    ///
    /// # Panics
    /// If there are none.
    pub fn of(errors: impl Iterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = errors.collect();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len() - 1;
        Self {
            median: sorted[last / 2],
            p95: sorted[(0.95 * last as f64).ceil() as usize],
            max: sorted[last],
            above: sorted
                .iter()
                .filter(|e| **e > REQUIREMENT || e.is_nan())
                .count(),
        }
    }
}
