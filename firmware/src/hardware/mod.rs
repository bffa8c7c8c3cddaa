//! Code for one board each, and its handling of panics and processor faults.
//! `unsafe` may be used here, and nowhere else.
//!
//! A board is one folder: its registers, its `app.rs` (the tasks and what they are bound to) and its `memory.x`. What is
//! the same on every board is in the library and knows no register. A second board takes a folder like `nucleo`, a feature
//! and a binary in Cargo.toml, a line in build.rs and one in xtask's list of boards.

#[cfg(any(feature = "board-nucleo", feature = "board-qemu"))]
pub(crate) mod fault;
#[cfg(feature = "board-nucleo")]
pub mod nucleo;
#[cfg(feature = "board-qemu")]
pub mod qemu;
#[cfg(any(feature = "board-nucleo", feature = "board-qemu"))]
pub mod stack;
