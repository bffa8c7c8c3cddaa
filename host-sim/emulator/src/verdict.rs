//! Whether a run did what it had to, judged by the true contact force and never by the sensor's.

use std::cell::RefCell;

use serde::Serialize;
use shared::control::Basin;
use shared::model::params::RigParams;

use super::cart::Mounting;
use super::names::{basin_name, state_name};
use super::optimum::{Optimum, prescribed, two_bodies};
use super::plant::ShakerDrive;
use super::scenario::{Expect, Scenario};
use super::summary::RunSummary;
use numerics::row::tidy;

/// More than this share of the optimum's force is not held but wrong, unless the scenario says otherwise.
const MOST_FORCE_SHARE: f64 = 1.02;

/// A fault of a verdict.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FaultLine {
    /// Number of the fault, as the link sends it.
    pub code: u8,
    /// Name of the fault, as scenarios write it.
    pub name: &'static str,
    /// When its condition was seen, s of rig time.
    pub at_s: f64,
    /// Ticks from then until the drive was off; none: it never was.
    pub drive_off_after_ticks: Option<u64>,
    /// Ticks from the scenario's last event until the drive was off.
    pub drive_off_after_injection_ticks: Option<u64>,
}

/// The verdict on a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// Name of the scenario.
    pub scenario: String,
    /// `pass`, or `fail` if an expectation was not met.
    pub verdict: &'static str,
    /// Expectations that were not met; empty for a pass.
    pub why: Vec<String>,
    /// The controller's state at the end.
    pub final_state: &'static str,
    /// From the first start to Hold, s.
    pub time_to_hold_s: Option<f64>,
    /// Mean drive frequency in Hold, Hz.
    pub frequency_hz: Option<f64>,
    /// Mean over the drive periods from the first Hold on of the largest true force, over the hammer's weight. It
    /// counts whenever the controller is asked to run (from a start to a stop); the force of a drive that is off is
    /// none.
    pub force_ratio_mean: Option<f64>,
    /// The true rig's optimum ([`super::optimum`]), Hz: with its cart's recoil, unless the scenario prescribes the
    /// cart's motion. Of a rig that changes: mean over the same time.
    pub optimum_frequency_hz: Option<f64>,
    /// Largest force of a drive period at that optimum, over the hammer's weight.
    pub optimum_force_ratio: Option<f64>,
    /// Force from the first Hold on over the optimum's.
    pub force_share: Option<f64>,
    /// Force from the first start on over the optimum's.
    pub share_from_start: Option<f64>,
    /// The true rig's optimum if its cart did not recoil (`pick --nominal`), Hz.
    pub prescribed_optimum_frequency_hz: Option<f64>,
    /// Largest force of a drive period at that optimum, over the hammer's weight.
    pub prescribed_optimum_force_ratio: Option<f64>,
    /// Faults, as they tripped.
    pub faults: Vec<FaultLine>,
    /// Overruns of the control task.
    pub overruns: u32,
    /// Times the regime was lost and sought again.
    pub reseeks: u16,
    /// Which basin the last disturbance ended in, as the controller says.
    pub basin: &'static str,
    /// The true basin: whether there was contact in the last twenty drive periods.
    pub true_basin: &'static str,
    /// How many contacts there were in the run.
    pub contacts: u64,
    /// Largest true force, over the hammer's weight.
    pub largest_force_ratio: f64,
    /// Largest true force, N.
    pub largest_force_n: f64,
    /// Largest displacement of the hammer relative to the cart, mm.
    pub largest_travel_mm: f64,
    /// Largest true displacement of the cart, fixed frame, mm.
    pub largest_cart_mm: f64,
    /// Longest time for which the drive stayed powered while a fault of the scenario was present, s.
    pub driven_with_fault_s: f64,
    /// Length of the run, s of rig time.
    pub duration_s: f64,
    /// Rate of penetration from the first Hold on, µm/s; none without ground that gives way.
    pub rate_of_penetration_um_per_s: Option<f64>,
    /// How far the ground gave way, mm.
    pub progress_mm: Option<f64>,
    /// Why the controller was not told the shaker's position loop, where its settings do not take it: its forecast then has
    /// a cart that does not recoil.
    pub loop_left_out: Option<String>,
}

/// The best the true rig can do: means over the time that counts, of a rig that changes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Best {
    /// From the first Hold on.
    pub held: Option<Optimum>,
    /// From the first start on.
    pub asked: Option<Optimum>,
    /// From the first Hold on, under prescribed motion.
    pub prescribed: Option<Optimum>,
}

