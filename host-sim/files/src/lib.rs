//! What is read and written: rig files, tables, and files that are whole or not there at all.
//!
//! Everything a person gets wrong ends in a [`UserError`]: one line that says what, where and the mend.

pub mod columns;
mod error;
pub mod quiet;
mod read;
pub mod rigfile;
pub mod table;
mod wording;
pub mod write;

pub use error::UserError;
pub use read::{open_file, read_table, read_text};
pub use table::{Line, Measurements};
