//! The converter to analogue (RM0390, chapter 14): both channels, without trigger, wave or DMA of its own.

use super::{Access, NEVER, Write};

/// The converter to analogue, with its registers and outputs.
#[derive(Clone, Debug, Default)]
pub struct Dac {
    /// Whether its clock is on: without it no code moves to the output.
    pub clocked: bool,
    control: u32,
    holding: [u32; 2],
    output: [u32; 2],
    moves_at: Option<u64>,
}

impl Dac {
    /// The code at the output of channel 0 or 1; `None` while it is off.
    pub fn code(&self, channel: usize) -> Option<u16> {
        (self.control >> (16 * channel) & 1 == 1).then_some(self.output[channel] as u16)
    }

    /// Whether a channel's output has its buffer.
    pub fn is_buffered(&self, channel: usize) -> bool {
        self.control >> (16 * channel + 1) & 1 == 0
    }

    /// The code that is about to be, or is, at channel 0's output; `None` while it is off.
    pub fn coming_code(&self) -> Option<u16> {
        let code = if self.clocked {
            self.holding[0]
        } else {
            self.output[0]
        };
        (self.control & 1 == 1).then_some(code as u16)
    }

    /// When a code written moves on to the output: a cycle of APB1 later.
    pub fn next(&self) -> u64 {
        self.moves_at.filter(|_| self.clocked).unwrap_or(NEVER)
    }

    /// Moves the codes that were written on to the outputs.
    pub fn run(&mut self) {
        self.output = self.holding;
        self.moves_at = None;
    }

    /// Reads the register at `offset`.
    pub fn read(&self, offset: u32) -> Access<u32> {
        Ok(match offset {
            0x00 => self.control,
            0x08 => self.holding[0],
            0x14 => self.holding[1],
            0x2c => self.output[0],
            0x30 => self.output[1],
            0x34 => 0,
            _ => return Err("is not modelled".into()),
        })
    }

    /// Writes; `cycle` is APB1's.
    pub fn write(&mut self, w: Write, cycle: u32) -> Access {
        match w.offset {
            0x00 => {
                let new = w.over(self.control, 0x3fff_3fff)?;
                if new & 0x3ffc_3ffc != 0 {
                    return Err("trigger, wave and DMA of the DAC are not modelled".into());
                }
                self.control = new;
            }
            0x08 => self.holding[0] = w.over(self.holding[0], 0xfff)?,
            0x14 => self.holding[1] = w.over(self.holding[1], 0xfff)?,
            _ => return Err("is not modelled".into()),
        }
        self.moves_at = Some(w.now + u64::from(cycle));
        Ok(())
    }
}
