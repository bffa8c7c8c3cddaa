//! The flash's interface (RM0390, chapter 3): wait states, keys, programming by byte to double word, erasing sectors,
//! errors, the brown-out level in the option bytes. While it works the processor stands at its next fetch. Not modelled: other option
//! bytes' programming, mass erase, read protection, the accelerator's hits and misses.

use super::{Access, UNITS_PER_US, Write};

/// Bytes of the flash.
pub const SIZE: usize = 512 * 1024;
/// First byte of each sector, and the end (RM0390, table 6).
pub const SECTORS: [u32; 9] = [
    0, 0x4000, 0x8000, 0xc000, 0x1_0000, 0x2_0000, 0x4_0000, 0x6_0000, 0x8_0000,
];

/// Programming a byte to a word, typical and longest (DS10693, "Flash memory programming").
const PROGRAM_TIME: [u64; 2] = [16 * UNITS_PER_US, 100 * UNITS_PER_US];
/// Erasing 16, 64 and 128 KiB by bytes, typical; the longest is twice that.
const ERASE_TIME: [u64; 3] = [
    400_000 * UNITS_PER_US,
    1_200_000 * UNITS_PER_US,
    2_000_000 * UNITS_PER_US,
];

const OPERR: u32 = 1 << 1;
const WRPERR: u32 = 1 << 4;
const PGPERR: u32 = 1 << 6;
const PGSERR: u32 = 1 << 7;
const LOCK: u32 = 1 << 31;
const DCEN: u32 = 1 << 10;
const DCRST: u32 = 1 << 12;

/// An operation under way.
#[derive(Clone, Debug, PartialEq)]
pub enum Work {
    /// Bytes being written, and where.
    Program(u32, Vec<u8>),
    /// A sector being erased.
    Erase(usize),
    /// The option bytes being written.
    Options(u32),
}

/// The flash's interface, with its registers and what it is doing.
#[derive(Clone, Debug)]
pub struct Flash {
    access: u32,
    keys: u32,
    status: u32,
    control: u32,
    /// Option bytes: brown-out level, write protection.
    pub options: u32,
    option_keys: u32,
    option_locked: bool,
    /// What it does, and until when.
    pub work: Option<(Work, u64)>,
    /// It takes the longest times of the data sheet, not the typical ones.
    slow: bool,
    /// Operations begun since power-up.
    pub operations: u32,
    /// A sector that was erased while the accelerator's data cache was on, and not emptied since.
    stale: Option<usize>,
}

impl Flash {
    /// Whether a sector is being erased.
    pub fn is_erasing(&self) -> bool {
        matches!(self.work, Some((Work::Erase(_), _)))
    }

    /// The interface after a reset, locked; `slow`: it takes the longest times of the data sheet.
    pub fn new(options: u32, slow: bool) -> Self {
        Self {
            access: 0,
            keys: 0,
            status: 0,
            control: LOCK,
            options,
            option_keys: 0,
            option_locked: true,
            work: None,
            slow,
            operations: 0,
            stale: None,
        }
    }

    /// Wait states of a read that the program has set.
    pub fn latency(&self) -> u32 {
        self.access & 15
    }

    /// An error if the wait states are too few for this clock at a supply from 2.7 V (RM0390, table 5).
    pub fn check(&self, hclk_hz: u64) -> Access {
        let needed = (hclk_hz - 1) / 30_000_000;
        if u64::from(self.latency()) < needed {
            return Err(format!(
                "flash: {} wait states at {hclk_hz} Hz, {needed} are needed (3.4.1)",
                self.latency()
            ));
        }
        Ok(())
    }

    /// Reads the register at `offset`.
    pub fn read(&self, offset: u32) -> Access<u32> {
        Ok(match offset {
            0x00 => self.access,
            0x0c => self.status | u32::from(self.work.is_some()) << 16,
            0x10 => self.control,
            0x14 => self.options & !1 | u32::from(self.option_locked),
            _ => return Err("is not modelled".into()),
        })
    }

    /// Writes the register at `w.offset`, and begins what that begins.
    pub fn write(&mut self, w: Write) -> Access {
        match w.offset {
            0x00 => {
                let new = w.over(self.access, 0x1f0f)?;
                if new & 0x1800 != 0 && (new & self.access) >> 9 & (new >> 11) & 3 != 0 {
                    return Err("a cache of the accelerator is reset while it is on (3.4.2)".into());
                }
                if new & DCRST != 0 {
                    self.stale = None;
                }
                self.access = new;
            }
            0x04 => self.unlock(w.ones())?,
            0x0c => self.status &= !w.over(0, 0x1f3)?,
            0x08 => match (self.option_keys, w.ones()) {
                (0, 0x0819_2a3b) => self.option_keys = 1,
                (1, 0x4c5d_6e7f) if self.option_locked => self.option_locked = false,
                (_, key) => {
                    return Err(format!(
                        "{key:#010x} is not the option bytes' key: locked until the next reset (3.6.2)"
                    ));
                }
            },
            0x10 => self.control(w)?,
            0x14 => self.write_options(w)?,
            _ => return Err("is not modelled".into()),
        }
        Ok(())
    }

