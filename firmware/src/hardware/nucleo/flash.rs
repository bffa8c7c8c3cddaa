//! Two flash sectors for the settings.
//!
//! | sector | address | size |
//! |---|---|---|
//! | 1 | 0x0800 4000 | 16 KiB |
//! | 2 | 0x0800 8000 | 16 KiB |
//!
//! The program's vectors lie in sector 0 and its code from sector 3 on (memory.x), so that flashing a
//! new program leaves the settings alone, and erasing settings takes the shortest time the part has.
//!
//! The part has one flash bank: while it is erased or written, the processor waits at its next fetch, interrupts
//! and the control task with it. Erasing 16 KiB byte by byte takes 0.4 s, at most 0.8 s (DS10693, "Flash memory
//! programming"). So it is done only in Idle with the drive off, the sampling that is missed meanwhile is expected
//! ([`blocks`]), and the watchdog's shortest period is longer ([`super::watchdog`]).
#![allow(unsafe_code)]

use super::watchdog;
use crate::{brown_out, hardware::tasks::blocks, link_device::SettingsStore};
use embedded_storage::nor_flash::{
    ErrorType, MultiwriteNorFlash, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase,
    check_read, check_write,
};
use shared::{
    link::store::{self, Loaded},
    settings::Settings,
};
use stm32f4xx_hal::{
    flash::{FlashExt, LockedFlash},
    pac,
};

/// The first sector's offset in flash.
const OFFSET: u32 = 0x4000;
/// The first sector's number.
const FIRST_SECTOR: u8 = 1;
/// Bytes of a sector.
const SECTOR: u32 = 0x4000;

/// EOP, OPERR, WRPERR, PGAERR, PGPERR, PGSERR and RDERR of FLASH_SR.
const ERRORS: u32 = 0x1f3;

/// Keys of the option bytes (RM0390, "FLASH_OPTKEYR").
const OPTION_KEYS: [u32; 2] = [0x0819_2a3b, 0x4c5d_6e7f];

/// Empties the data cache of the flash accelerator, which an erasure leaves as it was (RM0390, "Adaptive real-time
/// memory accelerator"): what is read next would be what was there before. It can be emptied only while it is off.
fn forget_cached_data() {
    // SAFETY: a cache that is off or empty changes no value that is read.
    let flash = unsafe { &*pac::FLASH::ptr() };
    flash.acr().modify(|_, w| w.dcen().clear_bit());
    flash.acr().modify(|_, w| w.dcrst().set_bit());
    flash.acr().modify(|_, w| w.dcrst().clear_bit());
    flash.acr().modify(|_, w| w.dcen().set_bit());
}

unsafe extern "C" {
    /// Where the linker leaves room; [`OFFSET`] must agree with it.
    static __settings_start: u8;
    static __settings_end: u8;
}

/// The two sectors, as a flash of their own that starts at 0.
struct SettingsFlash(LockedFlash);

impl SettingsFlash {
    fn new(flash: pac::FLASH) -> Self {
        Self(LockedFlash::new(flash))
    }

    /// Clears the error flags of whatever went before: the HAL takes any that is set for an error of its own operation, and
    /// one old error would fail every later save.
    fn forget_errors(&mut self) {
        // SAFETY: ones clear these flags and nothing else; no operation is under way.
        unsafe { (*pac::FLASH::ptr()).sr().write(|w| w.bits(ERRORS)) };
    }

    /// Whether the linker leaves these sectors free.
    fn agrees_with_linker(&self) -> bool {
        let base = self.0.address() + OFFSET as usize;
        (&raw const __settings_start) as usize == base
            && (&raw const __settings_end) as usize == base + self.capacity()
    }
}

impl ErrorType for SettingsFlash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for SettingsFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        check_read(self, offset, bytes.len())?;
        let from = (OFFSET + offset) as usize;
        let to = from + bytes.len();
        let source = FlashExt::read(&self.0)
            .get(from..to)
            .ok_or(NorFlashErrorKind::OutOfBounds)?;
        bytes.copy_from_slice(source);
        Ok(())
    }

    fn capacity(&self) -> usize {
        2 * SECTOR as usize
    }
}

/// Bits that are 1 can be written 0 without erasing (RM0390, "Programming in flash": successive writes).
impl MultiwriteNorFlash for SettingsFlash {}

impl NorFlash for SettingsFlash {
    const WRITE_SIZE: usize = 1;
    const ERASE_SIZE: usize = SECTOR as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        check_erase(self, from, to)?;
        self.forget_errors();
        for sector in from / SECTOR..to / SECTOR {
            self.0
                .unlocked()
                .erase(FIRST_SECTOR + sector as u8)
                .map_err(|_| NorFlashErrorKind::Other)?;
            forget_cached_data();
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        check_write(self, offset, bytes.len())?;
        self.forget_errors();
        self.0
            .unlocked()
            .program((OFFSET + offset) as usize, bytes.iter())
            .map_err(|_| NorFlashErrorKind::Other)
    }
}

/// The settings in their two sectors.
pub struct FlashStore(store::SlotStore<SettingsFlash>);

impl FlashStore {
    /// Takes the flash's registers.
    pub fn new(flash: pac::FLASH) -> Self {
        let flash = SettingsFlash::new(flash);
        assert!(
            flash.agrees_with_linker(),
            "memory.x leaves other sectors free than are written to"
        );
        Self(store::SlotStore::new(
            flash,
            [0..SECTOR, SECTOR..2 * SECTOR],
        ))
    }

    /// What is stored; `None` if the flash cannot be read.
    pub fn load(&mut self) -> Option<Loaded> {
        self.0.load().ok()
    }
}

impl SettingsStore for FlashStore {
    fn store(&mut self, settings: &Settings) -> bool {
        // Whatever is left of its period is shorter than the save may take.
        watchdog::feed();
        blocks::paused(|| self.0.save(settings)).is_ok()
    }

    /// Of the option bytes only the level changes (RM0390, "Programming user option bytes").
    fn set_brown_out(&mut self) -> bool {
        watchdog::feed();
        blocks::paused(|| {
            // SAFETY: this is the flash's owner, and no operation of it is under way.
            let flash = unsafe { &*pac::FLASH::ptr() };
            for key in OPTION_KEYS {
                // SAFETY: the keys that RM0390 names.
                flash.optkeyr().write(|w| unsafe { w.bits(key) });
            }
            let wanted = brown_out::at_level_3(flash.optcr().read().bits());
            // SAFETY: what was read, with another level.
            flash.optcr().write(|w| unsafe { w.bits(wanted) });
            flash.optcr().modify(|_, w| w.optstrt().set_bit());
            // The processor stands at its next fetch meanwhile.
            while flash.sr().read().bsy().bit() {}
            flash.optcr().modify(|_, w| w.optlock().set_bit());
            brown_out::is_level_3(flash.optcr().read().bits())
        })
    }
}
