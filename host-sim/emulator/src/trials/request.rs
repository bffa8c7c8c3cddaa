//! What is asked for, and the whole answer.

use files::UserError;
use files::range::within;
use numerics::NamedRig;
use numerics::progress::Progress;
use serde::Serialize;

use super::long::{self, Campaign, LongRow, LongTrial};
use super::{Believed, Distribution, Trial, TrialOutcome, run_all};

/// Rig time of a trial, s: from 20 s, in which every trial should hold, to an hour.
const DURATION_S: (f64, f64) = (20.0, 3600.0);
/// Most trials of one request.
const MOST: u32 = 100_000;

/// How many trials, how long, and on which random numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrialsRequest {
    /// Number of trials, on the rigs in turn.
    pub count: u32,
    /// Rig time of each, s: of a long trial, after the start.
    pub seconds: f64,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Whether the trials are long ones.
    pub long: bool,
}

impl TrialsRequest {
    /// With what is usual where nothing is given: 200 trials of 60 s, or 40 `long` ones of 600 s.
    ///
    /// # Errors
    /// If a number is out of its range.
    pub fn new(
        long: bool,
        count: Option<u32>,
        seconds: Option<f64>,
        seed: u64,
    ) -> Result<Self, UserError> {
        let (usual, usual_s) = if long { (40, 600.0) } else { (200, 60.0) };
        let (least, most) = DURATION_S;
        Ok(Self {
            seconds: within("--seconds", seconds.unwrap_or(usual_s), least, most)?,
            count: within("--count", count.unwrap_or(usual), 1, MOST)?,
            seed,
            long,
        })
    }

    /// Trial `number` on `rigs` as a scenario file.
    pub fn scenario(&self, number: u32, rigs: &[NamedRig]) -> String {
        let believed = believed(rigs);
        if self.long {
            LongTrial::draw(self.seed, number, &believed).to_toml(self.seconds)
        } else {
            Trial::draw(self.seed, number, &believed).to_toml(self.seconds)
        }
    }

    /// Runs the trials on `rigs`; a step of `progress` is a trial.
    ///
    /// # Errors
    /// As [`run_all`].
    pub fn run(&self, rigs: &[NamedRig], progress: &dyn Progress) -> Result<Trials, UserError> {
        let believed = believed(rigs);
        let trials = run_all(self.seed, self.count, &believed, self.seconds, progress)?;
        let of = |rig: &str, these: &[TrialOutcome]| RigTrials {
            rig: rig.to_owned(),
            distribution: Distribution::of(these),
        };
        let own = |rig: &NamedRig| {
            let these = trials.iter().filter(|o| o.rig == rig.name);
            of(&rig.name, &these.cloned().collect::<Vec<_>>())
        };
        let mut distributions: Vec<_> = rigs.iter().map(own).collect();
        if rigs.len() > 1 {
            distributions.push(of("all", &trials));
        }
        Ok(Trials {
            seed: self.seed,
            seconds_s: self.seconds,
            distributions,
            trials,
        })
    }

    /// Runs long trials on `rigs`, during which the rigs drift ([`long::drift`]); a step of `progress` is a trial.
    ///
    /// # Errors
    /// As [`long::run_all`].
    pub fn run_long(
        &self,
        rigs: &[NamedRig],
        progress: &dyn Progress,
    ) -> Result<LongTrials, UserError> {
        let believed = believed(rigs);
        let trials = long::run_all(self.seed, self.count, &believed, self.seconds, progress)?;
        Ok(LongTrials {
            seed: self.seed,
            seconds_s: self.seconds,
            campaign: Campaign::of(&trials),
            trials,
        })
    }
}

fn believed(rigs: &[NamedRig]) -> Vec<Believed> {
    rigs.iter().map(Believed::new).collect()
}

/// All trials of a rig, or of all.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RigTrials {
    /// Name of the rig, or "all".
    pub rig: String,
    /// What became of them together.
    #[serde(flatten)]
    pub distribution: Distribution,
}

/// What trials showed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Trials {
    /// Seed of the random numbers.
    pub seed: u64,
    /// Rig time of each trial, s.
    pub seconds_s: f64,
    /// Each rig that was tried, then all of them.
    pub distributions: Vec<RigTrials>,
    /// Each trial.
    pub trials: Vec<TrialOutcome>,
}

/// What long trials showed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LongTrials {
    /// Seed of the random numbers.
    pub seed: u64,
    /// Rig time of each trial after the start, s.
    pub seconds_s: f64,
    /// All trials together.
    pub campaign: Campaign,
    /// Each trial.
    pub trials: Vec<LongRow>,
}
