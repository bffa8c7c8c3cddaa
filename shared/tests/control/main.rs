//! The controller from outside: its samples, its commands and the end of its link.

mod anything;
mod bench;
mod births;
mod faults;
mod operator;
mod silence;
