//! The log of a run: everything the controller was given, everything it decided, and, from the emulator,
//! what was true.
//!
//! A log is written block by block and needs no plant: the emulator and a recording of a real board use the
//! same [`LogWriter`]; in a recording the true values are absent. [`LogReader`] gives the blocks back, bit for bit,
//! which is all that a replay needs. [`mcap`] writes the same run for Foxglove, thinned.
//!
//! Both files have a temporary name until [`LogWriter::finish`]; a run that is broken off leaves neither.

#[cfg(feature = "disk")]
mod channels;
mod columns;
#[cfg(feature = "disk")]
pub mod mcap;
#[cfg(feature = "disk")]
mod observer;
#[cfg(feature = "disk")]
mod reader;
mod recorded;
mod status;
#[cfg(all(test, feature = "disk"))]
mod tests;
mod writer;

use serde::{Deserialize, Serialize};
use shared::control::{BootInfo, Command, State, Status};
use shared::io::{Frame, Output};
use shared::settings::Settings;

#[cfg(feature = "disk")]
pub use observer::Logs;
#[cfg(feature = "disk")]
pub use reader::{LogReader, Logged};
pub use status::{StatusCell, cells, names};
#[cfg(feature = "disk")]
pub use writer::LogWriter;
pub use writer::WriterTo;

/// Microseconds in a control tick.
pub const TICK_US: i64 = 1_000_000 / shared::settings::TICK_RATE_HZ as i64;

/// The header of a log: how it was made.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// Who drove the controller: "emulator", or a board's name.
    pub source: String,
    /// The settings the controller began with.
    pub settings: Settings,
    /// Why the controller started, and the fault record it found.
    pub birth: BootInfo,
    /// Ticks in a block.
    pub block_ticks: u32,
    /// The scenario as TOML, if there was one.
    pub scenario: Option<String>,
    /// What the run was made from, as JSON, if that is known.
    pub made_from: Option<String>,
}

/// An input of the controller beside its samples, given before a block.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum LogInput {
    /// A command was given; in a board's recording only one that was obeyed.
    Command(Command),
    /// New settings, in Idle.
    Settings(Settings),
    /// The control task overran.
    Overrun,
    /// The controller was made anew.
    Born(Settings, BootInfo),
}

/// How a block's samples came to the controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Samples {
    /// They came in time.
    #[default]
    Came,
    /// They did not come, and the controller ran without them.
    Blind,
    /// The controller did not run; its last set-points stood.
    Lost,
}

impl Samples {
    /// As it stands in the log.
    pub fn name(self) -> &'static str {
        match self {
            Self::Came => "came",
            Self::Blind => "blind",
            Self::Lost => "lost",
        }
    }

    #[cfg(feature = "disk")]
    fn from_name(name: &[u8]) -> Option<Self> {
        let all = [Self::Came, Self::Blind, Self::Lost];
        all.into_iter().find(|s| s.name().as_bytes() == name)
    }
}

/// What was true at a tick; known to the emulator alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// Contact force between hammer and surface, N.
    pub force_n: f64,
    /// Hammer displacement, fixed frame, m.
    pub hammer_m: f64,
    /// Cart displacement, fixed frame, m.
    pub cart_m: f64,
}

/// One control tick: what the controller was given, what it put out, and what was true.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LogTick {
    /// The samples the controller was given.
    pub frame: Frame,
    /// Its set-point, which the drive gets one block later.
    pub output: Output,
    /// What was true when the samples were taken.
    pub truth: Option<Truth>,
}

/// One block: the controller's inputs and outputs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LogBlock {
    /// Inputs before the block, in order.
    pub inputs: Vec<LogInput>,
    /// How the samples came to the controller.
    pub samples: Samples,
    /// Whether a finished forecast was delivered to the controller just before the block; none: it follows
    /// from the slices, as in lock-step.
    pub forecast: Option<bool>,
    /// Slices of forecast after the block, if they were counted (in lock-step they are).
    pub slices: Option<u32>,
    /// The ticks, at least one.
    pub ticks: Vec<LogTick>,
    /// The status after the block, if it is known.
    pub status: Option<Status>,
    /// The state after the block, where that is all that is known.
    pub state: Option<State>,
}
