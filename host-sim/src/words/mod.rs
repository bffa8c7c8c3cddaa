//! Sentences that put an answer into words.

pub mod compare;
pub mod gaps;
pub mod map;
pub mod over;
