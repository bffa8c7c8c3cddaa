//! TIM11 (RM0390, chapter 18), as far as it measures the HSE: it counts without prescaler to its top, and each so-manieth edge of
//! HSE_RTC at its input 1 captures the count. All else is not modelled.

use super::{Access, Write};

/// What an access needs to know: now, the timer's cycle, and the period at the input while there is one, in units of time.
#[derive(Clone, Copy, Debug)]
pub struct Input {
    /// Time of the access, in units of time.
    pub now: u64,
    /// A cycle of the timer, in units of time.
    pub cycle: u32,
    /// The period of HSE_RTC.
    pub period: Option<u64>,
}

/// TIM11 with its registers.
#[derive(Clone, Debug, Default)]
pub struct Capture {
    cr1: u32,
    ccmr1: u32,
    ccer: u32,
    or: u32,
    since: u64,
    /// Captures that were read.
    taken: u64,
}

impl Capture {
    fn measures(&self) -> bool {
        (self.cr1, self.ccmr1 & 3, self.ccer, self.or) == (1, 1, 1, 2)
    }

    /// The number of the last capture, and when it was.
    fn last(&self, input: Input) -> (u64, u64) {
        match input.period {
            Some(period) if self.measures() => {
                let period = period << (self.ccmr1 >> 2 & 3);
                let number = (input.now - self.since) / period;
                (number, number * period)
            }
            _ => (self.taken, 0),
        }
    }

    /// Reads the register at `offset`; a capture that is read counts as taken.
    pub fn read(&mut self, offset: u32, input: Input) -> Access<u32> {
        let (number, after) = self.last(input);
        Ok(match offset {
            0x00 => self.cr1,
            0x10 => u32::from(number > self.taken) << 1,
            0x18 => self.ccmr1,
            0x20 => self.ccer,
            0x34 => {
                self.taken = number;
                (after / u64::from(input.cycle)) as u32 & 0xffff
            }
            0x50 => self.or,
            _ => return Err("is not modelled".into()),
        })
    }

    /// Writes the register at `w.offset`.
    pub fn write(&mut self, w: Write) -> Access {
        let measured = self.measures();
        match w.offset {
            0x00 => self.cr1 = w.over(self.cr1, 1)?,
            0x18 => self.ccmr1 = w.over(self.ccmr1, 0xf)?,
            0x20 => self.ccer = w.over(self.ccer, 1)?,
            0x50 => self.or = w.over(self.or, 3)?,
            _ => return Err("is not modelled".into()),
        }
        if self.measures() && !measured {
            (self.since, self.taken) = (w.now, 0);
        }
        Ok(())
    }
}
