//! The program `host-sim` as a user runs it: command lines in, what comes out and which files appear.
//!
//! One test binary of the package `host-sim`, so that Cargo builds the program for it; long answers are asked
//! for once.

mod again;
mod bad_input;
mod basins;
mod bifurcation;
#[cfg(unix)]
mod boards;
mod broken_off;
mod chapter;
mod compare;
mod contact;
mod drill;
mod drop_test;
mod emulate;
mod failed_cells;
mod figures;
#[cfg(unix)]
mod link;
mod link_shared;
mod made_from;
mod map;
mod modes;
mod orbits;
#[cfg(unix)]
mod page;
#[cfg(unix)]
mod page_drive;
#[cfg(unix)]
mod page_rig;
mod pick;
mod pick_limits;
mod pick_over;
mod pick_rop;
mod pipes;
mod poincare;
mod recordings;
mod rig_new;
mod rigs;
mod shell;
mod simulate;
mod snapshots;
mod support;
mod sweep;
mod trials;
mod tutorials;
