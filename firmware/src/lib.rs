//! The hammer on the microcontroller.
//!
//! This library is what both boards share; it has no hardware in it, and also
//! compiles and tests on the host. The apps stand in `src/bin/`, what only one
//! board can run stands behind one module each in `hardware`.
#![no_std]

#[cfg(test)]
extern crate std;

pub mod bench;
pub mod button;
#[cfg(feature = "_board")]
pub mod hardware;
pub mod histogram;
pub mod led;
#[cfg(feature = "_board")]
pub mod link_device;
pub mod liveness;
pub mod model;
pub mod recorder;
pub mod reset;

/// Ticks of a block: samples arrive and set-points are played 10 at a time, 500 µs.
pub const BLOCK_TICKS: usize = 10;