fn best_of_run(scenario: &Scenario, summary: &RunSummary) -> Best {
    let known = RefCell::new(Vec::new());
    let plain = |rig: &RigParams| {
        prescribed(rig).map(|(_, orbit)| Optimum {
            frequency_hz: orbit.frequency_hz,
            force_n: orbit.force_n,
        })
    };
    // The rigs are level already.
    let level = Mounting {
        tilt_rad: 0.0,
        ..scenario.mounting
    };
    // Both means ask for the same rigs.
    let full = |rig: &RigParams| {
        if let Some((_, best)) = known.borrow().iter().find(|(known, _)| known == rig) {
            return *best;
        }
        let best = match scenario.drive() {
            ShakerDrive::Shaker(shaker) => two_bodies(rig, &ShakerDrive::Shaker(shaker), &level),
            ShakerDrive::Prescribed => plain(rig),
            // A stiff crank prescribes the motion.
            ShakerDrive::Motor(motor) => plain(&RigParams {
                amplitude_m: motor.crank_m,
                ..*rig
            }),
        };
        known.borrow_mut().push((*rig, best));
        best
    };
    Best {
        held: summary.rigs.mean(|m| m.held_s, |m| full(&m.rig)),
        asked: summary.rigs.mean(|m| m.asked_s, |m| full(&m.rig)),
        prescribed: summary.rigs.mean(|m| m.held_s, |m| plain(&m.rig)),
    }
}

/// Whether the hammer strikes at the end of the run.
fn true_basin(summary: &RunSummary) -> Basin {
    const PERIODS: f64 = 20.0;
    let hz = summary.status.map_or(0.0, |s| f64::from(s.frequency_hz));
    let strikes = summary
        .last_contact_s
        .is_some_and(|last| (summary.end_s() - last) * hz < PERIODS);
    if strikes {
        Basin::Impact
    } else {
        Basin::NoImpact
    }
}

/// Judges a run of `scenario`. Searches the true rig's optimum, which takes seconds.
pub fn judge(scenario: &Scenario, summary: &RunSummary) -> Verdict {
    judge_by(scenario, summary, best_of_run(scenario, summary))
}

/// Judges a run of `scenario` by a known optimum.
pub fn judge_by(scenario: &Scenario, summary: &RunSummary, best: Best) -> Verdict {
    let weight = scenario.true_rig.weight_n();
    let Best {
        held: best,
        asked,
        prescribed,
    } = best;
    let (force_n, asked_n) = (summary.held.force_n(), summary.asked.force_n());
    let periods = summary.hold_periods;
    let status = summary.status;
    let tick_s = scenario.tick_s();
    let faults = summary.faults.iter().map(|f| FaultLine {
        code: f.fault.code(),
        name: f.fault.name(),
        at_s: tidy(f.tick as f64 * tick_s),
        drive_off_after_ticks: f.off_after,
        drive_off_after_injection_ticks: f
            .off_after
            .zip(f.injected)
            .map(|(off, at)| (f.tick + off).saturating_sub(at)),
    });
    let mut verdict = Verdict {
        scenario: scenario.name.clone(),
        verdict: "pass",
        why: Vec::new(),
        final_state: state_name(summary.final_state()),
        time_to_hold_s: summary
            .hold_s
            .zip(summary.started_s)
            .map(|(hold, start)| tidy(hold - start)),
        frequency_hz: (periods > 0).then(|| summary.hold_hz / periods as f64),
        force_ratio_mean: force_n.map(|n| n / weight),
        optimum_frequency_hz: best.map(|b| b.frequency_hz),
        optimum_force_ratio: best.map(|b| b.force_n / weight),
        force_share: force_n.zip(best).map(|(n, b)| n / b.force_n),
        share_from_start: asked_n.zip(asked).map(|(n, b)| n / b.force_n),
        prescribed_optimum_frequency_hz: prescribed.map(|b| b.frequency_hz),
        prescribed_optimum_force_ratio: prescribed.map(|b| b.force_n / weight),
        faults: faults.collect(),
        overruns: status.map_or(0, |s| s.overruns),
        reseeks: status.map_or(0, |s| s.reseeks),
        basin: basin_name(status.map_or(Basin::Unknown, |s| s.basin)),
        true_basin: basin_name(true_basin(summary)),
        contacts: summary.contacts,
        largest_force_ratio: summary.largest_n / weight,
        largest_force_n: summary.largest_n,
        largest_travel_mm: 1e3 * summary.largest_travel_m,
        largest_cart_mm: 1e3 * summary.largest_cart_m,
        driven_with_fault_s: tidy(summary.driven_with_fault_s),
        duration_s: tidy(summary.end_s()),
        rate_of_penetration_um_per_s: scenario
            .ground
            .and_then(|_| Some(1e6 * summary.rate_of_penetration()?)),
        progress_mm: scenario.ground.map(|_| 1e3 * summary.progress_m[1]),
        loop_left_out: scenario.loop_left_out.map(|why| why.to_string()),
    };
    verdict.why = complaints(&scenario.expect, summary.finite, &verdict);
    if !verdict.why.is_empty() {
        verdict.verdict = "fail";
    }
    verdict
}

