//! The hammer on the desktop (being written).
pub mod accuracy;
pub mod branch;
pub mod cli;
pub mod dual;
pub mod engine;
pub mod error;
pub mod files;
pub mod orbit;
pub mod pick;
pub mod picture;
pub mod reference;
pub mod rigfile;
pub mod sweep;
pub mod table;
pub mod terminal;
