//! No test: `cargo test --workspace` builds the library because of it, with the same features of its dependencies as everything else.
//! The tests are Python's, beside this file.
