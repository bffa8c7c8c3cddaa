//! Bytes in the settings' flash.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| tests::fuzz::settings(data));
