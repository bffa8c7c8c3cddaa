//! Code for one board each, and its handling of panics and processor faults.
//! `unsafe` may be used here, and nowhere else.

#[cfg(any(feature = "board-nucleo", feature = "board-qemu"))]
pub(crate) mod fault;
#[cfg(feature = "board-nucleo")]
pub mod nucleo;
#[cfg(feature = "board-qemu")]
pub mod qemu;
#[cfg(any(feature = "board-nucleo", feature = "board-qemu"))]
pub mod stack;
