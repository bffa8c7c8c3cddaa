//! The independent watchdog (RM0390, chapter 21), on the 32 kHz LSI.

use super::{Access, NEVER, UNITS_PER_S, Write};

/// The block.
#[derive(Clone, Debug)]
pub struct Watchdog {
    prescaler: u32,
    reload: u32,
    unlocked: bool,
    /// When it was last started or fed.
    fed_at: Option<u64>,
    /// Until when prescaler and reload are on their way.
    updating_until: [u64; 2],
    /// The LSI's frequency, Hz: 17 to 47 kHz on a real part.
    pub lsi_hz: u64,
}

impl Watchdog {
    /// After a reset.
    pub fn new(lsi_hz: u64) -> Self {
        Self {
            prescaler: 0,
            reload: 0xfff,
            unlocked: false,
            fed_at: None,
            updating_until: [0; 2],
            lsi_hz,
        }
    }

    /// When it resets the board.
    pub fn next(&self) -> u64 {
        let Some(fed_at) = self.fed_at else {
            return NEVER;
        };
        let divider = 4u64 << self.prescaler.min(6);
        fed_at + divider * u64::from(self.reload) * UNITS_PER_S / self.lsi_hz
    }

    /// Moves its end by a time that it stood still.
    pub fn freeze(&mut self, by: u64) {
        self.fed_at = self.fed_at.map(|at| at + by);
    }

    /// Reads.
    pub fn read(&self, offset: u32, now: u64) -> Access<u32> {
        Ok(match offset {
            0x00 => 0,
            0x04 => self.prescaler,
            0x08 => self.reload,
            0x0c => {
                u32::from(now < self.updating_until[0])
                    | u32::from(now < self.updating_until[1]) << 1
            }
            _ => return Err("is not modelled".into()),
        })
    }

    /// Writes.
    pub fn write(&mut self, w: Write) -> Access {
        let lsi_cycle = UNITS_PER_S / self.lsi_hz;
        match w.offset {
            0x00 => match w.ones() {
                0x5555 => self.unlocked = true,
                0xaaaa => {
                    self.unlocked = false;
                    self.fed_at = self.fed_at.map(|_| w.now);
                }
                0xcccc => {
                    self.unlocked = false;
                    self.fed_at = self.fed_at.or(Some(w.now));
                }
                other => return Err(format!("key {other:#x} is none")),
            },
            0x04 | 0x08 => {
                if !self.unlocked {
                    return Err("is written without the key 0x5555".into());
                }
                let until = &mut self.updating_until[w.offset as usize / 4 - 1];
                if w.now < *until {
                    return Err("is written while PVU or RVU is set (21.4.4)".into());
                }
                // Five cycles of the LSI, divided by 4 to 256, until the value has arrived: here the shortest.
                *until = w.now + 5 * lsi_cycle;
                if w.offset == 4 {
                    self.prescaler = w.over(self.prescaler, 7)?;
                } else {
                    self.reload = w.over(self.reload, 0xfff)?;
                }
            }
            _ => return Err("is not modelled".into()),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_seconds_from_the_last_feeding() {
        let mut dog = Watchdog::new(32_000);
        let mut write = |offset, value, now| {
            dog.write(Write {
                offset,
                value,
                mask: !0,
                now,
            })
        };
        write(8, 5, 0).unwrap_err();
        write(0, 0x5555, 0).unwrap();
        write(4, 4, 0).unwrap();
        write(8, 1000, 10).unwrap();
        write(8, 1000, 20).unwrap_err();
        write(0, 0xcccc, UNITS_PER_S).unwrap();
        write(0, 0xaaaa, 2 * UNITS_PER_S).unwrap();
        assert_eq!(dog.next(), 4 * UNITS_PER_S);
    }
}
