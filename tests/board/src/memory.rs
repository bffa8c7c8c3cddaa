//! The memory map (RM0390, chapter 2): flash and its alias at 0, RAM, bit-bands, peripherals, the processor's own.

use crate::core::{Fault, Trap, Try};
use crate::machine::Machine;
use crate::parts::Write;
use crate::parts::flash::SIZE as FLASH_SIZE;

/// Address at which the flash begins.
pub const FLASH: u32 = 0x0800_0000;
/// Address at which the RAM begins.
pub const RAM: u32 = 0x2000_0000;
/// Its bytes: SRAM1 and SRAM2.
pub const RAM_SIZE: usize = 128 * 1024;
/// The bytes of the RAM.
pub type Ram = [u8; RAM_SIZE];
/// The debug block, in the processor's own space.
const DBGMCU: u32 = 0xe004_2000;

/// The number that the first `width` (1, 2 or 4) of these bytes are.
#[inline(always)]
fn number(bytes: &[u8], width: usize) -> u32 {
    match *bytes {
        [a, ..] if width == 1 => u32::from(a),
        [a, b, ..] if width == 2 => u32::from(u16::from_le_bytes([a, b])),
        [a, b, c, d, ..] => u32::from_le_bytes([a, b, c, d]),
        _ => 0,
    }
}

/// The bytes that mark `width` bytes as written.
#[inline(always)]
fn all_known(width: usize) -> u32 {
    0x0101_0101 & low_bytes(width)
}

fn low_bytes(width: usize) -> u32 {
    (u64::from(u32::MAX) >> (32 - 8 * width)) as u32
}

/// VREFINT's code at 3.3 V as the factory measured it on this part: 1.21 V.
pub const VREFINT_CODE: u16 = 1502;

/// What the factory has written (RM0390, chapter 34; DS10693, 6.3.24): identity, flash size, calibration.
fn factory(address: u32, width: usize) -> Option<u32> {
    const CELLS: [(u32, u32); 8] = [
        (0x1fff_7a10, 0x0033_0041),
        (0x1fff_7a14, 0x3234_5105),
        (0x1fff_7a18, 0x3534_3336),
        (0x1fff_7a20, 512 << 16),
        (0x1fff_7a28, (VREFINT_CODE as u32) << 16),
        (0x1fff_7a2c, 943 | 1197 << 16),
        (0x1fff_c000, 0),
        (0x1fff_c008, 0),
    ];
    let word = CELLS.iter().find(|(at, _)| *at == address & !3)?.1;
    Some(word >> (8 * (address & 3)) & low_bytes(width))
}

impl Machine {
    /// Whether RAM is at an address.
    pub(crate) fn is_memory(&self, address: u32) -> bool {
        ((address.wrapping_sub(RAM)) as usize) < RAM_SIZE
    }

    /// From now on these bytes count as written.
    pub(crate) fn know(&mut self, address: u32, count: u32) {
        for i in 0..count {
            let at = address.wrapping_add(i).wrapping_sub(RAM) as usize;
            if let Some(known) = self.known.get_mut(at) {
                *known = 1;
            }
        }
    }

    /// Loads a number of `W` bytes: 1, 2 or 4.
    #[inline(always)]
    pub(crate) fn load<const W: usize>(&mut self, address: u32) -> Try<u32> {
        let at = address.wrapping_sub(RAM) as usize;
        if at <= RAM_SIZE - W {
            if W > 1 && !(address as usize).is_multiple_of(W) {
                self.check_unaligned()?;
            }
            if self.watching {
                self.touch(at, W, false);
            }
            if number(&self.known[at..at + W], W) != all_known(W) {
                return self.load_unknown(address, W);
            }
            return Ok(number(&self.ram[at..at + W], W));
        }
        self.load_elsewhere(address, W)
    }

    #[inline(never)]
    fn load_elsewhere(&mut self, address: u32, width: usize) -> Try<u32> {
        let at = address.wrapping_sub(FLASH) as usize;
        if at < FLASH_SIZE && at + width <= FLASH_SIZE {
            if !(address as usize).is_multiple_of(width) {
                self.check_unaligned()?;
            }
            return self.load_flash(at, width);
        }
        if self.watching {
            self.touch_elsewhere();
        }
        self.load_far(address, width)
    }

    fn check_unaligned(&self) -> Try {
        if self.system.faults_on_unaligned() {
            return Err(Trap::Fault(Fault::Unaligned));
        }
        Ok(())
    }

    fn load_unknown(&mut self, address: u32, width: usize) -> Try<u32> {
        let at = (address - RAM) as usize;
        let permitted = self
            .image
            .random
            .iter()
            .any(|range| range.contains(&address));
        if !permitted {
            return Err(Trap::stop(format!(
                "{width} bytes of RAM at {address:#010x} are read that were never written"
            )));
        }
        Ok(number(&self.ram[at..], width))
    }

    fn load_flash(&mut self, at: usize, width: usize) -> Try<u32> {
        if self.parts.flash.work.is_some() {
            self.wait_for_flash()?;
        }
        self.parts.flash.check_load(at).map_err(Trap::stop)?;
        if let Some(profile) = &mut self.profile {
            profile.load(at);
        }
        if self.watching {
            self.touch_flash(at);
        }
        Ok(number(&self.flash[at..], width))
    }

