//! A force curve measured by hand: manual mode, one frequency after the other, up or down.

use std::io::{Read, Write};
use std::time::{Duration, Instant};

use serde::Serialize;
use shared::control::{Command, Mode, State, Status};
use shared::fault::FaultRecord;
use shared::settings::TICK_RATE_HZ;

use super::client::Client;
use super::clock::Clock;
use emulator::names::state_name;
use files::UserError;

/// How often the status is asked for: several times per drive period, and well within the link's timeout.
const POLL: Duration = Duration::from_millis(20);

/// A frequency that does not change for so long is reached, ticks: 0.1 s.
const REST_TICKS: u32 = TICK_RATE_HZ / 10;

/// From the start to manual mode: zeros and proof of the sensors take some natural periods.
pub const START: Duration = Duration::from_secs(120);

/// From the command to stop to idle.
const STOP: Duration = Duration::from_secs(30);

/// From the command to stop to idle once the user has interrupted, who waits for the program to end.
const STOP_INTERRUPTED: Duration = Duration::from_secs(5);

/// What a computer with more to do may add to a wait.
const SPARE_S: f64 = 60.0;

/// No wait is longer, s, whatever the board's settings say: 11 days.
const LONGEST_S: f64 = 1e6;

/// How the curve is measured. Times are the controller's.
#[derive(Clone, Debug, PartialEq)]
pub struct CurvePlan {
    /// Drive frequencies in the order visited, Hz.
    pub frequencies_hz: Vec<f64>,
    /// Amplitude of the cart at every frequency, m.
    pub amplitude_m: f64,
    /// Time to settle once a frequency is reached, s.
    pub settle_s: f64,
    /// Time after that in which the force is measured, s.
    pub measure_s: f64,
    /// Time in which the frequency slews from one limit to the other, s.
    pub slew_s: f64,
}

/// A measured point. As a line of CSV it is what `host-sim sweep --measured` reads.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ForcePoint {
    /// Drive frequency asked for, Hz; not part of the table.
    #[serde(skip)]
    pub asked_hz: f64,
    /// Drive frequency reached, Hz: the one asked for, or the nearest within the limits.
    pub frequency_hz: f64,
    /// Largest contact force while it was measured, N.
    pub force_n: f64,
    /// The regime at the end, as the controller saw it.
    pub regime: String,
    /// Measured cart amplitude at the end, mm.
    pub amplitude_mm: f64,
}

impl ForcePoint {
    /// Whether the controller kept the drive within its limits instead of following what was asked.
    pub fn was_limited(&self) -> bool {
        (self.frequency_hz - self.asked_hz).abs() > 1e-4 * self.asked_hz
    }
}

/// How a measurement ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeasurementEnded {
    /// Every frequency was measured.
    Whole,
    /// It was interrupted before the last frequency was measured.
    Interrupted,
}

/// Starts in manual mode, measures the curve, and stops the drive. Each point is given to `measured` as it comes, and
/// counts even if the rest fails. The client has opened its session. As soon as `interrupted` says so, or anything fails,
/// the
/// drive is stopped.
///
/// # Errors
/// If the link fails, the controller refuses a command or does not do in time what it was told, `measured` fails, or a
/// fault
/// switches the drive off.
pub fn measure<P: Read + Write>(
    client: &mut Client<P>,
    plan: &CurvePlan,
    interrupted: &dyn Fn() -> bool,
    mut measured: impl FnMut(&ForcePoint) -> Result<(), UserError>,
) -> Result<MeasurementEnded, UserError> {
    client.command(Command::Start(Mode::Manual))?;
    let ended = ByHand {
        client,
        interrupted,
    }
    .points(plan, &mut measured);
    let ended = match ended {
        Ok(()) => MeasurementEnded::Whole,
        Err(Halt::Interrupted) => MeasurementEnded::Interrupted,
        Err(Halt::Failed(error)) => {
            // Only while this program steers: a drive that somebody has taken over is theirs. In Fault the stop is refused, and a
            // broken link does not carry it: the error tells.
            if client.command(Command::Alive).is_ok() {
                let _ = client.command(Command::Stop);
            }
            return Err(error);
        }
    };
    client.command(Command::Stop)?;
    let mut idle = |patience, interrupted| {
        let mut by_hand = ByHand {
            client,
            interrupted,
        };
        by_hand.wait(patience, "go idle after it was told to stop", |status| {
            Ok(status.state == State::Idle)
        })
    };
    let stopping = match ended {
        MeasurementEnded::Whole => idle(STOP, interrupted),
        MeasurementEnded::Interrupted => Err(Halt::Interrupted),
    };
    let stopping = match stopping {
        Err(Halt::Interrupted) => idle(STOP_INTERRUPTED, &|| false),
        other => other,
    };
    match stopping {
        Err(Halt::Failed(error)) => Err(error),
        _ => Ok(ended),
    }
}

