//! Trials: the controller on many rigs that differ at random from what it believes.
//!
//! Each trial draws the true rig and the sensors' gains, starts the controller cold, and is judged by the plant's truth:
//! how soon it held, and what share of the true optimum's force was there from then on.

pub mod long;
mod request;

use numerics::progress::Progress;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use rayon::prelude::*;
use serde::Serialize;
use shared::control::State;
use shared::model::cart::CartDrive;
use shared::model::params::preset;

use crate::local::Local;
use crate::optimum::two_bodies_at;
use crate::run::run;
use crate::scenario::{MOST_FORCE_N, Scenario, parse};
use crate::verdict::{Best, judge_by};
use files::{UserError, rigfile};
use numerics::NamedRig;
pub use request::{LongTrials, RigTrials, Trials, TrialsRequest};

/// Rig time before the start, s.
const START_S: f64 = 1.0;

/// What is drawn: the largest distance from what the controller believes, either way (the gap: from and to).
pub mod spread {
    /// True natural frequency from the believed one, %.
    pub const NATURAL_PERCENT: f64 = 10.0;
    /// Contact stiffness and damping, %.
    pub const CONTACT_PERCENT: f64 = 50.0;
    /// True gap less the believed one, mm: from and to.
    pub const GAP_MM: (f64, f64) = (-0.2, 1.0);
    /// Gain of each sensor, %.
    pub const GAIN_PERCENT: f64 = 5.0;
    /// Noise of every sensor, %.
    pub const NOISE_PERCENT: f64 = 2.0;
}

/// A rig that the controller believes in.
#[derive(Clone, Debug, PartialEq)]
pub struct Believed {
    /// Name of the rig.
    pub name: String,
    /// The lines of `[true_rig]` that describe it.
    keys: String,
    /// The table of its shaker; nothing: the usual one.
    shaker: String,
}

impl Believed {
    /// `rig`; its shaker is the usual one where none is known.
    pub fn new(rig: &NamedRig) -> Self {
        let name = rig.name.clone();
        if preset(&name) == Some(rig.params) {
            let keys = format!("preset = \"{name}\"\n");
            let shaker = String::new();
            return Self { name, keys, shaker };
        }
        let shaker = match rig.recoiling().map(|rig| rig.params.cart) {
            Some(CartDrive::Loop(held)) => format!(
                "[shaker]\nloop_hz = {:?}\nloop_damping_ratio = {:?}\nfeed_forward = {:?}\nforce_n = {:?}\n\n",
                held.frequency_hz,
                held.damping_ratio,
                held.feed_forward,
                // A rig file without one leaves it unlimited.
                held.max_force_n.min(MOST_FORCE_N)
            ),
            _ => String::new(),
        };
        let keys = rigfile::lines(&rig.clone().prescribed().params);
        Self { name, keys, shaker }
    }
}

/// A trial: which rig, and how it differs from what the controller believes.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// Its number, from 0.
    pub trial: u32,
    /// What the controller believes in.
    pub rig: Believed,
    /// Seed of the noise.
    pub seed: u32,
    /// True natural frequency over the believed one, % more.
    pub natural_frequency_percent: f64,
    /// True contact stiffness, % more.
    pub contact_stiffness_percent: f64,
    /// True contact damping, % more.
    pub contact_damping_percent: f64,
    /// True gap less the believed one, mm.
    pub gap_offset_mm: f64,
    /// By how much the force sensor reads too much, %.
    pub force_gain_percent: f64,
    /// By how much the hammer's displacement sensor reads too much, %.
    pub hammer_gain_percent: f64,
    /// By how much the cart's displacement sensor reads too much, %.
    pub cart_gain_percent: f64,
}

