//! Two flash pages for the settings: the last of bank 2, 2 KiB each, at 0x0807 f000 and 0x0807 f800 (memory.x).
//!
//! The program is in bank 1. While a page of bank 2 is erased (22 ms, the data sheet's figure from memory) or written, the
//! processor goes on fetching from bank 1, interrupts and control task with it. That holds for a part whose flash is set to two
//! banks (option bit DBANK), as it is delivered; on any other nothing is saved, and the link says so.
//!
//! Flash is written 8 bytes at a time, each with 8 bits of a code beside it that mends one wrong bit. So a word that was written can be
//! written once more only with zeros (RM0440, "FLASH program and erase operations"). The store needs no more: what
//! it writes again is zeros, or the same as before, which is left out here.
//!
//! A power cut within a write can leave a word with more wrong bits than the code can mend. Reading it raises an NMI
//! ([`acknowledge_damage`]); the settings' own check then finds the slot unfinished or damaged.
#![allow(unsafe_code)]

use embedded_storage::nor_flash::{
    ErrorType, MultiwriteNorFlash, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase,
    check_read, check_write,
};
use shared::{
    link::store::{self, Loaded},
    settings::Settings,
};

use super::pac;
use crate::{hardware::tasks::blocks, link_device::SettingsStore};

/// Bytes of a page.
const PAGE: u32 = 0x800;
/// The first page's number in its bank of 128.
const FIRST_PAGE: u8 = 126;
/// Where the pages begin, and that place within bank 2.
const START: u32 = 0x0807_f000;
const IN_BANK: u32 = START - 0x0804_0000;
/// Bytes written at once.
const WORD: usize = 8;

/// Keys (RM0440, "Flash key register").
const KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];
/// EOP, OPERR, PROGERR, WRPERR, PGAERR, SIZERR, PGSERR, MISERR, FASTERR, RDERR and OPTVERR of FLASH_SR; all but the first
/// are errors.
const FLAGS: u32 = 0xc3fb;
/// Looks at an operation before it is given up: some 50 ms.
const LOOKS: u32 = 1_000_000;

unsafe extern "C" {
    /// Where the linker leaves room; [`START`] must agree with it.
    static __settings_start: u8;
    static __settings_end: u8;
}

/// Takes note of a word beyond repair, if it is one of the settings; false for any other. For the NMI.
pub fn acknowledge_damage() -> bool {
    // SAFETY: reads, and a store of ones that clears two flags.
    let flash = unsafe { &*pac::FLASH::ptr() };
    let damage = flash.eccr().read();
    let at = damage.addr_ecc().bits();
    let ours = damage.bk_ecc().bit() && (IN_BANK..IN_BANK + 2 * PAGE).contains(&at);
    if damage.eccd().bit() && ours {
        flash.eccr().modify(|_, w| w.eccd().set_bit());
        return true;
    }
    false
}

/// The two pages, as a flash of their own that starts at 0.
struct SettingsFlash(pac::FLASH);

impl SettingsFlash {
    /// Does one operation with the flash unlocked. Errors of whatever went before are forgotten first.
    fn operate(&mut self, operation: impl FnOnce(&pac::FLASH)) -> Result<(), NorFlashErrorKind> {
        let flash = &self.0;
        if flash.optr().read().dbank().bit_is_clear() {
            return Err(NorFlashErrorKind::Other);
        }
        wait(flash)?;
        // SAFETY: ones clear these flags and nothing else; the keys of the manual, which unlock the control register.
        unsafe {
            flash.sr().write(|w| w.bits(FLAGS));
            for key in KEYS {
                flash.keyr().write(|w| w.keyr().bits(key));
            }
        }
        operation(flash);
        let done = wait(flash);
        let errors = flash.sr().read().bits() & FLAGS & !1;
        // Locked, and nothing chosen: the value after a reset.
        flash.cr().reset();
        if errors == 0 {
            done
        } else {
            Err(NorFlashErrorKind::Other)
        }
    }

    /// Empties the data cache, which an erasure leaves as it was. It can be emptied only while it is off.
    fn forget_cached_data(&mut self) {
        let acr = self.0.acr();
        acr.modify(|_, w| w.dcen().clear_bit());
        acr.modify(|_, w| w.dcrst().set_bit());
        acr.modify(|_, w| w.dcrst().clear_bit());
        acr.modify(|_, w| w.dcen().set_bit());
    }
}

/// Waits for the end of an operation.
fn wait(flash: &pac::FLASH) -> Result<(), NorFlashErrorKind> {
    let ended = (0..LOOKS).any(|_| flash.sr().read().bsy().bit_is_clear());
    ended.then_some(()).ok_or(NorFlashErrorKind::Other)
}

impl ErrorType for SettingsFlash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for SettingsFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        check_read(self, offset, bytes.len())?;
        for (at, byte) in (START + offset..).zip(bytes) {
            // SAFETY: within the two pages, by the check.
            *byte = unsafe { (at as *const u8).read_volatile() };
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        2 * PAGE as usize
    }
}

/// As far as the store makes use of it: see above.
impl MultiwriteNorFlash for SettingsFlash {}

impl NorFlash for SettingsFlash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        check_erase(self, from, to)?;
        for page in from / PAGE..to / PAGE {
            self.operate(|flash| {
                flash.cr().modify(|_, w| {
                    // SAFETY: a page that the bank has.
                    unsafe { w.pnb().bits(FIRST_PAGE + page as u8) };
                    w.per().set_bit().bker().bank2()
                });
                flash.cr().modify(|_, w| w.strt().set_bit());
            })?;
            self.forget_cached_data();
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        check_write(self, offset, bytes.len())?;
        let (words, _) = bytes.as_chunks::<WORD>();
        for (at, word) in (offset..).step_by(WORD).zip(words) {
            let mut before = [0; WORD];
            self.read(at, &mut before)?;
            if before == *word {
                continue;
            }
            let [a, b, c, d, e, f, g, h] = *word;
            let halves = [[a, b, c, d], [e, f, g, h]].map(u32::from_le_bytes);
            let to = (START + at) as *mut u32;
            self.operate(|flash| {
                flash.cr().modify(|_, w| w.pg().set_bit());
                // SAFETY: a whole word of the two pages, by the check, one half after the other and nothing between.
                unsafe {
                    to.write_volatile(halves[0]);
                    cortex_m::asm::isb();
                    to.add(1).write_volatile(halves[1]);
                }
            })?;
            self.forget_cached_data();
        }
        Ok(())
    }
}

/// The settings in their two pages.
pub struct Store(store::Store<SettingsFlash>);

impl Store {
    /// Takes the flash's registers.
    pub(super) fn new(flash: pac::FLASH) -> Self {
        let flash = SettingsFlash(flash);
        let [start, end] = [&raw const __settings_start, &raw const __settings_end];
        assert!(
            start as u32 == START && end as usize == START as usize + flash.capacity(),
            "memory.x leaves other pages free than are written to"
        );
        Self(store::Store::new(flash, [0..PAGE, PAGE..2 * PAGE]))
    }

    /// What is stored; `None` if the flash cannot be read.
    pub fn load(&mut self) -> Option<Loaded> {
        self.0.load().ok()
    }
}

impl SettingsStore for Store {
    fn store(&mut self, settings: &Settings) -> bool {
        blocks::paused(|| self.0.save(settings)).is_ok()
    }
}
