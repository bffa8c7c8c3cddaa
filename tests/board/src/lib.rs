//! An executable model of the NUCLEO-F446RE: the very image that is flashed runs in it.
//!
//! | module | what |
//! |---|---|
//! | [`core`] | the processor: instructions, exceptions, interrupts, its own registers |
//! | [`parts`] | the peripherals, one file each |
//! | [`memory`], [`bus`] | where all of them are |
//! | [`events`], [`run`] | what happens by itself; instructions and time |
//! | [`waiting`], [`skip`] | loops in which the program waits, passed over |
//! | [`machine`], [`outside`] | the board as a whole, power and resets; what the world does to it |
//! | [`stop`], [`cache`] | why a run ended; lines that the flash's accelerator holds |
//! | [`image`] | the program and its names |
//! | [`checks`] | what runs in it |
//! | [`profile`] | what blocks cost and how long interrupts are masked |
//! | [`fingerprint`] | one number for all that a run did |
//! | [`rig`] | the board in a closed loop with the emulator's plant, and the link's wire |
//!
//! It is strict: whatever the manual forbids, and whatever is not modelled, ends the run with address, instruction
//! and source line. docs/board-machine.md says what is modelled and what a run proves.

pub mod bus;
pub mod cache;
pub mod checks;
pub mod core;
pub mod events;
pub mod fingerprint;
pub mod image;
pub mod machine;
pub mod memory;
pub mod outside;
pub mod parts;
pub mod profile;
pub mod rig;
pub mod run;
pub mod skip;
pub mod stop;
#[cfg(test)]
mod tests;
pub mod waiting;