    fn unlock(&mut self, key: u32) -> Access {
        match (self.keys, key) {
            (_, _) if self.control & LOCK == 0 => {
                return Err("KEYR is written while unlocked".into());
            }
            (0, 0x4567_0123) => self.keys = 1,
            (1, 0xcdef_89ab) => {
                self.keys = 0;
                self.control &= !LOCK;
            }
            _ => {
                return Err(format!(
                    "{key:#010x} is not the key: locked until the next reset (3.5.1)"
                ));
            }
        }
        Ok(())
    }

    /// FLASH_OPTCR: OPTLOCK, OPTSTRT, brown-out level, and what must stay as it is.
    fn write_options(&mut self, w: Write) -> Access {
        let new = w.over(self.options, !0)?;
        if self.option_locked {
            return Err("FLASH_OPTCR is written while locked".into());
        }
        if self.work.is_some() {
            return Err("FLASH_OPTCR is written while the flash is busy (3.6.2)".into());
        }
        let level = 3 << 2;
        if (new ^ self.options) & !(level | 3) != 0 {
            return Err("of the option bytes more than the brown-out level is changed".into());
        }
        self.options = new & !3;
        if new & 2 != 0 {
            self.operations += 1;
            let time = ERASE_TIME[0] << u32::from(self.slow);
            self.work = Some((Work::Options(new & !3), w.now + time));
        }
        if new & 1 != 0 {
            self.option_locked = true;
            self.option_keys = 0;
        }
        Ok(())
    }

    fn control(&mut self, w: Write) -> Access {
        let new = w.over(self.control, 0x8301_03ff & !0x80)?;
        if self.control & LOCK != 0 {
            return Err("FLASH_CR is written while locked".into());
        }
        if self.work.is_some() {
            return Err("FLASH_CR is written while the flash is busy".into());
        }
        if new & 4 != 0 || new & 0x0300_0000 != 0 {
            return Err("mass erase and interrupts of the flash are not modelled".into());
        }
        if new >> 8 & 3 == 3 && new & (1 | 1 << 16) != 0 {
            return Err(
                "64 bits at once want Vpp, which this board has not (3.5.2, table 7)".into(),
            );
        }
        self.control = new & !(1 << 16);
        if new & LOCK != 0 {
            self.keys = 0;
        }
        if new & 1 << 16 != 0 {
            if new & 2 == 0 || new & 1 != 0 {
                return Err("STRT without SER alone".into());
            }
            let sector = (new >> 3 & 15) as usize;
            if sector >= SECTORS.len() - 1 {
                return Err(format!("sector {sector} does not exist"));
            }
            if self.options >> (16 + sector) & 1 == 0 {
                self.status |= WRPERR | OPERR;
                return Ok(());
            }
            let size = SECTORS[sector + 1] - SECTORS[sector];
            let time = ERASE_TIME[match size {
                0x4000 => 0,
                0x1_0000 => 1,
                _ => 2,
            }] << u32::from(self.slow);
            self.operations += 1;
            self.work = Some((Work::Erase(sector), w.now + time));
        }
        Ok(())
    }

    /// A store of `bytes` into the flash's memory. Without PG it is an error of sequence.
    ///
    /// # Errors
    /// A store while the flash is busy.
    pub fn store(&mut self, offset: u32, bytes: &[u8], now: u64) -> Access {
        if self.work.is_some() {
            return Err("a store to the flash while it is busy".into());
        }
        let sector = SECTORS
            .iter()
            .rposition(|first| *first <= offset)
            .unwrap_or(0);
        if self.control & 1 == 0 || self.control & LOCK != 0 {
            self.status |= PGSERR | OPERR;
        } else if bytes.len() != 1 << (self.control >> 8 & 3) {
            self.status |= PGPERR | OPERR;
        } else if self.options >> (16 + sector) & 1 == 0 {
            self.status |= WRPERR | OPERR;
        } else {
            self.operations += 1;
            self.work = Some((
                Work::Program(offset, bytes.to_vec()),
                now + PROGRAM_TIME[usize::from(self.slow)],
            ));
        }
        Ok(())
    }

