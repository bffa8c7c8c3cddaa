//! What a page may say, and what it may not do.

use serde::Deserialize;
use shared::control::Command;
use shared::link::{Refusal, ToBoard};

/// What a page says to the server.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(tag = "act", rename_all = "kebab-case")]
pub enum PageAct {
    /// It takes the free seat.
    Take,
    /// It takes the seat from the page that has it.
    TakeOver,
    /// It leaves the seat.
    Leave,
    /// It says that it is still there: a page in command that is silent for a second loses the seat.
    Here,
}

/// Why a page's message is not for the board, if it is not: `commands` is whether the page has the seat, `free` whether
/// nobody has.
pub fn refusal(message: &ToBoard, commands: bool, free: bool) -> Option<Refusal> {
    match message {
        // Anybody may.
        ToBoard::Command(Command::Stop) => None,
        // Without a session the board refuses it, too.
        ToBoard::Command(_) => Some(Refusal::NoSession),
        ToBoard::OpenSession { .. } | ToBoard::Steer { .. } if commands => None,
        ToBoard::OpenSession { .. } | ToBoard::Steer { .. } if free => Some(Refusal::NoSession),
        ToBoard::OpenSession { .. } | ToBoard::Steer { .. } => Some(Refusal::SomebodySteers),
        // What only looks. A message that is added to the protocol must be judged here before it compiles.
        ToBoard::Hello
        | ToBoard::GetStatus
        | ToBoard::GetSettings
        | ToBoard::GetForecast { .. }
        | ToBoard::StreamTelemetry { .. }
        | ToBoard::StreamFrames { .. }
        | ToBoard::GetFaultRecord
        | ToBoard::GetIdentified
        | ToBoard::GetBoard => None,
    }
}
