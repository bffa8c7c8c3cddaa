//! Sentences about answers, which the command line prints and its JSON carries.

pub mod digits;
#[cfg(not(target_family = "wasm"))]
pub mod identify;
pub mod pick;
