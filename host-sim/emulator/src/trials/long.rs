//! Long trials: rigs that warm up for ten minutes, while their displacement sensors grow late and all gains drift.
//!
//! The rigs are those of the other trials. What drifts is drawn by itself, and only its direction is: its size is as in
//! [`drift`]. A trial ends with its first trip.

use std::cell::RefCell;

use numerics::progress::Progress;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use serde::Serialize;
use shared::control::State;
use shared::fault::{Fault, Origin};
use shared::model::params::RigParams;

use super::{Believed, START_S, Trial, each, quantile, sorted};
use crate::local::Local;
use crate::optimum::two_bodies_at;
use crate::record::{BlockRow, RunEvent, RunEventKind, RunObserver};
use crate::rig_path::Moment;
use crate::run::Run;
use crate::scenario::{Scenario, parse};
use files::UserError;
use numerics::row::tidy;

/// What drifts from the start to the end of a trial.
pub mod drift {
    /// Natural frequency, %, up or down.
    pub const NATURAL_PERCENT: f64 = 5.0;
    /// How much later the hammer's sensor, the cart's, or both read at the end, ms.
    pub const LAG_MS: f64 = 1.0;
    /// Gain of each sensor, % per minute, up or down.
    pub const GAIN_PERCENT_PER_MIN: f64 = 1.0;
}

/// Beyond this the check `ratio` contradicts: gain of the hammer's sensor over the cart's.
const HAMMER_OVER_CART: (f64, f64) = (0.8, 1.2);
/// Beyond this the check `momentum` contradicts: gain of the force sensor over the hammer's.
const FORCE_OVER_HAMMER: (f64, f64) = (0.75, 1.33);
/// The checks measure these to so much.
const AGREES: f64 = 0.98;

/// Gains of force, hammer and cart.
type Gains = [f64; 3];

/// A long trial: a trial, and what drifts.
#[derive(Clone, Debug, PartialEq)]
pub struct LongTrial {
    /// The rig at the start.
    pub trial: Trial,
    /// By how much its natural frequency has changed at the end, %.
    pub natural_frequency_percent: f64,
    /// How late the sensors of hammer and cart are at the end, ms.
    pub lag_ms: [f64; 2],
    /// How fast the gains of force, hammer and cart change, % per minute.
    pub gain_percent_per_min: Gains,
}

impl LongTrial {
    /// Long trial number `trial` of `seed`: the rig of [`Trial::draw`].
    ///
    /// # Panics
    /// Without a rig.
    pub fn draw(seed: u64, trial: u32, rigs: &[Believed]) -> Self {
        // A stream of its own, so that the rigs are those of the other trials.
        const DRIFTS: u64 = 1 << 32;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(DRIFTS + u64::from(trial));
        let late = random.next_u32() % 3;
        let mut sign = || {
            if random.next_u32() & 1 == 0 {
                1.0
            } else {
                -1.0
            }
        };
        let lag = |is: bool| if is { drift::LAG_MS } else { 0.0 };
        Self {
            trial: Trial::draw(seed, trial, rigs),
            natural_frequency_percent: drift::NATURAL_PERCENT * sign(),
            lag_ms: [lag(late != 1), lag(late != 0)],
            gain_percent_per_min: [(); 3].map(|()| drift::GAIN_PERCENT_PER_MIN * sign()),
        }
    }

    /// The trial as a scenario file that `host-sim emulate` runs, with `seconds` of rig time after the start.
    pub fn to_toml(&self, seconds: f64) -> String {
        let mut text = self.trial.to_toml(START_S + seconds);
        let natural = self.natural_frequency_percent;
        text += &format!(
            "\n[[events]]\nat_s = {START_S:?}\nkind = \"drift\"\nover_s = {seconds:?}\n\
             natural_frequency_percent = {natural:?}\n"
        );
        let mut fault = |sensor: &str, fault: &str, key: &str, value: f64| {
            text += &format!(
                "\n[[events]]\nat_s = {START_S:?}\nkind = \"sensor-fault\"\nsensor = \"{sensor}\"\n\
                 fault = \"{fault}\"\n{key} = {value:?}\n"
            );
        };
        for (sensor, ms) in ["hammer", "cart"].into_iter().zip(self.lag_ms) {
            if ms > 0.0 {
                fault(sensor, "delay-drift", "delay_ms_per_s", ms / seconds);
            }
        }
        let sensors = ["force", "hammer", "cart"].into_iter();
        for (sensor, per_min) in sensors.zip(self.gain_percent_per_min) {
            fault(sensor, "gain-drift", "percent_per_s", per_min / 60.0);
        }
        text
    }

