//! What only one board can run. `unsafe` may be used here, and nowhere else.

#[cfg(feature = "board-nucleo")]
pub mod nucleo;
#[cfg(feature = "board-qemu")]
pub mod qemu;
