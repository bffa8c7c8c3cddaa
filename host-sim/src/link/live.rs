//! An emulated board behind a pseudo-terminal, in real time: for trying `host-sim link` without a board.

use std::thread;
use std::time::{Duration, Instant};

use serialport::{SerialPort, TTYPort};
use shared::control::{BootInfo, Command, Event, Refused, Status};
use shared::io::{Frame, Output};
use shared::settings::{Settings, TICK_S};

use emulator::board::Served;
use emulator::under_test::{ControlUnderTest, Reset};
use files::UserError;

/// If the emulation is later than this, it goes on from now instead of catching up.
const SLACK: Duration = Duration::from_millis(100);

/// A controller under test that listens on a pseudo-terminal.
#[derive(Debug)]
pub struct Live {
    board: Served<TTYPort>,
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
            board: Served::new(settings, block_ticks, wire)?,
            far_end,
            speed,
            due: Instant::now(),
        })
    }

    /// What to give `host-sim link`.
    pub fn path(&self) -> String {
        self.far_end.name().unwrap_or_default()
    }

    /// Waits until the block is due.
    fn turn(&mut self, ticks: usize) {
        let block = Duration::from_secs_f64(ticks as f64 * TICK_S / self.speed);
        let now = Instant::now();
        match self.due.checked_duration_since(now) {
            Some(early) => thread::sleep(early),
            None if now - self.due > SLACK => self.due = now,
            None => {}
        }
        self.due += block;
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
        self.board.command(command)
    }

    fn status(&mut self) -> Status {
        self.board.status()
    }

    fn take_event(&mut self) -> Option<Event> {
        self.board.take_event()
    }

    fn note_overrun(&mut self) {
        self.board.note_overrun();
    }

    fn reset(&mut self, cause: Reset) -> BootInfo {
        self.board.reset(cause)
    }

    fn settings(&self) -> &Settings {
        self.board.settings()
    }
}
