//! The hammer on the desktop (being written).
pub mod files;
pub mod picture;
pub mod terminal;
