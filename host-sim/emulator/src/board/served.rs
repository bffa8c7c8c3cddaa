//! A board whose link goes over a stream, as the controller under test.

use std::io::{Read, Write};

use shared::control::{BootInfo, Command, Event, Refused, Status};
use shared::io::{Frame, Output};
use shared::link::Device;
use shared::model::params::ParamError;
use shared::settings::Settings;

use super::{BoardSession, EmulatedBoard};
use crate::local::birth;
use crate::under_test::{ControlUnderTest, Reset};

/// A board that listens on `W`, whose reads and writes return soon. It looks there once before each block.
#[derive(Debug)]
pub struct Served<W> {
    board: EmulatedBoard,
    settings: Settings,
    server: BoardSession,
    wire: W,
}

impl<W: Read + Write> Served<W> {
    /// After power-on.
    ///
    /// # Errors
    /// If a setting is out of range.
    pub fn new(settings: &Settings, block_ticks: u8, wire: W) -> Result<Self, ParamError> {
        Ok(Self {
            board: EmulatedBoard::new(settings, block_ticks)?,
            settings: *settings,
            server: BoardSession::new(),
            wire,
        })
    }

    /// The stream over which the link goes.
    pub fn wire(&mut self) -> &mut W {
        &mut self.wire
    }

    fn listen(&mut self) {
        // A program that closed the far end may come back; until then there is nothing to read.
        let _ = self.server.step(&mut self.board, &mut self.wire);
    }
}

impl<W: Read + Write> ControlUnderTest for Served<W> {
    fn exchange(&mut self, frames: &[Frame], outputs: &mut [Output], slices: u32) {
        self.listen();
        self.board.exchange(frames, outputs, slices);
    }

    fn exchange_blind(&mut self, outputs: &mut [Output], slices: u32) {
        self.listen();
        self.board.exchange_blind(outputs, slices);
    }

    fn command(&mut self, command: Command) -> Result<(), Refused> {
        Device::command(&mut self.board, command)
    }

    fn status(&mut self) -> Status {
        Device::status(&mut self.board)
    }

    fn take_event(&mut self) -> Option<Event> {
        self.board.lockstep().controller.take_event()
    }

    fn note_overrun(&mut self) {
        self.board.note_overrun();
    }

    fn reset(&mut self, cause: Reset) -> BootInfo {
        let birth = birth(cause, &self.board.lockstep().controller.persisted());
        // What came over the link is in flash, and was checked.
        let settings = self.board.settings();
        let _ = self.board.reset(&settings, &birth);
        birth
    }

    fn settings(&self) -> &Settings {
        &self.settings
    }
}
