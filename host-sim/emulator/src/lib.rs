//! The emulator: the controller in a closed loop with an emulated rig.
//!
//! Data goes round: set-point codes → shaker → cart and hammer → sensors → codes → controller. Time is true
//! rig time, counted in the controller's ticks; samples and set-points go in blocks, so the loop is one block
//! late, as on the board.
//!
//! | module | what |
//! |---|---|
//! | [`shaker`] | from a set-point code to a force on the cart |
//! | [`motor`] | the other drive: a motor with a crank |
//! | [`cart`] | friction, end stops and tilt |
//! | [`bodies`] | the equations of cart and hammer, and a step of them |
//! | [`plant`] | a tick of true motion, switches located |
//! | [`filter`], [`sensors`] | from what is true to codes |
//! | [`chain`] | the emergency-stop chain and its pin |
//! | [`names`] | states and basins by name |
//! | [`scenario`], [`schedule`] | what happens when; TOML |
//! | [`stuck`] | the motion of a drive that does not obey |
//! | [`world`] | everything outside the controller: plant, sensors, shaker |
//! | [`under_test`], [`local`] | the controller under test, wherever it runs; the one in this process |
//! | [`board`] | a board: the controller, its end of the serial link, a buffer of recorded blocks |
//! | [`in_the_loop`] | in an emulated processor and in this process, compared |
//! | [`run`] | world and controller, block by block |
//! | [`optimum`] | the best the true rig can do |
//! | [`rig_path`] | how the true rig changed, and its mean optimum |
//! | [`summary`], [`verdict`] | counts and sums over a run, and whether it did what it had to, by the true force |
//! | [`log`] | the log of a run: Parquet, and MCAP for Foxglove |
//! | [`timeline`] | the events of a run, in words |
//! | [`record`] | what an observer of a run gets |
//!
//! Without the feature `disk` it reads and writes no logs on disk, and compiles for a browser.

pub mod board;
pub mod bodies;
pub mod cart;
pub mod chain;
pub mod filter;
pub mod ground;
pub mod in_the_loop;
pub mod local;
#[cfg(feature = "columns")]
pub mod log;
pub mod motor;
pub mod names;
pub mod optimum;
pub mod plant;
pub mod record;
pub mod rig_path;
pub mod run;
pub mod scenario;
pub mod schedule;
pub mod sensors;
pub mod shaker;
pub mod stuck;
pub mod summary;
pub mod timeline;
pub mod trials;
pub mod under_test;
pub mod verdict;
pub mod world;
