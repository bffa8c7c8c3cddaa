//! A force curve measured by hand: manual mode, one frequency after the other, up or down.

use std::io::{Read, Write};
use std::time::{Duration, Instant};

use serde::Serialize;
use shared::control::{Command, Mode, State, Status};
use shared::link::ToBoard;
use shared::settings::TICK_RATE_HZ;

use super::client::{Client, state_name};
use files::UserError;

/// How often the status is asked for: several times per drive period, and well within the link's timeout.
const LOOK: Duration = Duration::from_millis(20);

/// A frequency that stays for so long has arrived, ticks: 0.1 s.
const REST_TICKS: u32 = TICK_RATE_HZ / 10;

/// A controller whose ticks stand still so long has stopped.
const STANDSTILL: Duration = Duration::from_secs(5);

/// How the curve is measured. Times are the controller's.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Drive frequencies in the order visited, Hz.
    pub frequencies_hz: Vec<f64>,
    /// Cart amplitude, m.
    pub amplitude_m: f64,
    /// How long the hammer is given to settle once a frequency is reached, s.
    pub settle_s: f64,
    /// And how long its force is then watched, s.
    pub measure_s: f64,
}

/// A measured point. As a line of CSV it is what `host-sim sweep --measured` reads.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Drive frequency as it was asked, Hz; not part of the table.
    #[serde(skip)]
    pub asked_hz: f64,
    /// Drive frequency as it was, Hz: within the limits, as near as possible to what was asked.
    pub frequency_hz: f64,
    /// Largest force of a drive period while it was watched, N.
    pub force_n: f64,
    /// The regime at the end, as the controller saw it.
    pub regime: String,
    /// Measured cart amplitude at the end, mm.
    pub amplitude_mm: f64,
}

impl Point {
    /// Whether the controller kept the drive within its limits instead of following what was asked.
    pub fn was_limited(&self) -> bool {
        (self.frequency_hz - self.asked_hz).abs() > 1e-4 * self.asked_hz
    }
}

/// Starts in manual mode, measures the curve, and stops again. `seen` is told every point as it comes; what
/// it has been told stands even if the rest fails.
///
/// # Errors
/// The link fails, the controller refuses, or a fault ends it.
pub fn measure<P: Read + Write>(
    client: &mut Client<P>,
    plan: &Plan,
    mut seen: impl FnMut(&Point),
) -> Result<(), UserError> {
    client.tell(ToBoard::Command(Command::Start(Mode::Manual)))?;
    wait(client, |status| Ok(status.state == State::Manual))?;
    for frequency_hz in &plan.frequencies_hz {
        seen(&point(client, plan, *frequency_hz)?);
    }
    client.tell(ToBoard::Command(Command::Stop))?;
    wait(client, |status| Ok(status.state == State::Idle))?;
    Ok(())
}

fn point<P: Read + Write>(
    client: &mut Client<P>,
    plan: &Plan,
    frequency_hz: f64,
) -> Result<Point, UserError> {
    client.tell(ToBoard::Command(Command::SetPoint {
        frequency_hz: frequency_hz as f32,
        amplitude_m: plan.amplitude_m as f32,
    }))?;
    // There once it no longer changes: the goal itself may be clamped to the limits. A slew changes it every
    // tick.
    let mut before: Option<(u32, f32)> = None;
    wait(client, |status| {
        still_manual(status)?;
        match before {
            Some((tick, hz)) if status.tick.wrapping_sub(tick) < REST_TICKS => {
                if hz != status.frequency_hz {
                    before = None;
                }
                Ok(false)
            }
            Some((_, hz)) if hz == status.frequency_hz => Ok(true),
            _ => {
                before = Some((status.tick, status.frequency_hz));
                Ok(false)
            }
        }
    })?;
    pass(client, plan.settle_s, |_| {})?;
    let mut force_n = 0.0_f32;
    let last = pass(client, plan.measure_s, |status| {
        force_n = force_n.max(status.peak_n);
    })?;
    Ok(Point {
        asked_hz: frequency_hz,
        frequency_hz: shortest(last.frequency_hz),
        force_n: shortest(force_n),
        regime: last.regime.to_string(),
        amplitude_mm: shortest(1e3 * last.measured_amplitude_m),
    })
}

/// The f64 of as few digits as name the f32: 3.2 is 3.2, not 3.2000000476837.
fn shortest(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}

/// Lets the controller's time go on.
fn pass<P: Read + Write>(
    client: &mut Client<P>,
    time_s: f64,
    mut look: impl FnMut(&Status),
) -> Result<Status, UserError> {
    let ticks = (time_s * f64::from(TICK_RATE_HZ)) as u32;
    let mut begun = None;
    wait(client, |status| {
        still_manual(status)?;
        let begun = *begun.get_or_insert(status.tick);
        look(status);
        Ok(status.tick.wrapping_sub(begun) >= ticks)
    })
}

fn still_manual(status: &Status) -> Result<(), &'static str> {
    match status.state {
        State::Manual | State::Fault => Ok(()),
        _ => Err("somebody else has stopped it; begin again"),
    }
}

/// Asks for the status until it is as `wanted`.
fn wait<P: Read + Write>(
    client: &mut Client<P>,
    mut wanted: impl FnMut(&Status) -> Result<bool, &'static str>,
) -> Result<Status, UserError> {
    let mut last: Option<(u32, Instant)> = None;
    loop {
        let status = client.status()?;
        if let Some(record) = status.fault.filter(|_| status.state == State::Fault) {
            return Err(client.complaint(format!(
                "the drive is off: fault {} ({}) at {:.3} Hz; mend it, then `host-sim link {} clear-fault`",
                record.fault.code(),
                record.fault.name(),
                record.frequency_hz,
                client.name()
            )));
        }
        if wanted(&status).map_err(|why| client.complaint(why))? {
            return Ok(status);
        }
        match last {
            Some((tick, since)) if tick == status.tick => {
                if since.elapsed() > STANDSTILL {
                    return Err(client.complaint(format!(
                        "the controller stands still in {} at tick {tick}; reset the board",
                        state_name(status.state)
                    )));
                }
            }
            _ => last = Some((status.tick, Instant::now())),
        }
        std::thread::sleep(LOOK);
    }
}
