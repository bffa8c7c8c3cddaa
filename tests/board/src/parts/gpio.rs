//! A port (RM0390, chapter 7): modes, pulls, output, set and reset, alternate functions. Not modelled: the lock, and
//! what speed and open drain do to an edge.

use super::{Access, Write};

/// What is outside a pin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outside {
    /// Nothing: the pin follows its pull; without one it floats, and reads anything.
    #[default]
    Open,
    /// A resistor to ground that gives way to the pin's pull-up.
    Weak,
    /// Held low, whatever the pin's pull.
    Low,
    /// Held high, whatever the pin's pull.
    High,
}

/// A port of sixteen pins, with its registers.
#[derive(Clone, Debug)]
pub struct Gpio {
    mode: u32,
    kind: u32,
    speed: u32,
    pull: u32,
    output: u32,
    alternate: [u32; 2],
    /// From what floating pins read.
    noise: u32,
    /// What is outside of each pin.
    pub outside: [Outside; 16],
}

impl Gpio {
    /// Port A (0) to H (7) after a reset.
    pub fn new(port: usize, outside: [Outside; 16]) -> Self {
        let [mode, speed, pull] = match port {
            0 => [0xa800_0000, 0x0c00_0000, 0x6400_0000],
            1 => [0x0000_0280, 0x0000_00c0, 0x0000_0100],
            _ => [0; 3],
        };
        Self {
            mode,
            kind: 0,
            speed,
            pull,
            output: 0,
            alternate: [0; 2],
            noise: 0x9e37_79b9u32.rotate_left(port as u32),
            outside,
        }
    }

    /// Mode of a pin: 0 input, 1 output, 2 alternate function, 3 analogue.
    pub fn mode(&self, pin: usize) -> u32 {
        self.mode >> (2 * pin) & 3
    }

    /// Alternate function of a pin.
    pub fn function(&self, pin: usize) -> u32 {
        self.alternate[pin / 8] >> (4 * (pin % 8)) & 15
    }

    /// What the pin drives; `None` if it does not.
    pub fn driven(&self, pin: usize) -> Option<bool> {
        let high = self.output >> pin & 1 == 1;
        (self.mode(pin) == 1 && !(high && self.kind >> pin & 1 == 1)).then_some(high)
    }

    /// Whether the pin reads high.
    pub fn level(&self, pin: usize) -> bool {
        if let Some(driven) = self.driven(pin) {
            return driven;
        }
        // An analogue pin reads 0.
        if self.mode(pin) == 3 {
            return false;
        }
        let pull = self.pull >> (2 * pin) & 3;
        match self.outside[pin] {
            Outside::Low => false,
            Outside::High => true,
            Outside::Open if pull == 0 => self.floating(pin),
            Outside::Open | Outside::Weak => pull == 1,
        }
    }

    fn levels(&self) -> u32 {
        (0..16)
            .filter(|pin| self.level(*pin))
            .fold(0, |all, pin| all | 1 << pin)
    }

    /// A floating pin is high at one look in 16, by chance: low is the worse level of a contact that closes to ground, and no
    /// level is steady.
    fn floating(&self, pin: usize) -> bool {
        self.noise.rotate_left(2 * pin as u32) >> 28 == 0
    }

    fn stir(&mut self) {
        self.noise = self
            .noise
            .wrapping_mul(1_664_525)
            .wrapping_add(1_013_904_223);
    }

    /// Reads the register at `offset`.
    pub fn read(&mut self, offset: u32) -> Access<u32> {
        self.stir();
        Ok(match offset {
            0x00 => self.mode,
            0x04 => self.kind,
            0x08 => self.speed,
            0x0c => self.pull,
            0x10 => self.levels(),
            0x14 => self.output,
            0x18 => 0,
            0x20 | 0x24 => self.alternate[offset as usize / 4 - 8],
            _ => return Err("is not modelled".into()),
        })
    }

    /// Writes the register at `w.offset`.
    pub fn write(&mut self, w: Write) -> Access {
        self.stir();
        match w.offset {
            0x00 => self.mode = w.over(self.mode, u32::MAX)?,
            0x04 => self.kind = w.over(self.kind, 0xffff)?,
            0x08 => self.speed = w.over(self.speed, u32::MAX)?,
            0x0c => {
                self.pull = w.over(self.pull, u32::MAX)?;
                if self.pull & self.pull >> 1 & 0x5555_5555 != 0 {
                    return Err("both pulls of a pin: reserved".into());
                }
            }
            0x14 => self.output = w.over(self.output, 0xffff)?,
            // Setting wins over resetting (7.4.7).
            0x18 => self.output = self.output & !(w.ones() >> 16) | w.ones() & 0xffff,
            0x20 | 0x24 => {
                let slot = &mut self.alternate[w.offset as usize / 4 - 8];
                *slot = w.over(*slot, u32::MAX)?;
            }
            0x10 => return Err("is read-only".into()),
            _ => return Err("is not modelled".into()),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(gpio: &mut Gpio, offset: u32, value: u32) -> Access {
        gpio.write(Write {
            offset,
            value,
            mask: !0,
            now: 0,
        })
    }

    #[test]
    fn a_pin_drives_or_follows_its_pull() {
        let mut gpio = Gpio::new(2, [Outside::Open; 16]);
        write(&mut gpio, 0x0c, 1 << 10).unwrap();
        assert!(gpio.level(5) && gpio.driven(5).is_none());
        write(&mut gpio, 0x0c, 3 << 10).unwrap_err();
        // Without a pull it reads now this, now that.
        write(&mut gpio, 0x0c, 0).unwrap();
        let read: Vec<u32> = (0..256)
            .map(|_| gpio.read(0x10).unwrap() >> 5 & 1)
            .collect();
        assert!(read.contains(&0) && read.contains(&1));
        gpio.outside[5] = Outside::Low;
        assert!(!gpio.level(5));
        write(&mut gpio, 0, 1 << 16).unwrap();
        write(&mut gpio, 0x18, 1 << 8).unwrap();
        assert_eq!(gpio.driven(8), Some(true));
        write(&mut gpio, 0x18, 1 << 24 | 1 << 3).unwrap();
        assert_eq!((gpio.driven(8), gpio.read(0x14).unwrap()), (Some(false), 8));
        write(&mut gpio, 0x14, 1 << 16).unwrap_err();
    }
}
