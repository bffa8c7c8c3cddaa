//! What must hold for any bytes whatever: bodies for the fuzzer (`fuzz/`) and for the bounded run in the
//! ordinary tests. Each panics when something does not hold.

mod device;
mod files;
mod link;
mod settings;

pub use files::{log, rig, scenario, signal, table};
pub use link::link;
pub use settings::settings;

/// CRC-32/ISO-HDLC, as frames and stored settings have it.
const CRC_32: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
