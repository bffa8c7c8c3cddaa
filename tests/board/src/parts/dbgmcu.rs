//! Debug support (RM0390, chapter 33): identity, and which clocks stand while the processor is halted: the watchdog's
//! and TIM2's. Only power-up resets it. Not modelled: the low-power bits, trace pins.

use super::{Access, Write};

/// Debug support with its registers.
#[derive(Clone, Debug, Default)]
pub struct Dbgmcu {
    control: u32,
    freezes: [u32; 2],
}

impl Dbgmcu {
    /// Whether the watchdog stands while the processor is halted.
    pub fn freezes_watchdog(&self) -> bool {
        self.freezes[0] >> 12 & 1 == 1
    }

    /// Whether TIM2 stands while the processor is halted.
    pub fn freezes_tim2(&self) -> bool {
        self.freezes[0] & 1 == 1
    }

    /// Reads the register at `offset`.
    pub fn read(&self, offset: u32) -> Access<u32> {
        Ok(match offset {
            0 => 0x1000_6421,
            4 => self.control,
            8 | 12 => self.freezes[offset as usize / 4 - 2],
            _ => return Err("is not modelled".into()),
        })
    }

    /// Writes the register at `w.offset`.
    pub fn write(&mut self, w: Write) -> Access {
        match w.offset {
            4 => self.control = w.over(self.control, 0xe7)?,
            8 => self.freezes[0] = w.over(self.freezes[0], 0x06e0_1dff)?,
            12 => self.freezes[1] = w.over(self.freezes[1], 0x0007_0003)?,
            _ => return Err("is not modelled".into()),
        }
        Ok(())
    }
}
