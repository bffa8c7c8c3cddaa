//! Whether a board's controller goes on.

use std::time::{Duration, Instant};

use emulator::names::state_name;
use shared::control::Status;

/// A controller whose tick does not change for so long has stopped.
const STANDSTILL: Duration = Duration::from_secs(5);

/// A controller's clock, watched for standing still.
#[derive(Debug, Default)]
pub struct Clock {
    last: Option<(u32, Instant)>,
}

impl Clock {
    /// A clock of which nothing is known yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes the tick of a status.
    ///
    /// # Errors
    /// If it has not changed for five seconds.
    pub fn goes_on(&mut self, status: &Status) -> Result<(), String> {
        match self.last {
            Some((tick, since)) if tick == status.tick => {
                if since.elapsed() > STANDSTILL {
                    return Err(format!(
                        "the controller stands still in {} at tick {tick}; reset the board",
                        state_name(status.state)
                    ));
                }
            }
            _ => self.last = Some((status.tick, Instant::now())),
        }
        Ok(())
    }
}
