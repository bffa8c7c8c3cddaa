//! # The hammer on the desktop
//!
//! The command line, and the modules between it and the packages that do the work: [`numerics`] (analyses),
//! [`emulator`], [`files`] (rig files, tables) and [`plot`].
//!
//! | module | what |
//! |---|---|
//! | [`cli`] | one module per command: options, order of work, printed answer |
//! | [`pictures`], [`figures`] | the picture of each analysis; the chapter's figures |
//! | [`record`], [`measured`] | records of sensors and measured points, from files |
//! | [`own_rig`] | a rig file from what a person can measure |
//! | `kept` | the rows of an unfinished answer, on disk |
//! | [`mod@link`] | a board, or an emulated one, on a serial port |
//! | [`page`] | the page in a browser, and a board behind it |
//! | [`replay`] | a log through the controller again |
//! | [`words`] | sentences that put an answer into words |
//! | [`progress`] | the progress bar |

mod chapter;
pub mod cli;
pub mod figures;
mod kept;
pub mod link;
pub mod measured;
pub mod own_rig;
pub mod page;
pub mod pictures;
pub mod progress;
pub mod record;
pub mod replay;
pub mod words;
