//! An emulated board behind a pseudo-terminal, in real time: for trying `host-sim link` without a board.

use std::thread;
use std::time::{Duration, Instant};

use serialport::{SerialPort, TTYPort};
use shared::control::{BootInfo, Command, Event, Refused, Status};
use shared::io::{Frame, Output};
use shared::link::Device;
use shared::settings::{Settings, TICK_S};

use super::{Board, Server};
use emulator::local::birth;
use emulator::under_test::{ControlUnderTest, Reset};
use files::UserError;

/// If the emulation is later than this, it goes on from now instead of catching up.
const SLACK: Duration = Duration::from_millis(100);

/// A controller under test that listens on a pseudo-terminal.
#[derive(Debug)]
pub struct Live {
    board: Board,
    settings: Settings,
    server: Server,
    wire: TTYPort,
    /// Held open: without an opener at the far end, the wire reads as broken.
    far_end: TTYPort,
    /// Times faster than real time.
    speed: f64,
    due: Instant,
}

impl Live {
    /// A board after power-on, `speed` times faster than real time (as fast as it can if that is slower).
    ///
    /// # Errors
    /// If a setting is out of range, or no pseudo-terminal is available.
    pub fn new(settings: &Settings, block_ticks: u8, speed: f64) -> Result<Self, UserError> {
        let failed = |e: serialport::Error| {
            UserError::new(format!(
                "cannot make a pseudo-terminal: {e}; close some programs"
            ))
        };
        let (mut wire, far_end) = TTYPort::pair().map_err(failed)?;
        wire.set_timeout(Duration::ZERO).map_err(failed)?;
        Ok(Self {
            board: Board::new(settings, block_ticks)?,
            settings: *settings,
            server: Server::new(),
            wire,
            far_end,
            speed,
            due: Instant::now(),
        })
    }

    /// What to give `host-sim link`.
    pub fn path(&self) -> String {
        self.far_end.name().unwrap_or_default()
    }

    /// Waits until the block is due, and handles what came over the link meanwhile.
    fn turn(&mut self, ticks: usize) {
        let block = Duration::from_secs_f64(ticks as f64 * TICK_S / self.speed);
        let now = Instant::now();
        match self.due.checked_duration_since(now) {
            Some(early) => thread::sleep(early),
            None if now - self.due > SLACK => self.due = now,
            None => {}
        }
        self.due += block;
        // A program that closed the far end may come back; until then there is nothing to read.
        let _ = self.server.step(&mut self.board, &mut self.wire);
    }
}

impl ControlUnderTest for Live {
    fn exchange(&mut self, frames: &[Frame], outputs: &mut [Output], slices: u32) {
        self.turn(outputs.len());
        self.board.exchange(frames, outputs, slices);
    }

    fn exchange_blind(&mut self, outputs: &mut [Output], slices: u32) {
        self.turn(outputs.len());
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
