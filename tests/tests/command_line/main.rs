//! The program `host-sim` as a user runs it: command lines in, what comes out and which files appear.
//!
//! One test binary for all commands: the program is built once, and long answers are asked for once.

mod bad_input;
mod basins;
mod bifurcation;
mod compare;
mod contact;
mod drop_test;
mod emulate;
mod figures;
mod map;
mod modes;
mod orbits;
mod pick;
mod pick_limits;
mod pipes;
mod poincare;
mod rigs;
mod simulate;
mod support;
mod sweep;
