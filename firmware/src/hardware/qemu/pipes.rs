//! The two pipes of the processor in the loop: files of the host, by semihosting.
//!
//! Their names are the second and third word of the command line that the emulator passes on. Reading waits for
//! the other side; an end of file is the end of the run.
//!
//! Source: Arm, "Semihosting for AArch32 and AArch64": SYS_OPEN, SYS_READ, SYS_WRITE, SYS_GET_CMDLINE.
#![allow(unsafe_code)]

use cortex_m_semihosting::{syscall, syscall1};
use heapless::Vec;
use serde::de::DeserializeOwned;
use shared::link::in_the_loop::{LENGTH, MAX_MESSAGE, decode, length};

/// Longest command line, bytes.
const COMMAND_LINE: usize = 512;
/// Bytes of a message with its length.
const BUFFER: usize = LENGTH + MAX_MESSAGE;

/// fopen's "rb" and "wb", as the interface numbers them.
const READ: usize = 1;
const WRITE: usize = 5;

/// The two pipes to the emulator: requests in, replies out.
pub struct Pipes {
    requests: usize,
    replies: usize,
    /// What has been read and not yet been used.
    waiting: Vec<u8, BUFFER>,
}

impl Pipes {
    /// Opens both: requests first, and waits for the other side to do the same.
    pub fn open() -> Option<Self> {
        let line = command_line()?;
        let mut words = line.split(|byte| *byte == b' ').skip(1);
        let mut open = |mode| open(words.next()?, mode);
        Some(Self {
            requests: open(READ)?,
            replies: open(WRITE)?,
            waiting: Vec::new(),
        })
    }

    /// The next message; `None` at the end or if malformed.
    pub fn receive<M: DeserializeOwned>(&mut self) -> Option<M> {
        loop {
            if let [low, high, rest @ ..] = self.waiting.as_slice() {
                let wanted = length([*low, *high])?;
                if rest.len() >= wanted {
                    // The other side waits for the reply: nothing stands behind the message.
                    let message = rest.get(..wanted).filter(|_| rest.len() == wanted);
                    let message = message.and_then(decode);
                    self.waiting.clear();
                    return message;
                }
            }
            self.fill()?;
        }
    }

    /// Reads what is there, at least a byte; a read may bring less than was asked for.
    fn fill(&mut self) -> Option<()> {
        let mut bytes = [0_u8; BUFFER];
        let room = BUFFER - self.waiting.len();
        // SAFETY: a handle that was opened, and a buffer of at least `room` bytes.
        let missing = unsafe { syscall!(READ, self.requests, bytes.as_mut_ptr(), room) };
        let came = room.checked_sub(missing).filter(|came| *came > 0)?;
        self.waiting.extend_from_slice(bytes.get(..came)?).ok()
    }

    /// Sends bytes; `None` if the other side is gone.
    pub fn send(&mut self, bytes: &[u8]) -> Option<()> {
        // SAFETY: a handle that was opened, and a buffer of that length.
        let missing = unsafe { syscall!(WRITE, self.replies, bytes.as_ptr(), bytes.len()) };
        (missing == 0).then_some(())
    }
}

fn open(name: &[u8], mode: usize) -> Option<usize> {
    // With the 0 that the interface wants behind the name.
    let mut text = Vec::<u8, COMMAND_LINE>::from_slice(name).ok()?;
    text.push(0).ok()?;
    // SAFETY: a string that ends with a 0, and its length without it.
    let handle = unsafe { syscall!(OPEN, text.as_ptr(), mode, name.len()) };
    (handle != usize::MAX).then_some(handle)
}

/// The command line as the emulator passes it on, without its final 0.
fn command_line() -> Option<Vec<u8, COMMAND_LINE>> {
    let mut bytes = [0_u8; COMMAND_LINE];
    let mut block = [bytes.as_mut_ptr() as usize, bytes.len()];
    // SAFETY: a block of a buffer's address and its length; the host writes to both.
    let failed = unsafe { syscall1!(GET_CMDLINE, block.as_mut_ptr()) };
    let line = bytes.split(|byte| *byte == 0).next()?;
    (failed == 0).then(|| line.iter().copied().collect())
}