/// Expectations that were not met.
fn complaints(expect: &Expect, finite: bool, verdict: &Verdict) -> Vec<String> {
    let mut why = wrong_words(expect, verdict);
    wrong_numbers(expect, verdict, &mut why);
    if !finite {
        why.push("the controller put out what is not a number".into());
    }
    why
}

/// State, basin and faults.
fn wrong_words(expect: &Expect, verdict: &Verdict) -> Vec<String> {
    let mut why = Vec::new();
    let mut word = |what: &str, want: Option<&str>, got: &str| {
        if let Some(want) = want
            && want != got
        {
            why.push(format!("{what} is {got}, expected {want}"));
        }
    };
    let (state, basin) = (
        expect.final_state.map(state_name),
        expect.basin.map(basin_name),
    );
    word("final state", state, verdict.final_state);
    word("basin", basin, verdict.basin);
    word("true basin", basin, verdict.true_basin);
    let tripped: Vec<_> = verdict.faults.iter().map(|f| f.name).collect();
    let wanted: Vec<_> = expect.faults.iter().map(|f| f.name()).collect();
    if tripped != wanted {
        let list = |names: &[&str]| match names {
            [] => "none".to_owned(),
            names => names.join(", "),
        };
        why.push(format!(
            "faults: {}, expected {}",
            list(&tripped),
            list(&wanted)
        ));
    }
    why
}

/// Force, times and counts.
fn wrong_numbers(expect: &Expect, verdict: &Verdict, why: &mut Vec<String>) {
    let number = |x: Option<f64>| x.map_or("none".to_owned(), |x| format!("{x:.4}"));
    // What is not known fails; with an upper bound only where the scenario asks for it.
    let mut at_least = |what: &str, got: Option<f64>, least: Option<f64>| {
        if let Some(least) = least
            && got.is_none_or(|got| got < least)
        {
            why.push(format!(
                "{what} is {}, expected at least {least}",
                number(got)
            ));
        }
    };
    at_least("force share", verdict.force_share, expect.min_force_share);
    at_least(
        "share from the start",
        verdict.share_from_start,
        expect.min_share_from_start,
    );
    at_least(
        "rate of penetration, µm/s",
        verdict.rate_of_penetration_um_per_s,
        expect.min_progress_um_per_s,
    );
    let mut at_most = |what: &str, got: Option<f64>, most: Option<f64>, unit: &str| {
        if let Some(most) = most
            && got.is_none_or(|got| got > most)
        {
            let got = number(got);
            why.push(format!("{what} is {got}{unit}, expected at most {most}"));
        }
    };
    let most_share = expect.max_force_share.unwrap_or(MOST_FORCE_SHARE);
    let share = verdict.force_share;
    at_most("force share", share, share.map(|_| most_share), "");
    let time = verdict.time_to_hold_s;
    at_most("time to Hold", time, expect.hold_within_s, " s");
    let force = Some(verdict.largest_force_n);
    at_most("largest true force", force, expect.max_true_force_n, " N");
    let cart = Some(verdict.largest_cart_mm);
    at_most(
        "largest true cart displacement",
        cart,
        expect.max_true_cart_mm,
        " mm",
    );
    let driven = Some(verdict.driven_with_fault_s);
    let most = expect.max_driven_with_fault_s;
    at_most(
        "longest time driven with a fault present",
        driven,
        most,
        " s",
    );
    if let Some(least) = expect.min_reseeks
        && verdict.reseeks < least
    {
        why.push(format!(
            "{} reseeks, expected at least {least}",
            verdict.reseeks
        ));
    }
    if let Some(most) = expect.drive_off_within_ticks {
        for fault in &verdict.faults {
            if fault.drive_off_after_ticks.is_none_or(|t| t > most) {
                let ticks = number(fault.drive_off_after_ticks.map(|t| t as f64));
                why.push(format!(
                    "{}: drive off after {ticks} ticks, expected at most {most}",
                    fault.name
                ));
            }
        }
    }
}
