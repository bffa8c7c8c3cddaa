//! The messages in both directions. New ones are appended, none is reordered: see [the module](super).

use serde::{Deserialize, Serialize};

use super::{Identified, Recording};
use crate::control::{self, Command, SettingsState, Status};
use crate::fault::FaultRecord;
use crate::forecast::{Forecast, ForecastRow, Target};
use crate::settings::Settings;

/// A message with its number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Packet<M> {
    /// Counts the packets the sender meant to send (wraps).
    pub sequence: u16,
    /// What is sent: a [`ToBoard`] or a [`FromBoard`].
    pub message: M,
}

/// A request of the computer. Each gets exactly one [`LinkAnswer`], in order.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap, and one lives at a time"
)]
pub enum ToBoard {
    /// Begins a conversation: ends the streams of the one before. A session goes on. Answered with [`LinkAnswer::Hello`].
    Hello,
    /// Asks what the controller is doing. Answered with [`LinkAnswer::Status`].
    GetStatus,
    /// Without a session: [`Command::Stop`], which anybody may give and which keeps its encoding for ever; any other
    /// command is refused. Answered with [`LinkAnswer::Done`] or [`LinkAnswer::Refused`].
    Command(Command),
    /// Asks for the settings in use. Answered with [`LinkAnswer::Settings`].
    GetSettings,
    /// A page of the forecast, from 0. Answered with [`LinkAnswer::Forecast`]; beyond the last, a page without rows.
    GetForecast {
        /// Which page of [`ROWS_PER_PAGE`] rows.
        page: u8,
    },
    /// Telemetry every so many control ticks; 0: none. Answered with [`LinkAnswer::Done`].
    StreamTelemetry {
        /// Control ticks from one to the next.
        decimation: u32,
    },
    /// A recording of every tick, or its end. Answered with [`LinkAnswer::Done`] or [`LinkAnswer::Refused`].
    StreamFrames {
        /// True: the recording begins; false: it ends.
        on: bool,
    },
    /// Asks for the present or last fault. Answered with [`LinkAnswer::FaultRecord`].
    GetFaultRecord,
    /// Asks for the identified parameters of the rig. Answered with [`LinkAnswer::Identified`].
    GetIdentified,
    /// Asks what a program must know before it steers. Answered with [`LinkAnswer::Board`].
    GetBoard,
    /// Asks for the session, without which nothing is steered: see [the module](super). Answered with
    /// [`LinkAnswer::Session`] or [`LinkAnswer::Refused`].
    OpenSession {
        /// [`BoardState::boot`] as the sender knows it; another one is refused.
        boot: u32,
        /// [`BoardState::granted`]. A request that was recorded earlier names another number and is refused.
        granted: u32,
        /// Take the session from a program that has one and is alive.
        take_over: bool,
    },
    /// An act of who has the session. Answered with [`LinkAnswer::Done`] or [`LinkAnswer::Refused`].
    Steer {
        /// Number of the sender's session, from [`LinkAnswer::Session`].
        session: u32,
        /// Higher from one act to the next, from 1: an old one is refused.
        number: u32,
        /// What is to be done.
        act: LinkAct,
    },
}

/// What only the holder of the session may do. Each of them is a sign of life of the session.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap, and one lives at a time"
)]
pub enum LinkAct {
    /// A command; [`Command::Acknowledge`] is refused: it is given at the board.
    Command(Command),
    /// New settings, checked and taken as a whole, in Idle (or after a fault) only, and stored in flash if they are
    /// not the same as those there. The controller starts anew with them.
    SetSettings(Settings),
    /// Ends the session, so that another program may open one.
    Release,
    /// The part's brown-out reset is set to the level that its clock needs, in Idle or Fault with the drive off, once per board.
    SetBrownOut,
}

/// A message of the controller.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap, and one lives at a time"
)]
pub enum FromBoard {
    /// The answer to a request.
    Answer {
        /// [`Packet::sequence`] of the request.
        request: u16,
        /// The answer to that request.
        answer: LinkAnswer,
    },
    /// Unasked, at the decimation asked for.
    Telemetry(Telemetry),
    /// Unasked, every block while recording.
    Recording(Recording),
}

