//! An emulated board as the link sees it: the controller in lock-step, and a buffer of recorded blocks.

mod served;
mod server;

pub use served::Served;
pub use server::BoardSession;

use std::collections::VecDeque;
use std::hash::{BuildHasher, RandomState};

use shared::control::{BootInfo, Command, Lockstep, Refused, Status};
use shared::fault::FaultRecord;
use shared::io::{Frame, Output};
use shared::link::{
    BlockNotes, Boot, Device, ForecastPage, GivenCommand, Hello, Identified, LinkName,
    PROTOCOL_VERSION, RecordedBlock, Refusal,
};
use shared::model::params::ParamError;
use shared::settings::{Settings, TICK_RATE_HZ};

/// Blocks buffered until they are taken: two seconds of blocks of ten.
const KEPT: usize = 4000;

/// A board without hardware: controller and forecast in lock-step, and the link's view of them ([`Device`]).
#[derive(Clone, Debug)]
pub struct EmulatedBoard {
    lockstep: Lockstep,
    block_ticks: u8,
    /// What came before the next block.
    notes: BlockNotes,
    /// More commands came before the next block than a recording holds: it is left out, which shows.
    too_many: bool,
    recording: bool,
    kept: VecDeque<RecordedBlock>,
    boot: u32,
}

impl EmulatedBoard {
    /// After power-on, with blocks of `block_ticks` ticks.
    ///
    /// # Errors
    /// If a setting is out of range.
    pub fn new(settings: &Settings, block_ticks: u8) -> Result<Self, ParamError> {
        Ok(Self {
            lockstep: Lockstep::new(settings, &BootInfo::STORED)?,
            block_ticks,
            notes: BlockNotes::default(),
            too_many: false,
            recording: false,
            kept: VecDeque::new(),
            boot: boot_number(),
        })
    }

    /// Controller and forecast, which advance together block by block.
    pub fn lockstep(&mut self) -> &mut Lockstep {
        &mut self.lockstep
    }

    /// A block of frames in, a block of outputs back, then `slices` slices of the forecast.
    pub fn exchange(&mut self, frames: &[Frame], outputs: &mut [Output], slices: u32) {
        let tick = self.status().tick;
        let done = self.lockstep.exchange(frames, outputs, slices);
        self.notes.forecast_delivered = done.delivered;
        self.keep(tick, frames, outputs);
    }

    /// A block whose samples did not come.
    pub fn exchange_blind(&mut self, outputs: &mut [Output], slices: u32) {
        let tick = self.status().tick;
        let done = self.lockstep.exchange_blind(outputs, slices);
        self.notes.forecast_delivered = done.delivered;
        self.notes.stale = true;
        let none = vec![Frame::default(); outputs.len()];
        self.keep(tick, &none, outputs);
    }

    /// The control task overran.
    pub fn note_overrun(&mut self) {
        self.notes.overrun = true;
        self.lockstep.controller.note_overrun();
    }

    /// Makes the controller anew. A recording that runs shows a gap.
    ///
    /// # Errors
    /// If a setting is out of range.
    pub fn reset(&mut self, settings: &Settings, birth: &BootInfo) -> Result<(), ParamError> {
        self.lockstep = Lockstep::new(settings, birth)?;
        self.notes = BlockNotes::default();
        self.too_many = true;
        self.boot = boot_number();
        Ok(())
    }

    fn keep(&mut self, tick: u32, frames: &[Frame], outputs: &[Output]) {
        let mut notes = std::mem::take(&mut self.notes);
        notes.state = self.lockstep.controller.state();
        let too_many = std::mem::take(&mut self.too_many);
        if !self.recording || too_many || self.kept.len() >= KEPT {
            return;
        }
        self.kept.push_back(RecordedBlock {
            tick,
            frames: frames.iter().copied().collect(),
            outputs: outputs.iter().copied().collect(),
            notes,
        });
    }
}

/// A number that no other start has had, as far as chance allows.
fn boot_number() -> u32 {
    RandomState::new().hash_one(()) as u32
}

impl Device for EmulatedBoard {
    fn hello(&mut self) -> Hello {
        Hello {
            protocol: PROTOCOL_VERSION,
            firmware: LinkName::try_from(env!("CARGO_PKG_VERSION")).unwrap_or_default(),
            board: LinkName::try_from("emulator").unwrap_or_default(),
            tick_rate_hz: TICK_RATE_HZ,
            block_ticks: self.block_ticks,
        }
    }

    fn status(&mut self) -> Status {
        self.lockstep.controller.status()
    }

    fn command(&mut self, command: Command) -> Result<(), Refused> {
        let result = self.lockstep.controller.command(command);
        let given = GivenCommand {
            command,
            refused: result.err(),
        };
        // Twice alive before one block is once alive.
        let again = command == Command::Alive && self.notes.given.contains(&given);
        if !again {
            self.too_many |= self.notes.given.push(given).is_err();
        }
        result
    }

    fn settings(&mut self) -> Settings {
        *self.lockstep.controller.settings()
    }

    fn replace_settings(&mut self, settings: &Settings) -> Result<(), Refused> {
        self.lockstep.controller.replace_settings(settings)?;
        // What came before is of no account to who was made after it.
        self.notes = BlockNotes {
            restarted: true,
            ..BlockNotes::default()
        };
        Ok(())
    }

    fn store_settings(&mut self) -> Result<(), Refusal> {
        // The memory of a process is its flash.
        Ok(())
    }

    fn forecast(&mut self, page: u8) -> ForecastPage {
        ForecastPage::of(self.lockstep.forecast(), page)
    }

    fn fault_record(&mut self) -> Option<FaultRecord> {
        self.status().fault
    }

    fn identified(&mut self) -> Identified {
        Identified::of(self.lockstep.controller.identified())
    }

    fn record(&mut self, on: bool) -> Result<(), Refusal> {
        self.recording = on;
        self.kept.clear();
        Ok(())
    }

    fn take_block(&mut self) -> Option<RecordedBlock> {
        self.kept.pop_front()
    }

    fn boot(&mut self) -> Boot {
        let controller = &self.lockstep.controller;
        Boot {
            number: self.boot,
            settings: controller.settings_state(),
            awaits_acknowledgement: controller.awaits_acknowledgement(),
        }
    }
}
