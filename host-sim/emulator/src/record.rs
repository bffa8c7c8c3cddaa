//! What an observer of a run gets: every tick, block, contact and event.

use serde::Serialize;
use shared::control::{BootInfo, Command, Refused, Status};
use shared::fault::{Fault, Origin};
use shared::io::{Frame, Output};
use shared::settings::Settings;

/// One control tick: the set-point during it, and what the plant truly did by its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TickRow {
    /// Ticks since the start of the run; never set back, not even by a reset of the controller.
    pub tick: u64,
    /// True rig time at the end of the tick, s.
    pub time_s: f64,
    /// What the sensors showed at the end of the tick.
    pub frame: Frame,
    /// The set-point of the drive during the tick.
    pub output: Output,
    /// True contact force at the end of the tick, N.
    pub true_force_n: f64,
    /// Hammer displacement in the fixed frame, x, m.
    pub hammer_m: f64,
    /// Cart displacement in the fixed frame, y, m.
    pub cart_m: f64,
    /// Whether the drive truly had power during the tick, whatever the enable line said.
    pub powered: bool,
    /// Whether a fault of the scenario was present: a defective sensor, an open emergency-stop chain, a silent link,
    /// a drive that does not obey.
    pub faulty: bool,
}

/// What the controller was given beside its samples, before a block.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "at most a handful wait between two blocks"
)]
pub enum Given {
    /// A command, and whether it was obeyed.
    Command {
        /// The command as it was given.
        command: Command,
        /// Why it was not obeyed; none: it was.
        refused: Option<Refused>,
    },
    /// A reset: it was made anew with these settings, and with what it found.
    Born(Settings, BootInfo),
}

/// One block: what the controller was given besides its frames, and what it is doing after it.
///
/// Commands and notes come before the block's frames. With the frames and outputs of its ticks this is all
/// that a replay needs.
#[derive(Clone, Copy, Debug)]
pub struct BlockRow<'a> {
    /// First tick of the block.
    pub tick: u64,
    /// Ticks in the block.
    pub ticks: usize,
    /// Commands and resets before the block, in their order.
    pub given: &'a [Given],
    /// The block's frames as the controller got them (the same as in its ticks, unless stale).
    pub frames: &'a [Frame],
    /// What the controller answered; played out during the next block.
    pub outputs: &'a [Output],
    /// Whether the block reached the controller (a lost one does not, and its last outputs stand).
    pub delivered: bool,
    /// Whether an overrun was reported to the controller before the block.
    pub overrun: bool,
    /// Whether the controller ran without this block's samples, as if they were stale.
    pub stale: bool,
    /// Slices of the forecast after the block.
    pub slices: u32,
    /// The controller's status after the block.
    pub status: &'a Status,
}

/// A contact as it truly was, in rig time.
pub use numerics::reference::LocatedContact as TrueContact;

/// An event of a run and when it happened.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunEvent {
    /// Tick of the run.
    pub tick: u64,
    /// True rig time, s.
    pub time_s: f64,
    /// What happened.
    pub what: RunEventKind,
}

/// What can happen in a run: on the scenario's side and on the controller's.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum RunEventKind {
    /// The scenario did something to the rig, its sensors or the controller.
    Scenario {
        /// What it did, as a sentence for the reader.
        text: String,
    },
    /// The controller changed state.
    State {
        /// Name of the state before the change.
        from: &'static str,
        /// Name of the state after the change.
        to: &'static str,
    },
    /// A fault of the controller tripped.
    Fault {
        /// Which fault.
        fault: Fault,
        /// The sensor that it blames; `System`: none.
        origin: Origin,
        /// The value that tripped it.
        value: f32,
    },
    /// The drive's enable line changed.
    Drive {
        /// Whether the drive is enabled from this tick on.
        on: bool,
    },
    /// Another event that the controller reported.
    Said {
        /// What it reported, as a sentence for the reader.
        text: String,
    },
}

/// Watches a run. Every method has a default that does nothing.
pub trait RunObserver {
    /// A tick is done.
    fn tick(&mut self, _row: &TickRow) {}
    /// A block is done; its ticks came before.
    fn block(&mut self, _row: &BlockRow) {}
    /// A contact ended in this tick; called before the tick is reported.
    fn contact(&mut self, _contact: &TrueContact) {}
    /// An event happened: of the scenario, the controller or the drive.
    fn event(&mut self, _event: &RunEvent) {}
}

/// An observer that ignores everything.
impl RunObserver for () {}

/// Two observers that are told the same, the first of them first.
impl<A: RunObserver, B: RunObserver> RunObserver for (A, B) {
    fn tick(&mut self, row: &TickRow) {
        self.0.tick(row);
        self.1.tick(row);
    }
    fn block(&mut self, row: &BlockRow) {
        self.0.block(row);
        self.1.block(row);
    }
    fn contact(&mut self, contact: &TrueContact) {
        self.0.contact(contact);
        self.1.contact(contact);
    }
    fn event(&mut self, event: &RunEvent) {
        self.0.event(event);
        self.1.event(event);
    }
}

impl<T: RunObserver + ?Sized> RunObserver for &mut T {
    fn tick(&mut self, row: &TickRow) {
        (**self).tick(row);
    }
    fn block(&mut self, row: &BlockRow) {
        (**self).block(row);
    }
    fn contact(&mut self, contact: &TrueContact) {
        (**self).contact(contact);
    }
    fn event(&mut self, event: &RunEvent) {
        (**self).event(event);
    }
}
