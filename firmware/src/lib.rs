//! The hammer on the microcontroller.
//!
//! This library is common to both boards. It has no hardware in it, and also
//! compiles and tests on the host. What is for one board only, its app
//! included, is in one folder each of `hardware`; the other programs are in `src/bin/`.
#![no_std]

#[cfg(test)]
extern crate std;

pub mod bench;
pub mod brown_out;
pub mod button;
#[cfg(feature = "_board")]
pub mod hardware;
pub mod histogram;
pub mod interlock;
pub mod led;
#[cfg(feature = "_board")]
pub mod link_device;
pub mod liveness;
pub mod model;
pub mod ramp;
pub mod record_keeper;
pub mod recorder;
pub mod reference;
pub mod reset;
pub mod wire;

/// Ticks of a block: samples arrive and set-points are played 10 at a time, 500 µs.
pub const BLOCK_TICKS: usize = 10;
