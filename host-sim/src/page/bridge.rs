//! The hub at a serial port.

use std::io::{self, Read, Write};
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use serialport::SerialPort;

use super::hub::Hub;
use super::mailbox::Mailbox;
use crate::link::client::{self, Opened, is_patience};

/// Pages at one board at most.
const MAX_PAGES: usize = 16;

/// Time from one attempt to find a lost board again to the next.
const AGAIN: Duration = Duration::from_secs(1);

/// How long the last stop may take when the program ends.
const FAREWELL: Duration = Duration::from_secs(2);

/// Where pages come in.
#[derive(Debug, Default)]
pub struct Door {
    newcomers: Mutex<Vec<Arc<Mailbox>>>,
    /// Pages that have come so far.
    numbered: AtomicU32,
    present: AtomicUsize,
}

impl Door {
    /// A page comes in; none if there are too many.
    pub(super) fn enter(&self) -> Option<Arc<Mailbox>> {
        if self.present.fetch_add(1, Ordering::AcqRel) >= MAX_PAGES {
            self.leave();
            return None;
        }
        let number = self.numbered.fetch_add(1, Ordering::AcqRel) + 1;
        let mailbox = Arc::new(Mailbox::new(number));
        self.waiting().push(Arc::clone(&mailbox));
        Some(mailbox)
    }

    /// A page has gone, and another may come in.
    pub(super) fn leave(&self) {
        self.present.fetch_sub(1, Ordering::AcqRel);
    }

    fn waiting(&self) -> std::sync::MutexGuard<'_, Vec<Arc<Mailbox>>> {
        self.newcomers
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

/// A port that carries the protocol.
#[derive(Debug)]
pub struct Port {
    /// Name of the port, at which the board is looked for again if it is lost.
    pub name: String,
    /// The conversation that found the board.
    pub opened: Opened,
}

/// Carries messages between pages and board until `over`; then stops the drive if a page commands it. A board that is lost
/// is looked for again.
pub fn run(door: &Door, port: Port, over: &dyn Fn() -> bool) {
    let Port { name, opened } = port;
    let Opened {
        client,
        hello,
        baud,
    } = opened;
    let (stream, sequence) = client.into_parts();
    let mut hub = Hub::new(&name, hello, sequence, Instant::now());
    let mut wire = Some(Wire::new(stream));
    let mut tried = Instant::now();
    while !over() {
        turn(door, &mut hub);
        match &mut wire {
            Some(open) => {
                if let Err(e) = open.turn(&mut hub) {
                    let why = format!("{name}: the connection broke: {e}; check the cable");
                    hub.board_lost(&why);
                    wire = None;
                }
            }
            None if tried.elapsed() > AGAIN => {
                if let Ok(opened) = client::open(&name, Some(baud)) {
                    wire = Some(Wire::new(opened.client.into_parts().0));
                    hub.board_back(opened.hello, Instant::now());
                }
                tried = Instant::now();
            }
            None => std::thread::sleep(Duration::from_millis(20)),
        }
    }
    if let Some(mut wire) = wire {
        farewell(&mut hub, &mut wire);
    }
}

fn turn(door: &Door, hub: &mut Hub) {
    let newcomers = std::mem::take(&mut *door.waiting());
    newcomers.into_iter().for_each(|mailbox| hub.join(mailbox));
    let now = Instant::now();
    hub.serve(now);
    hub.tick(now);
}

/// Nobody commands when the program has ended.
fn farewell(hub: &mut Hub, wire: &mut Wire) {
    let until = Instant::now() + FAREWELL;
    if hub.is_commanded() {
        hub.stop_drive(Instant::now());
    }
    while hub.is_stopping() && Instant::now() < until && wire.turn(hub).is_ok() {
        hub.tick(Instant::now());
    }
}

/// An open port, whose reads and writes wait for milliseconds at most.
struct Wire {
    port: Box<dyn SerialPort>,
    /// What is left of a frame that the port has not taken as a whole.
    unsent: Vec<u8>,
}

impl Wire {
    fn new(port: Box<dyn SerialPort>) -> Self {
        Self {
            port,
            unsent: Vec::new(),
        }
    }

    /// Sends what waits, and reads once.
    fn turn(&mut self, hub: &mut Hub) -> io::Result<()> {
        loop {
            if self.unsent.is_empty() {
                match hub.next_out() {
                    Some(frame) => self.unsent = frame,
                    None => break,
                }
            }
            match self.port.write(&self.unsent) {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                Ok(count) => {
                    self.unsent.drain(..count);
                }
                Err(e) if is_patience(&e) => break,
                Err(e) => return Err(e),
            }
        }
        let mut bytes = [0; 4096];
        match self.port.read(&mut bytes) {
            // A terminal whose other end has gone reads as ended.
            Ok(0) => Err(io::ErrorKind::UnexpectedEof.into()),
            Ok(count) => {
                hub.hear(&bytes[..count], Instant::now());
                Ok(())
            }
            Err(e) if is_patience(&e) => Ok(()),
            Err(e) => Err(e),
        }
    }
}