    fn load_far(&mut self, address: u32, width: usize) -> Try<u32> {
        let shift = 8 * (address & 3);
        let mask = low_bytes(width);
        if (address as usize) < FLASH_SIZE {
            return self.load_flash(address as usize, width);
        }
        match address >> 28 {
            1 if address >> 16 == 0x1fff => factory(address, width).ok_or_else(|| {
                Trap::stop(format!("system memory at {address:#010x} is not modelled"))
            }),
            2 if (0x2200_0000..0x2400_0000).contains(&address) => {
                let offset = address - 0x2200_0000;
                let word = self.load::<4>(RAM + (offset >> 5 & !3))?;
                Ok(word >> (offset >> 2 & 31) & 1)
            }
            4 if (0x4200_0000..0x4400_0000).contains(&address) => {
                let offset = address - 0x4200_0000;
                let word = self.read_part(0x4000_0000 + (offset >> 5 & !3))?;
                Ok(word >> (offset >> 2 & 31) & 1)
            }
            4 | 5 => {
                if !(address as usize).is_multiple_of(width) {
                    return Err(Trap::Fault(Fault::Unaligned));
                }
                Ok(self.read_part(address & !3)? >> shift & mask)
            }
            0xe if address & !0xfff == DBGMCU => {
                let read = self.parts.dbgmcu.read(address & 0xffc);
                let word =
                    read.map_err(|why| Trap::stop(format!("DBGMCU {address:#010x} {why}")))?;
                Ok(word >> shift & mask)
            }
            0xe if address < 0xe010_0000 => Ok(self.read_system(address)? >> shift & mask),
            _ => Err(Trap::Fault(Fault::Bus(address))),
        }
    }

    /// Stores the low `W` bytes of `value`.
    #[inline(always)]
    pub(crate) fn store<const W: usize>(&mut self, address: u32, value: u32) -> Try {
        let at = address.wrapping_sub(RAM) as usize;
        if at <= RAM_SIZE - W {
            if W > 1 && !(address as usize).is_multiple_of(W) {
                self.check_unaligned()?;
            }
            if self.watching {
                self.touch(at, W, true);
            }
            self.ram[at..at + W].copy_from_slice(&value.to_le_bytes()[..W]);
            self.known[at..at + W].copy_from_slice(&all_known(W).to_le_bytes()[..W]);
            return Ok(());
        }
        self.store_far(address, W, value)
    }

    #[inline(never)]
    fn store_far(&mut self, address: u32, width: usize, value: u32) -> Try {
        if self.watching {
            self.touch_elsewhere();
        }
        let shift = 8 * (address & 3);
        let mask = low_bytes(width);
        let at = address.wrapping_sub(FLASH) as usize;
        if at < FLASH_SIZE {
            if self.parts.flash.work.is_some() {
                // The bus waits until the flash is free.
                self.wait_for_flash()?;
            }
            let bytes = value.to_le_bytes();
            let stored = self.parts.flash.store(at as u32, &bytes[..width], self.now);
            stored.map_err(Trap::stop)?;
            self.reschedule();
            self.attend();
            return Ok(());
        }
        match address >> 28 {
            2 if (0x2200_0000..0x2400_0000).contains(&address) => {
                let offset = address - 0x2200_0000;
                let word_at = RAM + (offset >> 5 & !3);
                let bit = 1 << (offset >> 2 & 31);
                let word = self.load::<4>(word_at)? & !bit;
                self.store::<4>(word_at, if value & 1 == 1 { word | bit } else { word })
            }
            4 if (0x4200_0000..0x4400_0000).contains(&address) => {
                let offset = address - 0x4200_0000;
                let word_at = 0x4000_0000 + (offset >> 5 & !3);
                let bit = 1 << (offset >> 2 & 31);
                let word = self.read_part(word_at)? & !bit;
                self.write_part(
                    word_at,
                    if value & 1 == 1 { word | bit } else { word },
                    u32::MAX,
                )
            }
            4 | 5 => {
                if !(address as usize).is_multiple_of(width) {
                    return Err(Trap::Fault(Fault::Unaligned));
                }
                self.write_part(address & !3, (value & mask) << shift, mask << shift)
            }
            0xe if address & !0xfff == DBGMCU => {
                let (value, mask) = ((value & mask) << shift, mask << shift);
                let value = self.around.patch.changed(address, value);
                let w = Write {
                    offset: address & 0xffc,
                    value,
                    mask,
                    now: self.now,
                };
                let written = self.parts.dbgmcu.write(w);
                written.map_err(|why| Trap::stop(format!("DBGMCU {address:#010x} {why}")))
            }
            0xe if address < 0xe010_0000 => {
                self.write_system(address, (value & mask) << shift, mask << shift)
            }
            _ => {
                // The write buffer has taken it: the fault comes after the instruction.
                self.late_fault = true;
                self.attend();
                Ok(())
            }
        }
    }
}
