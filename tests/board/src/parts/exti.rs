//! External interrupts and what routes pins to them: EXTI and SYSCFG (RM0390, chapters 10 and 8). Not modelled: events
//! (they wake from WFE only), compensation cell, memory remapping.

use super::{Access, Write};

const LINES: u32 = 0x007f_ffff;

/// EXTI and SYSCFG with their registers.
#[derive(Clone, Debug, Default)]
pub struct Exti {
    masks: u32,
    rising: u32,
    falling: u32,
    /// Lines that have been seen.
    pub pending: u32,
    /// Port of each of lines 0 to 15.
    ports: [u32; 4],
    levels: u32,
}

impl Exti {
    /// The port whose pin is line `line`.
    pub fn port(&self, line: usize) -> usize {
        (self.ports[line / 4] >> (4 * (line % 4)) & 15) as usize
    }

    /// A line has this level now.
    pub fn level(&mut self, line: usize, high: bool) {
        let bit = 1 << line;
        let was = self.levels & bit != 0;
        self.levels = self.levels & !bit | u32::from(high) << line;
        let edge = if high { self.rising } else { self.falling };
        if was != high && edge & bit != 0 {
            self.pending |= bit;
        }
    }

    /// The interrupts that are high: line's number, and whether.
    pub fn interrupts(&self) -> impl Iterator<Item = (usize, bool)> {
        let due = self.pending & self.masks;
        let singles = (0..5).map(move |line| (6 + line, due >> line & 1 == 1));
        singles.chain([
            (23, due & 0x3e0 != 0),
            (40, due & 0xfc00 != 0),
            (1, due & 1 << 16 != 0),
        ])
    }

    /// Reads the register of EXTI at `offset`.
    pub fn read(&self, offset: u32) -> Access<u32> {
        Ok(match offset {
            0x00 => self.masks,
            0x08 => self.rising,
            0x0c => self.falling,
            0x14 => self.pending,
            _ => return Err("is not modelled".into()),
        })
    }

    /// Writes the register of EXTI at `w.offset`.
    pub fn write(&mut self, w: Write) -> Access {
        match w.offset {
            0x00 => self.masks = w.over(self.masks, LINES)?,
            0x08 => self.rising = w.over(self.rising, LINES)?,
            0x0c => self.falling = w.over(self.falling, LINES)?,
            0x10 => self.pending |= w.over(0, LINES)? & self.masks,
            0x14 => self.pending &= !w.over(0, LINES)?,
            _ => return Err("is not modelled".into()),
        }
        Ok(())
    }

    /// Reads the register of SYSCFG at `offset`.
    pub fn read_syscfg(&self, offset: u32) -> Access<u32> {
        match offset {
            0x08..=0x14 => Ok(self.ports[offset as usize / 4 - 2]),
            _ => Err("is not modelled".into()),
        }
    }

    /// Writes the register of SYSCFG at `w.offset`.
    pub fn write_syscfg(&mut self, w: Write) -> Access {
        match w.offset {
            0x08..=0x14 => {
                let slot = &mut self.ports[w.offset as usize / 4 - 2];
                *slot = w.over(*slot, 0xffff)?;
                Ok(())
            }
            _ => Err("is not modelled".into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_chosen_edge_is_seen() {
        let mut exti = Exti {
            masks: 1 << 5,
            rising: 1 << 5,
            ..Exti::default()
        };
        let on = |exti: &Exti| exti.interrupts().any(|(n, high)| n == 23 && high);
        exti.level(5, true);
        assert!(on(&exti));
        exti.write(Write {
            offset: 0x14,
            value: 1 << 5,
            mask: !0,
            now: 0,
        })
        .unwrap();
        exti.level(5, false);
        assert!(!on(&exti));
    }
}
