//! The emulator: a rig that is not there, closed around the controller that will be.
//!
//! Data goes round: set-point codes → shaker → cart and hammer → sensors → codes → controller. Time is true
//! rig time, counted in the controller's ticks; samples and set-points go in blocks, so the loop is one block
//! late, as on the board.
//!
//! | module | what |
//! |---|---|
//! | [`log`] | the log of a run: Parquet, and MCAP for Foxglove |
//! | [`record`] | what a run tells those who watch it |
//! | [`under_test`] | the controller, wherever it runs |

pub mod log;
pub mod record;
pub mod under_test;
