//! Bytes from the wire, in either direction.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| tests::fuzz::link(data));
