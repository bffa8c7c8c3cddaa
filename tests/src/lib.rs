//! End-to-end tests stand in `tests/`; this library is empty.