/// The board's answer to a request ([`ToBoard`]).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap, and one lives at a time"
)]
pub enum LinkAnswer {
    /// Versions of protocol and firmware, the board's name, and its tick and block.
    Hello(Hello),
    /// The request was carried out.
    Done,
    /// The request was refused.
    Refused(Refusal),
    /// What the controller is doing.
    Status(Status),
    /// The settings in use.
    Settings(Settings),
    /// A page of the forecast.
    Forecast(ForecastPage),
    /// The present or last fault; it survives a reset.
    FaultRecord(Option<FaultRecord>),
    /// The identified parameters of the rig.
    Identified(Identified),
    /// What a program must know before it steers.
    Board(BoardState),
    /// The session is granted, under this number.
    Session(u32),
}

/// What a program must know before it steers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BoardState {
    /// A number of this boot: another after every reset.
    pub boot: u32,
    /// Sessions granted in this boot.
    pub granted: u32,
    /// Somebody has the session.
    pub held: bool,
    /// Where the settings come from.
    pub settings: SettingsState,
    /// An emergency stop must be acknowledged at the board before the fault can be cleared.
    pub awaits_acknowledgement: bool,
}

/// A name of up to 23 bytes.
pub type LinkName = heapless::String<23>;

/// Versions and names of the answering side. The first field is the version, for ever.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hello {
    /// The answering side's [`super::PROTOCOL_VERSION`].
    pub protocol: u16,
    /// Version of the program that answers, as text.
    pub firmware: LinkName,
    /// The board, or `emulator`.
    pub board: LinkName,
    /// Control ticks per second.
    pub tick_rate_hz: u32,
    /// Ticks in a block.
    pub block_ticks: u8,
}

/// Why a request was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// The controller refused the command.
    Controller(control::Refused),
    /// The settings are in use, but could not be stored: they are lost at the next reset.
    NotStored,
    /// The board lacks this function.
    NotAvailable,
    /// That needs the session, and the sender does not have it: never opened, silent for too long, taken over, or of
    /// an earlier boot.
    NoSession,
    /// Another program has the session and is alive.
    SomebodySteers,
    /// The number in it is not newer than the last: it was sent earlier.
    Old,
    /// Only at the board.
    AtTheBoard,
}

impl From<control::Refused> for Refusal {
    fn from(refused: control::Refused) -> Self {
        Self::Controller(refused)
    }
}

/// The state of the controller, sent unasked.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Telemetry {
    /// State of the controller, as [`ToBoard::GetStatus`] would give it.
    pub status: Status,
    /// Packets dropped for want of room since the start.
    pub dropped: u32,
}

/// Rows in a page of the forecast.
pub const ROWS_PER_PAGE: usize = 6;

/// A part of the forecast.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ForecastPage {
    /// [`Forecast::id`]: pages of different numbers do not belong together. 0 without rows: there is no forecast yet.
    pub id: u32,
    /// Number of this page, from 0.
    pub page: u8,
    /// Rows of the whole forecast.
    pub rows_in_all: u8,
    /// This page's, by rising frequency.
    pub rows: heapless::Vec<ForecastRow, ROWS_PER_PAGE>,
    /// The frequency to run at; `None` without a stable 1/1.
    pub target: Option<Target>,
}

impl ForecastPage {
    /// Page `page` of `forecast`; without rows if there is none.
    pub fn of(forecast: Option<&Forecast>, page: u8) -> Self {
        let Some(forecast) = forecast else {
            return Self {
                page,
                ..Self::default()
            };
        };
        let first = usize::from(page).saturating_mul(ROWS_PER_PAGE);
        let rows = forecast.rows.iter().skip(first).take(ROWS_PER_PAGE);
        Self {
            id: forecast.id,
            page,
            rows_in_all: u8::try_from(forecast.rows.len()).unwrap_or(u8::MAX),
            rows: rows.copied().collect(),
            target: forecast.target,
        }
    }
}
