//! The hammer on the desktop (being written).
