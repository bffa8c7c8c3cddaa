//! Bytes in the settings' flash.

use embedded_storage::nor_flash::{
    ErrorType, MultiwriteNorFlash, NorFlash, NorFlashErrorKind, ReadNorFlash,
};
use shared::link::store::{IMAGE_BYTES, Loaded, Saved, SlotStore};
use shared::model::params::WIRES;
use shared::settings::Settings;

use super::CRC_32;

const SLOT: usize = 1024;

/// Whatever stands in flash: nothing panics, settings that come out can be run with, and new ones can be
/// stored and come out. The first byte's lowest two bits say which slots get a right header and CRC, so
/// that what lies behind those is reached; its other bits are the sequence numbers.
pub fn settings(data: &[u8]) {
    let Some((mode, rest)) = data.split_first() else {
        return;
    };
    let half = rest.len() / 2;
    let mut flash = Flash(vec![0xff; 2 * SLOT]);
    let (first, second) = flash.0.split_at_mut(SLOT);
    let slots = [(first, &rest[..half]), (second, &rest[half..])];
    for (i, (slot, bytes)) in slots.into_iter().enumerate() {
        if mode & (1 << i) == 0 {
            slot.iter_mut().zip(bytes).for_each(|(a, b)| *a = *b);
        } else {
            stored(slot, bytes, (mode >> 2 >> (3 * i)) & 7);
        }
    }
    let mut store = SlotStore::new(flash, [0..SLOT as u32, SLOT as u32..2 * SLOT as u32]);
    match store.load() {
        Ok(Loaded::Settings(settings)) => {
            assert!(settings.check().is_ok(), "{settings:?}");
            assert_eq!(store.save(&settings), Ok(Saved::Unchanged));
        }
        // Confirmed, it is stored anew.
        Ok(Loaded::OlderCopy(settings)) => {
            assert!(settings.check().is_ok(), "{settings:?}");
            assert_eq!(store.save(&settings), Ok(Saved::Written));
            assert!(matches!(store.load(), Ok(Loaded::Settings(s)) if s == settings));
        }
        _ => {}
    }
    let mut new = Settings::for_rig(&WIRES);
    new.trips.no_contact_s = 3.25;
    store.save(&new).expect("flash that works");
    let loaded = store.load();
    assert!(
        matches!(loaded, Ok(Loaded::Settings(settings)) if settings == new),
        "{loaded:?}"
    );
}

/// `payload` as the store writes it: name, layout 2, length, sequence, CRC; payload at 64.
fn stored(slot: &mut [u8], payload: &[u8], sequence: u8) {
    let payload = &payload[..payload.len().min(IMAGE_BYTES - 64)];
    let mut header = b"VIHS\x02\x00".to_vec();
    header.extend((payload.len() as u16).to_le_bytes());
    // Some where numbers wrap.
    header.extend(u32::from(sequence).wrapping_sub(3).to_le_bytes());
    let mut checked = header.clone();
    checked.extend(payload);
    header.extend(CRC_32.checksum(&checked).to_le_bytes());
    slot[..16].copy_from_slice(&header);
    slot[64..64 + payload.len()].copy_from_slice(payload);
}

#[derive(Debug)]
struct Flash(Vec<u8>);

impl ErrorType for Flash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        let from = offset as usize;
        bytes.copy_from_slice(&self.0[from..from + bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.len()
    }
}

impl MultiwriteNorFlash for Flash {}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SLOT;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        self.0[from as usize..to as usize].fill(0xff);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        let to = self.0.iter_mut().skip(offset as usize);
        to.zip(bytes).for_each(|(a, b)| *a &= b);
        Ok(())
    }
}
