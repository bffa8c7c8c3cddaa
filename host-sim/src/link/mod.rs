//! The computer's end of the serial link ([`shared::link`]). The board's end for the emulator is [`emulator::board`].
//!
//! | module | what |
//! |---|---|
//! | [`client`] | sends requests, waits for answers |
//! | [`clock`] | whether its controller goes on |
//! | `port` | opens a port and leaves it free |
//! | [`by_hand`] | a force curve measured in manual mode |
//! | `live` | an emulated board behind a pseudo-terminal (Unix) |
//! | [`recording`] | writes a stream of blocks into a log |

pub mod by_hand;
pub mod client;
pub mod clock;
#[cfg(unix)]
pub mod live;
mod port;
pub mod recording;

pub use client::{Client, open};
pub use emulator::board::{BoardSession, EmulatedBoard};
