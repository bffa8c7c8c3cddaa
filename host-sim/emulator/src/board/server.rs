//! The board's side of the link over a stream, for an emulated board.

use std::io::{self, ErrorKind, Read, Write};

use shared::link::{Device, Session};

/// Bytes of the emulated board's queue: more than a second of recording, for a computer with much to do.
const QUEUE: usize = 1 << 18;

/// A session over a stream whose reads and writes return soon.
#[derive(Debug, Default)]
pub struct BoardSession {
    session: Box<Session<QUEUE>>,
    /// Taken from the queue, not yet taken by the stream.
    unsent: Vec<u8>,
}

impl BoardSession {
    /// A session in which nothing has been received yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes in what the stream brings, carries it out on `device`, and sends what is due. Call it at least
    /// once per block while recording. A stream that takes nothing more fills the session's queue, which
    /// then drops telemetry.
    ///
    /// # Errors
    /// If the stream fails. Nothing to read, or no space to write, is no failure.
    pub fn step(
        &mut self,
        device: &mut impl Device,
        stream: &mut (impl Read + Write),
    ) -> io::Result<()> {
        let mut bytes = [0; 1024];
        match stream.read(&mut bytes) {
            Ok(count) => {
                for byte in &bytes[..count] {
                    self.session.receive(*byte, device);
                }
            }
            Err(e) if is_patience(&e) => {}
            Err(e) => return Err(e),
        }
        self.session.poll(device);
        if self.unsent.is_empty() {
            let count = self.session.queue().drain(&mut bytes);
            self.unsent.extend(&bytes[..count]);
        }
        if self.unsent.is_empty() {
            return Ok(());
        }
        match stream.write(&self.unsent) {
            Ok(count) => {
                self.unsent.drain(..count);
                Ok(())
            }
            Err(e) if is_patience(&e) => Ok(()),
            Err(e) => Err(e),
        }
    }
}

/// Whether a read or write only timed out.
fn is_patience(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
    )
}
