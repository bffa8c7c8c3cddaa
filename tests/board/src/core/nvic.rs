//! Which exception comes next: pending, enabled, active, priorities (ARMv7-M Architecture Reference Manual, B1.5 and
//! B3.4). Lines are levels: one that is still high when its exception ends is pending again.

/// Interrupts of the STM32F446 (RM0390, table 38): 0 to 96.
pub const INTERRUPTS: usize = 97;
/// Number of the first interrupt among the exceptions.
pub const FIRST: usize = 16;
/// Bits of a priority that exist: the upper four.
pub const PRIORITY_BITS: u8 = 0xf0;

/// The interrupt controller, with the priorities of the processor's own exceptions.
#[derive(Clone, Debug)]
pub struct Nvic {
    /// Which exceptions are pending, by number.
    pub pending: [bool; FIRST + INTERRUPTS],
    /// Enabled; those of the processor always are, but 4 to 6.
    pub enabled: [bool; FIRST + INTERRUPTS],
    /// In work, the last one innermost.
    pub active: Vec<u16>,
    /// Priorities by number of the exception, as written.
    pub priority: [u8; FIRST + INTERRUPTS],
    /// Where priorities are split into group and subpriority.
    pub grouping: u8,
    lines: [bool; INTERRUPTS],
    /// Something may have become due.
    pub changed: bool,
}

impl Default for Nvic {
    fn default() -> Self {
        let mut enabled = [false; FIRST + INTERRUPTS];
        enabled[..FIRST].fill(true);
        enabled[4..7].fill(false);
        Self {
            pending: [false; FIRST + INTERRUPTS],
            enabled,
            active: Vec::new(),
            priority: [0; FIRST + INTERRUPTS],
            grouping: 0,
            lines: [false; INTERRUPTS],
            changed: false,
        }
    }
}

impl Nvic {
    /// A peripheral's interrupt line goes high or low.
    pub fn set_line(&mut self, interrupt: usize, high: bool) {
        let line = &mut self.lines[interrupt];
        if high && !*line {
            self.pending[FIRST + interrupt] = true;
            self.changed = true;
        }
        *line = high;
    }

    /// An exception becomes pending.
    pub fn pend(&mut self, number: usize) {
        self.pending[number] = true;
        self.changed = true;
    }

    /// The priority of an exception as such: smaller is more urgent.
    pub fn priority_of(&self, number: usize) -> i16 {
        match number {
            1 => -3,
            2 => -2,
            3 => -1,
            _ => i16::from(self.priority[number]),
        }
    }

    /// Its group's priority, which alone decides about pre-emption.
    pub fn group_of(&self, number: usize) -> i16 {
        let priority = self.priority_of(number);
        if priority < 0 {
            priority
        } else {
            priority & i16::from(self.group_mask())
        }
    }

    /// The bits of a priority that are the group's.
    pub fn group_mask(&self) -> u8 {
        (0xffu16 << (self.grouping + 1)) as u8
    }

    /// The most urgent group among what is in work; 256 if nothing is.
    pub fn active_priority(&self) -> i16 {
        let groups = self
            .active
            .iter()
            .map(|number| self.group_of(usize::from(*number)));
        groups.min().unwrap_or(256)
    }

    /// The most urgent exception that is pending and enabled.
    pub fn most_urgent(&self) -> Option<usize> {
        let due = (1..self.pending.len()).filter(|n| self.pending[*n] && self.enabled[*n]);
        due.min_by_key(|n| (self.priority_of(*n), *n))
    }

    /// An exception begins: it is no longer pending, but in work.
    pub fn begin(&mut self, number: usize) {
        self.pending[number] = false;
        self.active.push(number as u16);
    }

    /// It ends; false if it was not in work.
    pub fn end(&mut self, number: usize) -> bool {
        let Some(at) = self.active.iter().rposition(|n| usize::from(*n) == number) else {
            return false;
        };
        self.active.remove(at);
        if number >= FIRST && self.lines[number - FIRST] {
            self.pending[number] = true;
        }
        self.changed = true;
        true
    }

