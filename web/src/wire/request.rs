//! What the page asks of a board.

use serde::Deserialize;
use shared::control::{Command, Mode};
use shared::link::{LinkAct, ToBoard};
use shared::settings::Settings;
use wire::Caller;

use super::overlaid;

/// A request as the page's scripts write it.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum PageWanted {
    /// The protocol's version, and the names of the board and its firmware.
    Hello,
    /// What the controller is doing.
    Status,
    /// The settings in use.
    Settings,
    /// What must be known before steering.
    Board,
    /// Status messages, every so many ticks.
    Telemetry {
        /// Control ticks from one status message to the next; 0: no more messages.
        decimation: u32,
    },
    /// Every tick, or no more.
    Frames {
        /// Whether every tick is wanted from now on.
        on: bool,
    },
    /// Takes the session, without which nothing but a stop is obeyed.
    Open {
        /// As the board said.
        boot: u32,
        /// As the board said.
        granted: u32,
        /// From who has it.
        take_over: bool,
    },
    /// Gives the session back.
    Release,
    /// A sign of life.
    Alive,
    /// Ramp down and go idle; needs no session.
    Stop,
    /// Start, by itself or by hand.
    Start {
        /// Whether it follows set-points; otherwise it seeks and holds by itself.
        manual: bool,
    },
    /// By hand: frequency and amplitude.
    SetPoint {
        /// Drive frequency, Hz.
        frequency_hz: f32,
        /// Amplitude of the cart, mm.
        amplitude_mm: f32,
    },
    /// Clear the fault once its cause has gone.
    ClearFault,
    /// Confirm the older copy of the settings.
    Confirm,
    /// New settings: what differs from those in use.
    SetSettings {
        /// As `host-sim link PORT get` prints them; empty: the same again.
        toml: String,
    },
}

impl PageWanted {
    /// The message to send.
    ///
    /// # Errors
    /// There is no session, or the settings are wrong: one line.
    pub fn message(&self, caller: &Caller, now: Option<&Settings>) -> Result<ToBoard, String> {
        let act = match self {
            Self::Hello => return Ok(ToBoard::Hello),
            Self::Status => return Ok(ToBoard::GetStatus),
            Self::Settings => return Ok(ToBoard::GetSettings),
            Self::Board => return Ok(ToBoard::GetBoard),
            Self::Telemetry { decimation } => {
                let decimation = *decimation;
                return Ok(ToBoard::StreamTelemetry { decimation });
            }
            Self::Frames { on } => return Ok(ToBoard::StreamFrames { on: *on }),
            Self::Open {
                boot,
                granted,
                take_over,
            } => {
                return Ok(ToBoard::OpenSession {
                    boot: *boot,
                    granted: *granted,
                    take_over: *take_over,
                });
            }
            // Needs no session.
            Self::Stop => return Ok(ToBoard::Command(Command::Stop)),
            Self::Release => LinkAct::Release,
            Self::Alive => LinkAct::Command(Command::Alive),
            Self::Start { manual: true } => LinkAct::Command(Command::Start(Mode::Manual)),
            Self::Start { manual: false } => LinkAct::Command(Command::Start(Mode::Automatic)),
            Self::SetPoint {
                frequency_hz,
                amplitude_mm,
            } => LinkAct::Command(Command::SetPoint {
                frequency_hz: *frequency_hz,
                amplitude_m: 1e-3 * amplitude_mm,
            }),
            Self::ClearFault => LinkAct::Command(Command::ClearFault),
            Self::Confirm => LinkAct::Command(Command::ConfirmSettings),
            Self::SetSettings { toml } => LinkAct::SetSettings(overlaid(now, toml)?),
        };
        caller
            .steer(act)
            .map_err(|_| "this page does not command the board; take the command first".into())
    }
}