    fn scenario(&self, seconds: f64) -> Result<Scenario, UserError> {
        let name = format!("trial-{}", self.trial.trial);
        parse(&name, &self.to_toml(seconds), &name)
    }

    /// The gains at `time_s` of rig time.
    fn gains(&self, time_s: f64) -> Gains {
        let Trial {
            force_gain_percent,
            hammer_gain_percent,
            cart_gain_percent,
            ..
        } = self.trial;
        let minutes = (time_s - START_S).max(0.0) / 60.0;
        let first = [force_gain_percent, hammer_gain_percent, cart_gain_percent];
        [0, 1, 2].map(|i| {
            let drifted = 1.0 + 0.01 * self.gain_percent_per_min[i] * minutes;
            (1.0 + 0.01 * first[i]) * drifted
        })
    }

    /// Runs the trial, `seconds` of rig time after the start.
    ///
    /// # Errors
    /// If the true rig is out of range.
    pub fn run(&self, seconds: f64) -> Result<LongRow, UserError> {
        let scenario = self.scenario(seconds)?;
        let control = Local::new(&scenario.settings)?;
        let mut run = Run::new(&scenario, control, Watch::default())?;
        for _ in 0..scenario.blocks() {
            run.block();
            if run.observer().tripped {
                break;
            }
        }
        let (summary, watch) = run.finish();
        let start_s = summary.started_s.unwrap_or(START_S);
        let trip = summary.faults.first();
        let trip_s = trip.map(|trip| trip.tick as f64 * scenario.tick_s() - start_s);
        let gains = self.gains(summary.end_s());
        let [force, hammer, cart] = gains;
        // Both means ask for the same moments.
        let known = RefCell::new(Vec::new());
        let best = |moment: &Moment| {
            let time_s = moment.since_s;
            if let Some((_, best)) = known.borrow().iter().find(|(at, _)| *at == time_s) {
                return *best;
            }
            let rig: &RigParams = &moment.rig;
            // The controller holds the amplitude that the cart's sensor reads.
            let as_read_m = rig.amplitude_m / self.gains(time_s)[2];
            let best = two_bodies_at(rig, as_read_m, &scenario.drive(), &scenario.mounting);
            known.borrow_mut().push((time_s, best));
            best
        };
        let share = |which: usize| {
            let held_n = summary.held.force_n()?;
            let best = summary.rigs.mean(|m| m.held_s, |m| best(m)[which])?;
            Some(held_n / best.force_n)
        };
        let limit_n = f64::from(scenario.settings.limits.force_n);
        let trial = &self.trial;
        Ok(LongRow {
            trial: trial.trial,
            rig: trial.rig.name.clone(),
            seed: trial.seed,
            natural_frequency_percent: trial.natural_frequency_percent,
            contact_stiffness_percent: trial.contact_stiffness_percent,
            contact_damping_percent: trial.contact_damping_percent,
            gap_offset_mm: trial.gap_offset_mm,
            force_gain_percent: trial.force_gain_percent,
            hammer_gain_percent: trial.hammer_gain_percent,
            cart_gain_percent: trial.cart_gain_percent,
            natural_frequency_drift_percent: self.natural_frequency_percent,
            hammer_lag_ms: self.lag_ms[0],
            cart_lag_ms: self.lag_ms[1],
            force_gain_drift_percent_per_min: self.gain_percent_per_min[0],
            hammer_gain_drift_percent_per_min: self.gain_percent_per_min[1],
            cart_gain_drift_percent_per_min: self.gain_percent_per_min[2],
            hold_s: summary.hold_s.map(|s| tidy(s - start_s)),
            held: summary.final_state() == State::Hold,
            hold_share: watch.hold_share(),
            trip: trip.map(|trip| trip.fault.name()),
            trip_sensor: trip.and_then(|trip| sensor_name(trip.origin)),
            trip_s: trip_s.map(tidy),
            trip_by_drift: trip
                .map(|trip| trip.fault == Fault::SensorOutOfFamily && contradict_each_other(gains)),
            hammer_over_cart_gain: tidy(hammer / cart),
            force_over_hammer_gain: tidy(force / hammer),
            force_share: share(0),
            force_share_at_amplitude: share(1),
            reseeks: summary.status.map_or(0, |status| status.reseeks),
            largest_force_over_limit: summary.largest_n / limit_n,
        })
    }
}