impl Trial {
    /// Trial number `trial` of `seed`, on one of `rigs` in turn. Each number is drawn by itself: more trials change none
    /// of those before.
    ///
    /// # Panics
    /// Without a rig.
    pub fn draw(seed: u64, trial: u32, rigs: &[Believed]) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(u64::from(trial));
        let mut within = |from: f64, to: f64| {
            let unit = random.next_u32() as f64 / f64::from(u32::MAX);
            // Six digits are enough, and read well.
            let value = from + (to - from) * unit;
            (value * 1e6).round() / 1e6
        };
        let (contact, gain) = (spread::CONTACT_PERCENT, spread::GAIN_PERCENT);
        let natural = spread::NATURAL_PERCENT;
        Self {
            trial,
            rig: rigs[trial as usize % rigs.len()].clone(),
            natural_frequency_percent: within(-natural, natural),
            contact_stiffness_percent: within(-contact, contact),
            contact_damping_percent: within(-contact, contact),
            gap_offset_mm: within(spread::GAP_MM.0, spread::GAP_MM.1),
            force_gain_percent: within(-gain, gain),
            hammer_gain_percent: within(-gain, gain),
            cart_gain_percent: within(-gain, gain),
            seed: random.next_u32(),
        }
    }

    /// The trial as a scenario file that `host-sim emulate` runs.
    pub fn to_toml(&self, duration_s: f64) -> String {
        let Self {
            trial,
            rig,
            seed,
            natural_frequency_percent: natural,
            contact_stiffness_percent: stiffness,
            contact_damping_percent: damping,
            gap_offset_mm: gap,
            force_gain_percent: force,
            hammer_gain_percent: hammer,
            cart_gain_percent: cart,
        } = self;
        let Believed { keys, shaker, .. } = rig;
        let noise = spread::NOISE_PERCENT;
        format!(
            "name = \"trial-{trial}\"\nduration_s = {duration_s:?}\nseed = {seed}\n\n\
             [true_rig]\n{keys}natural_frequency_percent = {natural:?}\n\
             contact_stiffness_percent = {stiffness:?}\ncontact_damping_percent = {damping:?}\n\
             gap_offset_mm = {gap:?}\n\n{shaker}[sensors]\nnoise_percent = {noise:?}\nforce_gain_percent = {force:?}\n\
             hammer_gain_percent = {hammer:?}\ncart_gain_percent = {cart:?}\n\n\
             [[events]]\nat_s = {START_S:?}\nkind = \"start\"\n"
        )
    }

    fn scenario(&self, duration_s: f64) -> Result<Scenario, UserError> {
        let name = format!("trial-{}", self.trial);
        parse(&name, &self.to_toml(duration_s), &name)
    }

    /// Runs the trial.
    ///
    /// # Errors
    /// If the true rig is out of range.
    pub fn run(&self, duration_s: f64) -> Result<TrialOutcome, UserError> {
        let scenario = self.scenario(duration_s)?;
        let mut control = Local::new(&scenario.settings)?;
        let summary = run(&scenario, &mut control, &mut ())?;
        // The controller holds the amplitude that the cart's sensor reads.
        let rig = &scenario.true_rig;
        let as_read_m = rig.amplitude_m / (1.0 + 0.01 * self.cart_gain_percent);
        let [best, best_as_read] =
            two_bodies_at(rig, as_read_m, &scenario.drive(), &scenario.mounting);
        let verdict = judge_by(
            &scenario,
            &summary,
            Best {
                held: best,
                asked: best,
                prescribed: None,
            },
        );
        let held_n = verdict.force_ratio_mean.map(|ratio| ratio * rig.weight_n());
        let names = verdict.faults.iter().map(|fault| fault.name);
        Ok(TrialOutcome {
            trial: self.trial,
            rig: self.rig.name.clone(),
            seed: self.seed,
            natural_frequency_percent: self.natural_frequency_percent,
            contact_stiffness_percent: self.contact_stiffness_percent,
            contact_damping_percent: self.contact_damping_percent,
            gap_offset_mm: self.gap_offset_mm,
            force_gain_percent: self.force_gain_percent,
            hammer_gain_percent: self.hammer_gain_percent,
            cart_gain_percent: self.cart_gain_percent,
            hold_s: verdict.time_to_hold_s,
            held: summary.final_state() == State::Hold,
            force_share: verdict.force_share,
            force_share_at_amplitude: held_n.zip(best_as_read).map(|(n, best)| n / best.force_n),
            frequency_hz: verdict.frequency_hz,
            optimum_frequency_hz: verdict.optimum_frequency_hz,
            reseeks: verdict.reseeks,
            faults: names.collect::<Vec<_>>().join(" "),
        })
    }
}

