//! The controller with a short recording buffer of its last blocks.
//!
//! Every access to the controller goes through here, so that a recording misses none of its inputs.

use heapless::{Deque, Vec};
use shared::control::{Command, Controller, Refused};
use shared::forecast::Forecast;
use shared::io::{Frame, Output};
use shared::link::{BlockNotes, GivenCommand, RecordedBlock, store};
use shared::settings::Settings;

/// Blocks in the buffer: 2 ms of them. The link takes them every millisecond.
const CAPACITY: usize = 4;

/// The controller and the recording.
#[derive(Debug)]
pub struct ControlRecorder {
    controller: Controller,
    /// Of the settings, as they were taken.
    settings_sum: Option<u32>,
    /// Inputs since the last block.
    notes: BlockNotes,
    recording: bool,
    blocks: Deque<RecordedBlock, CAPACITY>,
}

impl ControlRecorder {
    /// A controller whose recording is off.
    pub fn new(controller: Controller) -> Self {
        Self {
            settings_sum: store::sum(controller.settings()),
            controller,
            notes: BlockNotes::default(),
            recording: false,
            blocks: Deque::new(),
        }
    }

    /// The controller, to read.
    pub fn controller(&self) -> &Controller {
        &self.controller
    }

    /// The sum of the settings as they were taken ([`store::sum`]).
    pub fn settings_sum(&self) -> Option<u32> {
        self.settings_sum
    }

    /// The controller, to take events and forecast requests: that changes nothing in a recording.
    pub fn taking(&mut self) -> &mut Controller {
        &mut self.controller
    }

    /// Whether another command fits into the record of a block; if not, wait for the next block.
    pub fn takes_commands(&self) -> bool {
        // A packet can bring two: a sign of life and what it says.
        !self.recording || self.notes.given.is_empty()
    }

    /// Passes a command to the controller.
    ///
    /// # Errors
    /// If the controller refuses it.
    pub fn command(&mut self, command: Command) -> Result<(), Refused> {
        let result = self.controller.command(command);
        if self.recording {
            // One that finds no room is missing in the recording; see `takes_commands`.
            let _ = self.notes.given.push(GivenCommand {
                command,
                refused: result.err(),
            });
        }
        result
    }

    /// Replaces the settings.
    ///
    /// # Errors
    /// If the controller refuses them ([`Controller::replace_settings`]).
    pub fn replace_settings(&mut self, settings: &Settings) -> Result<(), Refused> {
        self.controller.replace_settings(settings)?;
        self.settings_sum = store::sum(settings);
        self.notes.restarted = true;
        Ok(())
    }

    /// Hands a finished forecast over.
    pub fn deliver(&mut self, forecast: &Forecast) {
        self.controller.deliver(forecast);
        self.notes.forecast_delivered = true;
    }

    /// The control task ended too late.
    pub fn note_overrun(&mut self) {
        self.controller.note_overrun();
        self.notes.overrun = true;
    }

    /// A block at control priority; without frames, one whose samples did not arrive.
    pub fn block(&mut self, frames: Option<&[Frame]>, outputs: &mut [Output]) {
        let tick = self.controller.status().tick.wrapping_add(1);
        match frames {
            Some(frames) => self.controller.block(frames, outputs),
            None => self.controller.blind_block(outputs),
        }
        if self.recording {
            self.keep(tick, frames, outputs);
        }
        self.notes = BlockNotes::default();
    }

    fn keep(&mut self, tick: u32, frames: Option<&[Frame]>, outputs: &[Output]) {
        let mut notes = core::mem::take(&mut self.notes);
        notes.stale = frames.is_none();
        notes.state = self.controller.state();
        let blank = [Frame::default(); crate::BLOCK_TICKS];
        let exchange = RecordedBlock {
            tick,
            frames: Vec::from_slice(frames.unwrap_or(&blank)).unwrap_or_default(),
            outputs: Vec::from_slice(outputs).unwrap_or_default(),
            notes,
        };
        // When the buffer is full, this block is lost and shows as a gap in the ticks.
        let _ = self.blocks.push_back(exchange);
    }

    /// Starts or ends recording.
    pub fn record(&mut self, on: bool) {
        self.recording = on;
        self.blocks.clear();
    }

    /// The oldest recorded block.
    pub fn take_block(&mut self) -> Option<RecordedBlock> {
        self.blocks.pop_front()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shared::control::{BootInfo, Mode, State};
    use shared::io::AdcCode;
    use shared::model::params::WIRES;

    fn recorder() -> ControlRecorder {
        let settings = Settings::for_rig(&WIRES);
        ControlRecorder::new(Controller::new(&settings, &BootInfo::STORED).unwrap())
    }

    #[test]
    fn a_recording_holds_every_input_of_the_controller() {
        let mut recorder = recorder();
        let frames = [Frame {
            force: AdcCode(600),
            hammer: AdcCode(2048),
            cart: AdcCode(2048),
            emergency: false,
        }; crate::BLOCK_TICKS];
        let mut outputs = [Output::SAFE; crate::BLOCK_TICKS];
        recorder.block(Some(&frames), &mut outputs);
        assert!(recorder.take_block().is_none());

        recorder.record(true);
        assert!(recorder.takes_commands());
        assert_eq!(recorder.command(Command::Start(Mode::Automatic)), Ok(()));
        assert!(!recorder.takes_commands());
        recorder.block(Some(&frames), &mut outputs);
        recorder.note_overrun();
        recorder.block(None, &mut outputs);
        let first = recorder.take_block().unwrap();
        assert_eq!(first.tick, 11);
        assert_eq!(first.frames.as_slice(), frames);
        assert_eq!(first.notes.given.len(), 1);
        assert_eq!(first.notes.state, State::SelfTest);
        assert!(!first.notes.overrun && !first.notes.stale);
        let second = recorder.take_block().unwrap();
        assert_eq!(second.tick, 21);
        assert!(second.notes.overrun && second.notes.stale);
        assert!(second.notes.given.is_empty());
    }

    #[test]
    fn what_is_not_taken_shows_as_a_gap() {
        let mut recorder = recorder();
        recorder.record(true);
        let mut outputs = [Output::SAFE; crate::BLOCK_TICKS];
        for _ in 0..CAPACITY + 3 {
            recorder.block(None, &mut outputs);
        }
        let mut last = 0;
        while let Some(exchange) = recorder.take_block() {
            last = exchange.tick;
        }
        recorder.block(None, &mut outputs);
        let next = recorder.take_block().unwrap().tick;
        assert_eq!(next - last, 4 * crate::BLOCK_TICKS as u32);
    }
}
