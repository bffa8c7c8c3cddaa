//! Sentences that put an answer into words.

pub mod compare;
pub mod digits;
pub mod gaps;
pub mod identify;
pub mod map;
pub mod over;
pub mod pick;