/// A line of a table: a trial and what became of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrialOutcome {
    trial: u32,
    /// What the controller believed in.
    pub rig: String,
    seed: u32,
    natural_frequency_percent: f64,
    contact_stiffness_percent: f64,
    contact_damping_percent: f64,
    gap_offset_mm: f64,
    force_gain_percent: f64,
    hammer_gain_percent: f64,
    cart_gain_percent: f64,
    /// From the start to the first Hold, s.
    pub hold_s: Option<f64>,
    /// Whether it ended in Hold.
    pub held: bool,
    /// Mean true force from the first Hold on over the true rig's optimum at A0.
    pub force_share: Option<f64>,
    /// Mean true force from the first Hold on over the true rig's optimum at the amplitude that the cart's sensor makes
    /// of A0: no controller can know that its gain is wrong.
    pub force_share_at_amplitude: Option<f64>,
    /// Mean frequency from the first Hold on, Hz.
    pub frequency_hz: Option<f64>,
    /// The true rig's optimum, Hz.
    pub optimum_frequency_hz: Option<f64>,
    /// Times 1/1 was lost and sought again.
    pub reseeks: u16,
    /// Names of the faults.
    pub faults: String,
}

/// What became of all trials together: counts and quantiles.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Distribution {
    /// How many trials there were.
    pub trials: usize,
    /// How many ended in Hold.
    pub held: usize,
    /// How many had a fault.
    pub faults: usize,
    /// How many lost 1/1 at least once.
    pub lost: usize,
    /// From the start to Hold: half of the trials are not later, s. None: half of them never held.
    pub hold_median_s: Option<f64>,
    /// From the start to Hold: 95 of 100 trials are not later, s. None: fewer than that ever held.
    pub hold_95_s: Option<f64>,
    /// From the start to Hold: the latest trial, s. None: one never held.
    pub hold_last_s: Option<f64>,
    /// Median share of the optimum's force at the amplitude as read, from Hold on.
    pub share_median: Option<f64>,
    /// 5 of 100 trials have at most this share.
    pub share_5: Option<f64>,
    /// Smallest share of the optimum's force at the amplitude as read; 0 if a trial never held.
    pub share_worst: Option<f64>,
    /// Median share of the optimum's force at A0.
    pub share_at_a0_median: Option<f64>,
    /// Smallest share of the optimum's force at A0; 0 if a trial never held.
    pub share_at_a0_worst: Option<f64>,
}

impl Distribution {
    /// Of these outcomes. A trial that never held counts as the latest and the weakest.
    pub fn of(outcomes: &[TrialOutcome]) -> Self {
        let times = sorted(outcomes, |o| o.hold_s.unwrap_or(f64::INFINITY));
        let shares = sorted(outcomes, |o| o.force_share_at_amplitude.unwrap_or(0.0));
        let at_a0 = sorted(outcomes, |o| o.force_share.unwrap_or(0.0));
        let count = |is: fn(&TrialOutcome) -> bool| outcomes.iter().filter(|o| is(o)).count();
        Self {
            trials: outcomes.len(),
            held: count(|o| o.held),
            faults: count(|o| !o.faults.is_empty()),
            lost: count(|o| o.reseeks > 0),
            hold_median_s: quantile(&times, 0.5),
            hold_95_s: quantile(&times, 0.95),
            hold_last_s: quantile(&times, 1.0),
            share_median: quantile(&shares, 0.5),
            share_5: quantile(&shares, 0.05),
            share_worst: quantile(&shares, 0.0),
            share_at_a0_median: quantile(&at_a0, 0.5),
            share_at_a0_worst: quantile(&at_a0, 0.0),
        }
    }
}

fn sorted<T>(rows: &[T], value: impl Fn(&T) -> f64) -> Vec<f64> {
    let mut values: Vec<f64> = rows.iter().map(value).collect();
    values.sort_by(f64::total_cmp);
    values
}

/// The value that a share of the sorted values does not exceed; none if it is infinite.
fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let rank = (share * sorted.len() as f64).ceil() as usize;
    let value = sorted[rank.saturating_sub(1).min(last)];
    value.is_finite().then_some(value)
}

/// Runs trials 0 to `count` of `seed` on `rigs` in turn, `duration_s` of rig time each; a step of `progress` is a trial.
/// The same outcomes for any number of threads.
///
/// # Errors
/// If a rig is out of range, or the work was interrupted.
pub fn run_all(
    seed: u64,
    count: u32,
    rigs: &[Believed],
    duration_s: f64,
    progress: &dyn Progress,
) -> Result<Vec<TrialOutcome>, UserError> {
    each(count, progress, |trial| {
        Trial::draw(seed, trial, rigs).run(duration_s)
    })
}

