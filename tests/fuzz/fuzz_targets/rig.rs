//! A rig file.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| tests::fuzz::rig(data));
