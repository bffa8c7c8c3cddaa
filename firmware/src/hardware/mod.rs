//! What only one board can run, and what happens when something goes wrong on
//! it. `unsafe` may be used here, and nowhere else.

#[cfg(any(feature = "board-nucleo", feature = "board-qemu"))]
pub(crate) mod fault;
#[cfg(feature = "board-nucleo")]
pub mod nucleo;
#[cfg(feature = "board-qemu")]
pub mod qemu;
#[cfg(any(feature = "board-nucleo", feature = "board-qemu"))]
pub mod stack;
