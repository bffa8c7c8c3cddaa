//! `link PORT sweep`: the force curve measured by hand.

use std::path::PathBuf;

use shared::link::Hello;
use shared::settings::Settings;

use super::{Port, Session};
use crate::cli::arguments::output::to_json;
use crate::cli::arguments::range::parse_range;
use crate::cli::interrupt;
use crate::cli::terminal::say;
use crate::link::by_hand::{self, CurvePlan, MeasurementEnded};
use files::UserError;
use files::made_from::{MadeFrom, into_json};
use files::table::to_csv;

#[derive(Debug, clap::Args)]
pub struct Sweep {
    /// Lowest frequency, Hz
    #[arg(long, alias = "from", value_name = "HZ")]
    pub from_hz: f64,
    /// Highest frequency, Hz
    #[arg(long, alias = "to", value_name = "HZ")]
    pub to_hz: f64,
    /// Step from one frequency to the next, Hz
    #[arg(long, alias = "step", value_name = "HZ")]
    pub step_hz: f64,
    /// Time to settle at each, s
    #[arg(long, value_name = "S", default_value_t = 10.0)]
    pub settle: f64,
    /// Time to measure the force at each, s
    #[arg(long, value_name = "S", default_value_t = 5.0)]
    pub measure: f64,
    /// Cart amplitude, mm [default: the rig's]
    #[arg(long, value_name = "MM")]
    pub amplitude: Option<f64>,
    /// Go from the highest to the lowest
    #[arg(long)]
    pub down: bool,
    /// File to write; an existing one is not replaced. After a failure or an interruption it has the measurements until
    /// then. FILE.json beside it names the origin
    #[arg(long, alias = "out", value_name = "FILE.csv")]
    pub csv: PathBuf,
    #[command(flatten)]
    pub session: Session,
}

pub fn frequencies(plan: &Sweep) -> Result<Vec<f64>, UserError> {
    let range = format!("{}:{}:{}", plan.from_hz, plan.to_hz, plan.step_hz);
    let parsed = parse_range(&range);
    let mut list =
        parsed.map_err(|e| UserError::new(format!("--from-hz, --to-hz, --step-hz: {e}")))?;
    if plan.down {
        list.reverse();
    }
    Ok(list)
}

/// Measures the curve and writes what was measured, also when something fails or the user interrupts.
pub fn sweep(
    port: &mut Port,
    hello: &Hello,
    plan: &Sweep,
    made: &MadeFrom,
) -> Result<i32, UserError> {
    let settings = port.settings()?;
    let by_hand = by_hand_plan(&settings, plan)?;
    interrupt::finish_first();
    let beside = plan.csv.with_extension("json");
    let mut points = Vec::new();
    // Each point is written as it comes: whatever ends the program, even a second interrupt, leaves what was measured.
    let ended = by_hand::measure(port, &by_hand, &interrupt::interrupted, |point| {
        show_point(point);
        points.push(point.clone());
        let answer = serde_json::json!({
            "board": hello.board.as_str(),
            "firmware": hello.firmware.as_str(),
            "settings": settings,
            "points": points,
        });
        files::write::write(&beside, into_json(to_json(&answer)?, made))?;
        files::write::write(&plan.csv, to_csv(&points))?;
        Ok(())
    });
    if !points.is_empty() {
        say(&format!(
            "wrote {} and {}",
            plan.csv.display(),
            beside.display()
        ));
    }
    if ended? == MeasurementEnded::Whole {
        return Ok(0);
    }
    say(&format!(
        "interrupted after {} of {} frequencies; the drive is stopped",
        points.len(),
        by_hand.frequencies_hz.len()
    ));
    Ok(interrupt::CODE)
}

fn by_hand_plan(settings: &Settings, plan: &Sweep) -> Result<CurvePlan, UserError> {
    let amplitude_m = match plan.amplitude {
        Some(mm) => 1e-3 * mm,
        None => settings.rig.amplitude_m,
    };
    let most_m = f64::from(settings.limits.amplitude_m);
    if amplitude_m > most_m {
        say(&format!(
            "note: {} mm was asked; the controller keeps within its limit of {:.3} mm",
            1e3 * amplitude_m,
            1e3 * most_m
        ));
    }
    let span_hz = settings.limits.max_frequency_hz - settings.limits.min_frequency_hz;
    Ok(CurvePlan {
        frequencies_hz: frequencies(plan)?,
        amplitude_m,
        settle_s: plan.settle,
        measure_s: plan.measure,
        slew_s: f64::from(span_hz / settings.drive.frequency_slew_hz_per_s),
    })
}

fn show_point(point: &by_hand::ForcePoint) {
    say(&format!(
        "{:8.4} Hz  {:8.2} N  {:>9}  {:.3} mm",
        point.frequency_hz, point.force_n, point.regime, point.amplitude_mm
    ));
    if point.was_limited() {
        say(&format!(
            "note: {} Hz was asked; the controller keeps within its frequency limits (`host-sim link PORT get` prints them)",
            point.asked_hz
        ));
    }
}
