//! Code for one board each, and its handling of panics and processor faults.
//! `unsafe` may be used here, and nowhere else.
//!
//! A board is one folder: its registers, its `app.rs` (which interrupt starts which task), its `memory.x`, its pins (in
//! `mod.rs`) and its `board.toml`, from which `cargo xtask` knows what is built for it. What the tasks of a board that a
//! rig hangs on do, the same on each, is in [`tasks`] and knows no register. Beside its folder a board has three things that
//! Cargo and rustc want named: in Cargo.toml a feature (`board-NAME`) and a program, and a line below.

/// The board that is built.
#[cfg_attr(feature = "board-nucleo", path = "nucleo/mod.rs")]
#[cfg_attr(feature = "board-qemu", path = "qemu/mod.rs")]
pub mod board;
pub(crate) mod fault;
pub mod stack;
#[cfg(feature = "_rig")]
pub mod tasks;
