//! The computer's end of the serial link ([`shared::link`]), and the board's end for the emulator.
//!
//! | module | what |
//! |---|---|
//! | [`board`] | an emulated board |
//! | [`client`] | sends requests, waits for answers |
//! | `port` | opens a port and leaves it free |
//! | [`server`] | the board's side over a stream, for an emulated board |
//! | [`settings_file`] | settings as a TOML file |
//! | [`by_hand`] | a force curve measured in manual mode |
//! | `live` | an emulated board behind a pseudo-terminal (Unix) |
//! | [`recording`] | writes a stream of blocks into a log |

pub mod board;
pub mod by_hand;
pub mod client;
#[cfg(unix)]
pub mod live;
mod port;
pub mod recording;
pub mod server;
pub mod settings_file;

pub use board::Board;
pub use client::{Client, open};
pub use server::Server;
