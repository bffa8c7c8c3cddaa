//! End-to-end tests: the program as a user runs it. They stand in `tests/`; here is what they share with
//! the fuzzer in `fuzz/`.

pub mod fuzz;
