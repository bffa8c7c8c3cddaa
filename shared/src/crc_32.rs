//! The one CRC of this crate: of frames on the link, settings in flash and the fault record.

use crc::Crc;

/// CRC-32/ISO-HDLC: polynomial 0x04C11DB7, reflected, start and final inversion. One table for all uses.
pub(crate) static CRC_32: Crc<u32> = Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
