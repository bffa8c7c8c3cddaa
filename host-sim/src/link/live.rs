//! An emulated board behind a pseudo-terminal, in real time: for trying `host-sim link` without a board.

use std::thread;
use std::time::{Duration, Instant};

use serialport::{SerialPort, TTYPort};
use shared::settings::{Settings, TICK_S};

use emulator::board::Served;
use emulator::record::{BlockRow, RunObserver};
use files::UserError;

/// If the emulation is later than this, it goes on from now instead of catching up.
const SLACK: Duration = Duration::from_millis(100);

/// A board after power-on that listens on a pseudo-terminal; and the far end, whose name `host-sim link` takes. It must be
/// held open: without an opener there, the wire reads as broken.
///
/// # Errors
/// If a setting is out of range, or no pseudo-terminal is available.
pub fn board(
    settings: &Settings,
    block_ticks: u8,
) -> Result<(Served<TTYPort>, TTYPort), UserError> {
    let failed = |e: serialport::Error| {
        UserError::new(format!(
            "cannot make a pseudo-terminal: {e}; close some programs"
        ))
    };
    let (mut wire, far_end) = TTYPort::pair().map_err(failed)?;
    wire.set_timeout(Duration::ZERO).map_err(failed)?;
    Ok((Served::new(settings, block_ticks, wire)?, far_end))
}

/// Holds a run back to so many times real time (as fast as it can if that is slower).
#[derive(Debug)]
pub struct Pace {
    speed: f64,
    due: Instant,
}

impl Pace {
    /// From now on.
    pub fn new(speed: f64) -> Self {
        let due = Instant::now();
        Self { speed, due }
    }
}

impl RunObserver for Pace {
    /// Waits until the block is over in real time.
    fn block(&mut self, row: &BlockRow) {
        self.due += Duration::from_secs_f64(row.ticks as f64 * TICK_S / self.speed);
        let now = Instant::now();
        match self.due.checked_duration_since(now) {
            Some(early) => thread::sleep(early),
            None if now - self.due > SLACK => self.due = now,
            None => {}
        }
    }
}
