//! Reading and writing: rig files, tables, columns, and files that are whole or absent.
//!
//! Without the feature `disk` it has rig files, words and tables as CSV, and compiles for a browser.
//!
//! Whatever a person can mend ends in a [`UserError`]: one line that says what is wrong, where, and what to do.

#[cfg(feature = "columns")]
pub mod columns;
pub mod decimal;
mod error;
pub mod ground;
pub mod made_from;
pub mod quiet;
pub mod range;
mod read;
pub mod rigfile;
pub mod settings_file;
pub mod table;
pub mod words;
#[cfg(feature = "disk")]
pub mod write;

pub use error::UserError;
pub use read::{line_at, open_file, read_bytes, read_table, read_text};
pub use table::{Measurements, TableLine};