/// Whether sensors with these gains contradict each other by more than the checks allow.
fn contradict_each_other([force, hammer, cart]: Gains) -> bool {
    let beyond =
        |ratio: f64, (low, high): (f64, f64)| ratio < low / AGREES || ratio > high * AGREES;
    beyond(hammer / cart, HAMMER_OVER_CART) || beyond(force / hammer, FORCE_OVER_HAMMER)
}

fn sensor_name(origin: Origin) -> Option<&'static str> {
    match origin {
        Origin::System => None,
        Origin::Force => Some("force"),
        Origin::Hammer => Some("hammer"),
        Origin::Cart => Some("cart"),
    }
}

/// Whether it tripped, and how long it was in Hold.
#[derive(Debug, Default)]
struct Watch {
    tripped: bool,
    /// Blocks from the first Hold on, and those in Hold.
    since_hold: u64,
    in_hold: u64,
}

impl Watch {
    fn hold_share(&self) -> Option<f64> {
        (self.since_hold > 0).then(|| self.in_hold as f64 / self.since_hold as f64)
    }
}

impl RunObserver for Watch {
    fn block(&mut self, row: &BlockRow) {
        let holds = row.status.state == State::Hold;
        // What comes after a trip is no part of the trial.
        if (holds || self.since_hold > 0) && !self.tripped {
            self.since_hold += 1;
            self.in_hold += u64::from(holds);
        }
    }

    fn event(&mut self, event: &RunEvent) {
        self.tripped |= matches!(event.what, RunEventKind::Fault { .. });
    }
}

/// A line of a table: a long trial and what became of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LongRow {
    /// Its number, from 0.
    pub trial: u32,
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
    natural_frequency_drift_percent: f64,
    hammer_lag_ms: f64,
    cart_lag_ms: f64,
    force_gain_drift_percent_per_min: f64,
    hammer_gain_drift_percent_per_min: f64,
    cart_gain_drift_percent_per_min: f64,
    /// From the start to the first Hold, s.
    pub hold_s: Option<f64>,
    /// Whether it ended in Hold.
    pub held: bool,
    /// Share of the time in Hold, from the first Hold to the end or the trip.
    pub hold_share: Option<f64>,
    /// Name of the fault that tripped.
    pub trip: Option<&'static str>,
    /// The sensor that it named.
    pub trip_sensor: Option<&'static str>,
    /// From the start to the trip, s.
    pub trip_s: Option<f64>,
    /// Whether the gains had drifted so far apart that the sensors' checks must trip.
    pub trip_by_drift: Option<bool>,
    /// Gain of the hammer's sensor over the cart's at the end or the trip.
    pub hammer_over_cart_gain: f64,
    /// Gain of the force sensor over the hammer's at the end or the trip.
    pub force_over_hammer_gain: f64,
    /// Mean true force from the first Hold to the end or the trip, over the mean of the drifting rig's optimum at A0.
    pub force_share: Option<f64>,
    /// As `force_share`, over the optimum at the amplitude that the cart's sensor makes of A0.
    pub force_share_at_amplitude: Option<f64>,
    /// Times 1/1 was lost and sought again.
    pub reseeks: u16,
    /// The largest true force over the force limit.
    pub largest_force_over_limit: f64,
}

