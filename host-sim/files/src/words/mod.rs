//! Sentences about answers, which the command line prints and its JSON carries.

pub mod digits;
pub mod identify;
pub mod pick;
