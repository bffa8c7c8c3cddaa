//! A rig file from what a person can measure: a scale, a ruler, a stopwatch.

pub mod contact;
pub mod file;
pub mod reading;
pub mod surface;
