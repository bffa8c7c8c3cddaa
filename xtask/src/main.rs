//! The caretaker (being written).
fn main() {}