/// Runs trials 0 to `count`, as many at a time as there are threads; their outcomes in their order.
fn each<T: Send>(
    count: u32,
    progress: &dyn Progress,
    run: impl Fn(u32) -> Result<T, UserError> + Sync,
) -> Result<Vec<T>, UserError> {
    (0..count)
        .into_par_iter()
        // Trials differ in length: each by itself, so that no thread is left with the last of them.
        .with_max_len(1)
        .map(|trial| {
            if progress.interrupted() {
                return Err(numerics::Error::Interrupted.into());
            }
            let outcome = run(trial);
            progress.advance(1);
            outcome
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn presets() -> Vec<Believed> {
        NamedRig::presets().iter().map(Believed::new).collect()
    }

    #[test]
    fn trials_are_drawn_one_by_one_within_their_ranges() {
        let rigs = presets();
        let all: Vec<_> = (0..400).map(|k| Trial::draw(7, k, &rigs)).collect();
        assert_eq!(all[33], Trial::draw(7, 33, &rigs));
        assert_ne!(all[33].seed, Trial::draw(8, 33, &rigs).seed);
        let range = |value: fn(&Trial) -> f64| {
            let values = all.iter().map(value);
            let low = values.clone().fold(f64::INFINITY, f64::min);
            (low, values.fold(f64::NEG_INFINITY, f64::max))
        };
        let (low, high) = range(|t| t.gap_offset_mm);
        assert!((-0.2..-0.18).contains(&low) && (0.98..=1.0).contains(&high));
        let (low, high) = range(|t| t.natural_frequency_percent);
        assert!((-10.0..-9.8).contains(&low) && (9.8..=10.0).contains(&high));
        for rig in &rigs {
            assert_eq!(all.iter().filter(|t| t.rig.name == rig.name).count(), 100);
        }
    }

    #[test]
    fn quantiles_are_values_that_occurred() {
        let values: Vec<f64> = (1..=20).map(f64::from).collect();
        assert_eq!(quantile(&values, 0.5), Some(10.0));
        assert_eq!(quantile(&values, 0.95), Some(19.0));
        assert_eq!(quantile(&values, 1.0), Some(20.0));
        assert_eq!(quantile(&values, 0.0), Some(1.0));
        assert_eq!(quantile(&[], 0.5), None);
        assert_eq!(quantile(&[1.0, f64::INFINITY], 1.0), None);
    }

    #[test]
    fn a_trial_is_a_scenario_file_with_its_own_numbers() {
        let trial = Trial::draw(1, 2, &presets());
        let scenario = trial.scenario(30.0).expect("a scenario");
        let believed = scenario.settings.rig;
        let factor = scenario.true_rig.natural_frequency_hz() / believed.natural_frequency_hz();
        assert!((factor - 1.0 - 0.01 * trial.natural_frequency_percent).abs() < 1e-9);
        let gap_mm = 1e3 * (scenario.true_rig.gap_m - believed.gap_m);
        assert!((gap_mm - trial.gap_offset_mm).abs() < 1e-9);
        assert_eq!(scenario.duration_s, 30.0);
    }
    /// The controller believes in the file's rig and its shaker; what is drawn is on top of the true one.
    #[test]
    fn a_rig_of_one_s_own_is_what_the_controller_believes_in() {
        let settings = [
            "mass_kg=1.7",
            "gap_mm=0.5",
            "shaker_loop_hz=30",
            "shaker_damping_ratio=3.0",
        ]
        .map(str::to_owned);
        let rig = rigfile::load("wires", &settings).unwrap();
        let trial = Trial::draw(1, 0, &[Believed::new(&rig)]);
        let scenario = trial.scenario(30.0).expect("a scenario");
        let believed = scenario.settings.rig;
        assert_eq!((believed.mass_kg, believed.gap_m), (1.7, 0.5e-3));
        assert_eq!(scenario.shaker.loop_hz, 30.0);
        assert_eq!(scenario.shaker.loop_damping_ratio, 3.0);
        let gap_mm = 1e3 * (scenario.true_rig.gap_m - believed.gap_m);
        assert!((gap_mm - trial.gap_offset_mm).abs() < 1e-9);
    }
}
