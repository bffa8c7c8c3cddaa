//! What the tests in `tests/` share with the fuzzer in `fuzz/`.

pub mod fuzz;
