//! The vibro-impact hammer's model (being written).
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod contact;
pub mod contacts;
pub mod drive;
pub mod params;
pub mod regime;
pub mod rig;
pub mod scalar;
pub mod step;
pub mod switch;
pub mod trig;
pub mod twin;

pub use scalar::Real;