/// Why a measurement goes no further.
enum Halt {
    Interrupted,
    Failed(UserError),
}

impl From<UserError> for Halt {
    fn from(error: UserError) -> Self {
        Self::Failed(error)
    }
}

/// A controller in manual mode.
struct ByHand<'a, P> {
    client: &'a mut Client<P>,
    interrupted: &'a dyn Fn() -> bool,
}

impl<P: Read + Write> ByHand<'_, P> {
    fn points(
        &mut self,
        plan: &CurvePlan,
        measured: &mut dyn FnMut(&ForcePoint) -> Result<(), UserError>,
    ) -> Result<(), Halt> {
        self.wait(START, "reach manual mode", |status| {
            Ok(status.state == State::Manual)
        })?;
        for frequency_hz in &plan.frequencies_hz {
            measured(&self.point(plan, *frequency_hz)?)?;
        }
        Ok(())
    }

    fn point(&mut self, plan: &CurvePlan, frequency_hz: f64) -> Result<ForcePoint, Halt> {
        self.client.command(Command::SetPoint {
            frequency_hz: frequency_hz as f32,
            amplitude_m: plan.amplitude_m as f32,
        })?;
        self.arrive(plan.slew_s)?;
        self.pass(plan.settle_s, |_| {})?;
        let mut force_n = 0.0_f32;
        let last = self.pass(plan.measure_s, |status| {
            force_n = force_n.max(status.peak_n);
        })?;
        Ok(ForcePoint {
            asked_hz: frequency_hz,
            frequency_hz: shortest(last.frequency_hz),
            force_n: shortest(force_n),
            regime: last.regime.to_string(),
            amplitude_mm: shortest(1e3 * last.measured_amplitude_m),
        })
    }

    /// Waits until the frequency no longer changes. The frequency asked for may lie beyond the limits, so that it is
    /// never reached; and while the frequency slews, it changes every tick.
    fn arrive(&mut self, slew_s: f64) -> Result<(), Halt> {
        let mut before: Option<(u32, f32)> = None;
        self.wait(
            at_most(slew_s),
            "bring the drive to a frequency",
            |status| {
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
            },
        )?;
        Ok(())
    }

    /// Lets `time_s` of the controller's time pass and gives every status to `each`. Returns the last one.
    fn pass(&mut self, time_s: f64, mut each: impl FnMut(&Status)) -> Result<Status, Halt> {
        let ticks = (time_s * f64::from(TICK_RATE_HZ)) as u32;
        let mut begun = None;
        self.wait(at_most(time_s), "let its time pass", |status| {
            still_manual(status)?;
            let begun = *begun.get_or_insert(status.tick);
            each(status);
            Ok(status.tick.wrapping_sub(begun) >= ticks)
        })
    }

    /// Asks for the status until it is as `wanted`, and gives a sign of life each time. What the controller does not do
    /// within `patience` is an error that says `what`.
    fn wait(
        &mut self,
        patience: Duration,
        what: &str,
        mut wanted: impl FnMut(&Status) -> Result<bool, &'static str>,
    ) -> Result<Status, Halt> {
        let until = Instant::now() + patience;
        let mut clock = Clock::new();
        loop {
            if (self.interrupted)() {
                return Err(Halt::Interrupted);
            }
            self.client.command(Command::Alive)?;
            let status = self.client.status()?;
            if let Some(record) = status.fault.filter(|_| status.state == State::Fault) {
                return Err(self.fault(&record).into());
            }
            if wanted(&status).map_err(|why| self.client.complaint(why))? {
                return Ok(status);
            }
            clock
                .goes_on(&status)
                .map_err(|why| self.client.complaint(why))?;
            if Instant::now() > until {
                let error = self.client.complaint(format!(
                    "the controller does not {what} and is in {} after {} s; is the drive off? Reset the board",
                    state_name(status.state),
                    patience.as_secs()
                ));
                return Err(error.into());
            }
            std::thread::sleep(POLL);
        }
    }

    fn fault(&self, record: &FaultRecord) -> UserError {
        self.client.complaint(format!(
            "the drive is off: fault {} ({}) at {:.3} Hz; remove its cause, then `host-sim link {} clear-fault`",
            record.fault.code(),
            record.fault.name(),
            record.frequency_hz,
            self.client.name()
        ))
    }
}

/// How long to wait for what takes `time_s` of the controller's time.
pub fn at_most(time_s: f64) -> Duration {
    // The time is a board's word, and may be no number.
    let wanted_s = (SPARE_S + 3.0 * time_s).max(SPARE_S);
    Duration::from_secs_f64(wanted_s.min(LONGEST_S))
}

fn still_manual(status: &Status) -> Result<(), &'static str> {
    match status.state {
        State::Manual | State::Fault => Ok(()),
        _ => Err("somebody else has stopped the drive; begin again"),
    }
}

/// The f64 of as few digits as name the f32: 3.2 is 3.2, not 3.2000000476837.
fn shortest(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}
