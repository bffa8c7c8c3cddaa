//! Lines of the flash that its accelerator holds: the one used longest ago goes first.

use crate::parts::flash::SIZE;

/// Bytes of a line, as a power of two.
pub(crate) const LINE: u32 = 4;
/// Lines of the flash.
const LINES: usize = SIZE >> LINE;

/// Lines that are held, in a chain from the most recently used one to the one used longest ago.
#[derive(Clone, Debug)]
pub(crate) struct Cache<const SLOTS: usize> {
    /// The slot of each line of the flash, and 1; 0: not held.
    slots: Box<[u8; LINES]>,
    lines: [u16; SLOTS],
    /// The slots used before and after each in time.
    older: [u8; SLOTS],
    newer: [u8; SLOTS],
    newest: u8,
    oldest: u8,
    used: u8,
}

impl<const SLOTS: usize> Cache<SLOTS> {
    pub fn new() -> Self {
        Self {
            slots: Box::new([0; LINES]),
            lines: [0; SLOTS],
            older: [0; SLOTS],
            newer: [0; SLOTS],
            newest: 0,
            oldest: 0,
            used: 0,
        }
    }

    /// Whether a line is held; it is the most recently used one then.
    pub fn has(&mut self, line: u32) -> bool {
        let Some(slot) = self.slots[line as usize % LINES].checked_sub(1) else {
            return false;
        };
        if slot != self.newest {
            let (older, newer) = (self.older[usize::from(slot)], self.newer[usize::from(slot)]);
            self.older[usize::from(newer)] = older;
            if slot == self.oldest {
                self.oldest = newer;
            } else {
                self.newer[usize::from(older)] = newer;
            }
            self.put_first(slot);
        }
        true
    }

    fn put_first(&mut self, slot: u8) {
        self.older[usize::from(slot)] = self.newest;
        self.newer[usize::from(self.newest)] = slot;
        self.newest = slot;
    }

    /// Holds a line in place of the one used longest ago.
    pub fn put(&mut self, line: u32) {
        let slot = self.oldest;
        let slot = if usize::from(self.used) < SLOTS {
            self.used += 1;
            self.used - 1
        } else {
            self.slots[usize::from(self.lines[usize::from(slot)])] = 0;
            self.oldest = self.newer[usize::from(slot)];
            slot
        };
        let line = line as usize % LINES;
        self.lines[usize::from(slot)] = line as u16;
        self.slots[line] = slot + 1;
        if self.used == 1 {
            self.newest = slot;
        } else {
            self.put_first(slot);
        }
    }

    /// The lines, the most recently used one first.
    pub fn order(&self) -> [u16; SLOTS] {
        let mut slot = self.newest;
        let mut order = [u16::MAX; SLOTS];
        for place in order.iter_mut().take(usize::from(self.used)) {
            *place = self.lines[usize::from(slot)];
            slot = self.older[usize::from(slot)];
        }
        order
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A [`Cache`] as plain as can be: the most recently used line first.
    #[derive(Default)]
    struct Plain(Vec<u16>);

    impl Plain {
        fn has(&mut self, line: u16) -> bool {
            let Some(at) = self.0.iter().position(|own| *own == line) else {
                return false;
            };
            self.0.remove(at);
            self.0.insert(0, line);
            true
        }

        fn put(&mut self, line: u16) {
            self.0.insert(0, line);
            self.0.truncate(8);
        }
    }

    #[test]
    fn the_chain_holds_what_a_plain_list_holds() {
        let (mut chain, mut plain) = (Cache::<8>::new(), Plain::default());
        let mut state = 1u32;
        for _ in 0..20_000 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let line = (state >> 24) as u16 % 12;
            let held = chain.has(u32::from(line));
            assert_eq!(held, plain.has(line));
            // Not every line that is missed is put in.
            if !held && state >> 20 & 3 != 0 {
                chain.put(u32::from(line));
                plain.put(line);
            }
            let order = chain.order();
            assert_eq!(order[..plain.0.len()], plain.0);
        }
    }
}
