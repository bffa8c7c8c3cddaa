//! Sentences that put an answer into words.

pub mod gaps;
pub mod pick;