/// All long trials together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Campaign {
    /// How many trials there were.
    pub trials: usize,
    /// How many ran to the end without a trip.
    pub without_trip: usize,
    /// How many tripped although the sensors did not contradict each other by more than the checks allow.
    pub false_trips: usize,
    /// How many tripped because they did.
    pub trips_by_drift: usize,
    /// How many ended in Hold.
    pub held: usize,
    /// How many lost 1/1 at least once.
    pub lost: usize,
    /// From the start to Hold: half of the trials are not later, s. None: half of them never held.
    pub hold_median_s: Option<f64>,
    /// The last, s. None: one never held.
    pub hold_last_s: Option<f64>,
    /// Smallest share of the time in Hold from the first Hold on; 0 if a trial never held.
    pub hold_share_worst: Option<f64>,
    /// Median share of the optimum's force at the amplitude as read.
    pub share_median: Option<f64>,
    /// Smallest share of the optimum's force at the amplitude as read; 0 if a trial never held.
    pub share_worst: Option<f64>,
    /// The trial that has it.
    pub share_worst_trial: Option<u32>,
    /// The rig of that trial.
    pub share_worst_rig: Option<String>,
    /// The smallest at A0.
    pub share_at_a0_worst: Option<f64>,
    /// The largest true force of all over the force limit.
    pub largest_force_over_limit: f64,
}

impl Campaign {
    /// Of these rows. A trial that never held counts as the latest and the weakest.
    pub fn of(rows: &[LongRow]) -> Self {
        let count = |is: fn(&LongRow) -> bool| rows.iter().filter(|row| is(row)).count();
        let share = |row: &LongRow| row.force_share_at_amplitude.unwrap_or(0.0);
        let times = sorted(rows, |row| row.hold_s.unwrap_or(f64::INFINITY));
        let shares = sorted(rows, share);
        let weakest = rows.iter().min_by(|a, b| share(a).total_cmp(&share(b)));
        Self {
            trials: rows.len(),
            without_trip: count(|row| row.trip.is_none()),
            false_trips: count(|row| row.trip_by_drift == Some(false)),
            trips_by_drift: count(|row| row.trip_by_drift == Some(true)),
            held: count(|row| row.held),
            lost: count(|row| row.reseeks > 0),
            hold_median_s: quantile(&times, 0.5),
            hold_last_s: quantile(&times, 1.0),
            hold_share_worst: quantile(&sorted(rows, |row| row.hold_share.unwrap_or(0.0)), 0.0),
            share_median: quantile(&shares, 0.5),
            share_worst: quantile(&shares, 0.0),
            share_worst_trial: weakest.map(|row| row.trial),
            share_worst_rig: weakest.map(|row| row.rig.clone()),
            share_at_a0_worst: quantile(&sorted(rows, |row| row.force_share.unwrap_or(0.0)), 0.0),
            largest_force_over_limit: rows
                .iter()
                .map(|row| row.largest_force_over_limit)
                .fold(0.0, f64::max),
        }
    }
}

