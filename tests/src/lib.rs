//! End-to-end tests: the program as a user runs it. They stand in `tests/`; this library is empty.
