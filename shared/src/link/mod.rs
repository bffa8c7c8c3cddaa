//! The serial link: requests of a computer to the controller, answers and telemetry.
//!
//! ## On the wire
//!
//! A message is a [`Packet`] in postcard's encoding, followed by its CRC-32 (ISO-HDLC, polynomial 0x04C11DB7
//! reflected, little-endian) and wrapped by COBS; a 0 ends it. Since a 0 stands nowhere else, a reader that
//! has lost its place finds it again at the next one. The CRC finds every burst of up to 32 bits.
//!
//! Each side numbers the packets it *meant* to send. The board drops whole packets when its queue is full
//! and counts them all the same, so a gap in the numbers is what was lost.
//!
//! ## Who steers
//!
//! One program at a time: the one that has the *session*. It asks for the board's state, opens a session with the
//! numbers in it, and sends every act with the session's number and a number of its own that grows. The session lives
//! while such acts come (a [`Command::Alive`](crate::control::Command::Alive) now and then is enough) and ends when it is
//! released, taken over by a program that says so, silent for [`SESSION_S`] (or the settings' link timeout, if that is
//! longer), or when the board starts anew. Everything else, from status requests to recordings, is watching: it needs no
//! session and is a sign of life of nobody.
//!
//! Every message that steers names the boot and the session, and a number that has not been used. So one that was
//! recorded and is sent again, or was stuck on the way, does nothing.
//!
//! A stop is obeyed from anybody, in every state and every version. It can do no harm, and whoever sees a reason
//! for it must not need to be the one who steers. That the drive goes off when the program that steers falls silent is
//! the controller's affair ([`crate::control`]), not the session's.
//!
//! This is no protection against somebody who means harm: who can write to the wire can open a session.
//!
//! ## Versions
//!
//! [`PROTOCOL_VERSION`] changes when an existing message changes. New messages are appended to the enums and
//! change nothing for those who do not know them: such a packet has a good CRC, is not understood, is
//! counted as [`Counters::unknown`] and dropped. [`ToBoard::Hello`] (the first message) and [`LinkAnswer::Hello`]
//! (the first answer, with the version as its first field) keep their encoding for ever, so that two
//! versions can always recognise each other.
//!
//! ## Waiting
//!
//! Neither side waits for the other: a [`Session`] runs below control priority, telemetry that does not fit is dropped, and answers
//! have a part of the queue that telemetry may not fill ([`ANSWER_RESERVE`]).
//!
//! ## Why not postcard-rpc
//!
//! The server of postcard-rpc 0.12 is a set of `async` traits that need an executor to poll and to spawn
//! on (its implementations are for embassy's USB and async serial), and its frames carry no CRC. RTIC tasks
//! here are run to completion, and a UART beside a shaker's power stage wants a CRC; so the encoding is the
//! same, postcard, and the dispatch is one `match` in [`Session`].

mod codec;
mod identified;
pub mod in_the_loop;
mod message;
mod queue;
mod recording;
mod session;
pub mod store;
#[cfg(test)]
mod tests;

pub use codec::{Counters, Decoder, encode};
pub use identified::Identified;
pub use message::{
    BoardState, ForecastPage, FromBoard, Hello, LinkAct, LinkAnswer, LinkName, Packet,
    ROWS_PER_PAGE, Refusal, Telemetry, ToBoard,
};
pub use queue::ByteQueue;
pub use recording::{BlockNotes, GivenCommand, MAX_GIVEN, RecordedBlock, Recording};
pub use session::{Boot, Device, SESSION_S, Session};

/// Changes when an existing message does.
pub const PROTOCOL_VERSION: u16 = 4;

/// Bits per second on the board's serial port, 8 data bits, no parity, 1 stop bit. Divides without a
/// remainder on both ends of a NUCLEO-F446RE's virtual port (45 MHz / 20 and 36 MHz / 16), and carries a
/// recording of every tick: 90 to 99 bytes per block of 10 ticks are 1.8 to 2 Mbit/s. Not tried on silicon.
pub const BAUD: u32 = 2_250_000;

/// The rates that a board knows, the usual one first. At the slower one everything but a recording of every tick goes through.
pub const RATES: [u32; 2] = [BAUD, 921_600];

/// Longest packet in postcard's encoding, bytes; tests hold the longest message of each kind to it.
pub const MAX_PACKET: usize = 408;

/// Longest frame on the wire, bytes: packet, CRC, one COBS byte per 254 and one more, and the final 0.
pub const MAX_FRAME: usize = {
    let checked = MAX_PACKET + 4;
    checked + checked / 254 + 2
};

/// What telemetry leaves free in the queue, bytes: room for the longest answer.
pub const ANSWER_RESERVE: usize = MAX_FRAME;