/// Runs long trials 0 to `count` of `seed` on `rigs` in turn, each `seconds` after its start; a step of `progress` is a
/// trial. The same rows for any number of threads.
///
/// # Errors
/// If a rig is out of range, or the work was interrupted.
pub fn run_all(
    seed: u64,
    count: u32,
    rigs: &[Believed],
    seconds: f64,
    progress: &dyn Progress,
) -> Result<Vec<LongRow>, UserError> {
    each(count, progress, |trial| {
        LongTrial::draw(seed, trial, rigs).run(seconds)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trials::tests::presets;

    #[test]
    fn every_direction_is_drawn_and_the_rigs_are_those_of_the_trials() {
        let rigs = presets();
        let all: Vec<_> = (0..200).map(|k| LongTrial::draw(3, k, &rigs)).collect();
        assert_eq!(all[33].trial, Trial::draw(3, 33, &rigs));
        for lag_ms in [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]] {
            let these = all.iter().filter(|t| t.lag_ms == lag_ms).count();
            assert!(these > 40, "{lag_ms:?}: {these}");
        }
        let up = |sign: fn(&LongTrial) -> f64| all.iter().filter(|t| sign(t) > 0.0).count();
        for up in [
            up(|t| t.natural_frequency_percent),
            up(|t| t.gain_percent_per_min[0]),
            up(|t| t.gain_percent_per_min[1]),
            up(|t| t.gain_percent_per_min[2]),
        ] {
            assert!((70..130).contains(&up), "{up}");
        }
    }

    #[test]
    fn gains_drift_from_the_start_on_and_too_far_apart_they_contradict_each_other() {
        let mut long = LongTrial::draw(3, 0, &presets());
        long.trial.hammer_gain_percent = -5.0;
        long.trial.cart_gain_percent = 5.0;
        long.gain_percent_per_min = [0.0, -1.0, 1.0];
        assert_eq!(long.gains(0.5), long.gains(START_S));
        let [_, hammer, cart] = long.gains(START_S + 600.0);
        assert!((hammer - 0.95 * 0.9).abs() < 1e-12 && (cart - 1.05 * 1.1).abs() < 1e-12);
        assert!(contradict_each_other([hammer, hammer, cart]));
        assert!(!contradict_each_other([1.1, 1.0, 1.15]));
        assert!(contradict_each_other([1.32, 1.0, 1.0]));
    }

    /// Far faster than a sensor drifts, so that 80 s are enough.
    #[test]
    fn a_trip_that_the_drift_justifies_ends_the_trial_and_is_told_as_such() {
        let mut long = LongTrial::draw(3, 3, &presets());
        long.gain_percent_per_min = [0.0, -15.0, 15.0];
        let row = long.run(80.0).expect("a run");
        assert_eq!(row.trip, Some("sensor-out-of-family"), "{row:?}");
        assert_eq!(row.trip_by_drift, Some(true), "{row:?}");
        // At 0.777 for this rig; a sensor that comes to be 1 ms late hides some 5 % until that is learnt.
        assert!((0.7..0.82).contains(&row.hammer_over_cart_gain), "{row:?}");
        assert!(
            row.trip_s.is_some_and(|s| (20.0..80.0).contains(&s)),
            "{row:?}"
        );
        // The force until the trip counts, and Hold until then.
        assert!(row.hold_share.is_some_and(|share| share > 0.9), "{row:?}");
        let share = row.force_share_at_amplitude;
        assert!(share.is_some_and(|share| share > 0.9), "{row:?}");
        let all = Campaign::of(&[row]);
        assert_eq!(
            (all.without_trip, all.trips_by_drift, all.false_trips),
            (0, 1, 0)
        );
    }

    /// One gain less than the check allows, and a sensor 0.9 ms late: hammer over cart was taken for a fifth too little, and
    /// force over hammer for a quarter.
    #[test]
    fn a_late_sensor_is_no_gain_beyond_its_range() {
        let row = LongTrial::draw(1, 31, &presets()).run(600.0);
        let row = row.expect("a run");
        assert_ne!(row.trip_by_drift, Some(false), "{row:?}");
    }

    #[test]
    fn what_drifts_is_in_the_scenario() {
        let long = LongTrial::draw(3, 1, &presets());
        let scenario = long.scenario(120.0).expect("a scenario");
        assert_eq!(scenario.duration_s, 121.0);
        let changes: Vec<_> = scenario
            .events
            .iter()
            .filter_map(|e| e.act.change())
            .collect();
        assert_eq!(changes.len(), 1);
        let (change, over_s) = changes[0];
        assert_eq!(over_s, 120.0);
        assert_eq!(
            change.natural_frequency_percent,
            long.natural_frequency_percent
        );
        let late = long.lag_ms.iter().filter(|ms| **ms > 0.0).count();
        let defects = scenario
            .events
            .iter()
            .flat_map(|e| e.act.defects())
            .flatten();
        assert_eq!(defects.count(), 3 + late);
    }
}
