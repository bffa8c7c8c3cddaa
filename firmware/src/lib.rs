//! The hammer on the microcontroller.
//!
//! This library is what both boards share; it has no hardware in it, and also
//! compiles and tests on the host. The apps stand in `src/bin/`, what only one
//! board can run stands behind one module each in `hardware`.
#![no_std]

pub mod control;
#[cfg(feature = "_board")]
pub mod hardware;
pub mod monitor;