    /// Ends the work under way; gives it.
    pub fn end(&mut self) -> Option<Work> {
        let work = self.work.take().map(|(work, _)| work);
        if let Some(Work::Erase(sector)) = work
            && self.access & DCEN != 0
        {
            self.stale = Some(sector);
        }
        work
    }

    /// An error if what is loaded may be what was there before an erasure (3.5.2).
    pub fn check_load(&self, offset: usize) -> Access {
        match self.stale {
            Some(sector) if (SECTORS[sector]..SECTORS[sector + 1]).contains(&(offset as u32)) => {
                Err(format!(
                    "sector {sector} is read after it was erased, and the accelerator's data cache was not emptied"
                ))
            }
            _ => Ok(()),
        }
    }

    /// An error of an earlier operation stands in the status.
    pub fn leave_error(&mut self) {
        self.status |= PGSERR | OPERR;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(flash: &mut Flash, offset: u32, value: u32) -> Access {
        flash.write(Write {
            offset,
            value,
            mask: !0,
            now: 0,
        })
    }

    #[test]
    fn it_is_locked_wants_its_keys_and_its_width() {
        let mut flash = Flash::new(0x0fff_aaed, false);
        write(&mut flash, 0x10, 1).unwrap_err();
        write(&mut flash, 4, 0x4567_0123).unwrap();
        write(&mut flash, 4, 0xcdef_89ab).unwrap();
        flash.store(0x4000, &[0], 0).unwrap();
        assert_eq!(flash.read(0x0c), Ok(PGSERR | OPERR));
        write(&mut flash, 0x0c, PGSERR | OPERR).unwrap();
        write(&mut flash, 0x10, 1).unwrap();
        flash.store(0x4000, &[0, 0], 0).unwrap();
        assert_eq!(flash.read(0x0c), Ok(PGPERR | OPERR));
        flash.store(0x4000, &[0], 0).unwrap();
        assert_eq!(
            flash.work,
            Some((Work::Program(0x4000, vec![0]), PROGRAM_TIME[0]))
        );
        write(&mut flash, 0x10, 0).unwrap_err();
    }

    #[test]
    fn sixty_four_bits_at_once_are_refused_and_a_slow_flash_takes_the_longest() {
        let mut flash = Flash::new(0x0fff_aaed, true);
        write(&mut flash, 4, 0x4567_0123).unwrap();
        write(&mut flash, 4, 0xcdef_89ab).unwrap();
        write(&mut flash, 0x10, 3 << 8 | 2 | 1 << 3 | 1 << 16).unwrap_err();
        write(&mut flash, 0x10, 3 << 8 | 1).unwrap_err();
        write(&mut flash, 0x10, 2 | 1 << 3 | 1 << 16).unwrap();
        let erased = 800_000 * UNITS_PER_US;
        assert_eq!(flash.work, Some((Work::Erase(1), erased)));
        flash.end();
        write(&mut flash, 0x10, 1).unwrap();
        flash.store(0x4000, &[0], 0).unwrap();
        let written = 100 * UNITS_PER_US;
        assert_eq!(flash.work, Some((Work::Program(0x4000, vec![0]), written)));
    }

    #[test]
    fn an_erased_sector_is_not_read_from_the_cache() {
        let mut flash = Flash::new(0x0fff_aaed, false);
        write(&mut flash, 0, DCEN | 5).unwrap();
        write(&mut flash, 4, 0x4567_0123).unwrap();
        write(&mut flash, 4, 0xcdef_89ab).unwrap();
        write(&mut flash, 0x10, 2 | 1 << 3 | 1 << 16).unwrap();
        flash.end();
        flash.check_load(0x4000).unwrap_err();
        flash.check_load(0x3fff).unwrap();
        write(&mut flash, 0, 5).unwrap();
        flash.check_load(0x7fff).unwrap_err();
        write(&mut flash, 0, DCRST | 5).unwrap();
        flash.check_load(0x4000).unwrap();
    }

    #[test]
    fn a_protected_sector_is_not_erased_and_too_few_wait_states_are_refused() {
        let mut flash = Flash::new(0x0ffd_aaed, false);
        write(&mut flash, 4, 0x4567_0123).unwrap();
        write(&mut flash, 4, 0xcdef_89ab).unwrap();
        write(&mut flash, 0x10, 2 | 1 << 3 | 1 << 16).unwrap();
        assert_eq!(flash.read(0x0c), Ok(WRPERR | OPERR));
        flash.check(16_000_000).unwrap();
        flash.check(180_000_000).unwrap_err();
        write(&mut flash, 0, 5).unwrap();
        flash.check(180_000_000).unwrap();
    }
}