    /// A register of the controller, offset from 0xE000E100; `None` where there is none.
    pub fn read(&self, offset: u32) -> Option<u32> {
        let word = (offset & 0x7f) as usize / 4;
        let bits = |all: &[bool]| {
            let of = all[FIRST..].iter().skip(word * 32).take(32);
            of.enumerate()
                .fold(0, |value, (i, on)| value | u32::from(*on) << i)
        };
        match offset {
            0..=0x0f | 0x80..=0x8f => Some(bits(&self.enabled)),
            0x100..=0x10f | 0x180..=0x18f => Some(bits(&self.pending)),
            0x200..=0x20f => {
                let active = |i: u32| {
                    self.active
                        .contains(&((FIRST + word * 32) as u16 + i as u16))
                };
                Some((0..32).fold(0, |value, i| value | u32::from(active(i)) << i))
            }
            0x300..=0x363 => {
                let first = (offset & !3) as usize - 0x300;
                let byte =
                    |i: usize| u32::from(*self.priority.get(FIRST + first + i).unwrap_or(&0));
                Some((0..4).fold(0, |value, i| value | byte(i) << (8 * i)))
            }
            _ => None,
        }
    }

    /// Writes the bits of `mask` of such a register; an error names what is wrong.
    pub fn write(&mut self, offset: u32, value: u32, mask: u32) -> Result<(), String> {
        let first = (offset & 0x7f) as usize / 4 * 32;
        if matches!(offset, 0x300..=0x363) {
            for i in (0..4).filter(|i| mask >> (8 * i) & 0xff != 0) {
                let number = (offset & !3) as usize - 0x300 + i as usize;
                if let Some(priority) = self.priority.get_mut(FIRST + number) {
                    *priority = (value >> (8 * i)) as u8 & PRIORITY_BITS;
                }
            }
            self.changed = true;
            return Ok(());
        }
        for i in (0..32).filter(|i| value & mask & (1 << i) != 0) {
            let number = FIRST + first + i;
            if number >= self.pending.len() {
                return Err(format!("interrupt {} does not exist", first + i));
            }
            match offset {
                0..=0x0f => self.enabled[number] = true,
                0x80..=0x8f => self.enabled[number] = false,
                0x100..=0x10f => self.pending[number] = true,
                0x180..=0x18f => self.pending[number] = self.lines[number - FIRST],
                _ => return Err("no such register of the interrupt controller".into()),
            }
        }
        self.changed = true;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_urgent_is_the_lowest_priority_then_the_lowest_number() {
        let mut nvic = Nvic::default();
        nvic.write(0, 0b1011, !0).unwrap();
        nvic.write(0x300, 0x2010_1020, !0).unwrap();
        for n in [0, 1, 3] {
            nvic.set_line(n, true);
        }
        assert_eq!(nvic.most_urgent(), Some(FIRST + 1));
        nvic.begin(FIRST + 1);
        assert_eq!(nvic.active_priority(), 0x10);
        assert_eq!(nvic.most_urgent(), Some(FIRST));
        // The line is still high: pending again.
        assert!(nvic.end(FIRST + 1));
        assert_eq!(nvic.most_urgent(), Some(FIRST + 1));
        nvic.set_line(1, false);
        nvic.begin(FIRST + 1);
        nvic.end(FIRST + 1);
        assert_eq!(nvic.most_urgent(), Some(FIRST));
    }

    #[test]
    fn only_four_bits_of_a_priority_exist() {
        let mut nvic = Nvic::default();
        nvic.write(0x304, 0xff, 0xff).unwrap();
        assert_eq!(nvic.read(0x304), Some(0xf0));
        assert!(nvic.write(0x0c, 1 << 5, !0).is_err());
    }
}
