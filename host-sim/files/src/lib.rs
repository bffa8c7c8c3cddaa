//! What is read and written: rig files, tables, and files that are whole or not there at all.
//!
//! Everything a person gets wrong ends in a [`UserError`]: one line that says what, where and the mend.

mod error;
pub mod rigfile;
pub mod table;
mod wording;
pub mod write;

pub use error::UserError;
pub use table::{Line, read_columns};
pub use write::read_text;
