//! What a run costs: cycles of the control task between two bounds, waits of interrupts, how long they are masked.
//!
//! | cycles | what a fetch from the flash costs beyond the static table |
//! |---|---|
//! | table | nothing: all hits, no wait states |
//! | accelerator | a model of it (RM0390, 3.5.2): 64 lines of instructions, 8 of data, the next line read ahead |
//! | all misses | 5 wait states for each new line of 16 bytes, and for each load; the buses' waits besides |
//!
//! The time of the run goes on by the table, whatever the others say.

use crate::cache::{Cache, LINE};
use crate::core::nvic::FIRST;
use crate::machine::Machine;
use crate::parts::interrupt;

/// Wait states at 180 MHz (RM0390, table 5).
const WAIT_STATES: u64 = 5;
/// The control task: the end of a half of the samples.
pub const CONTROL: usize = FIRST + interrupt::DMA2[0];
/// The emergency-stop chain's interrupt, EXTI9_5.
const CHAIN: usize = FIRST + 23;

/// The interrupts that the program uses, by their names in its table of tasks.
pub const USED: [(usize, &str); 5] = [
    (CHAIN, "emergency (EXTI9_5)"),
    (FIRST + interrupt::PVD, "supply (PVD)"),
    (FIRST + interrupt::TIM7, "watch_blocks (TIM7)"),
    (CONTROL, "control (DMA2_STREAM0)"),
    (FIRST + interrupt::TIM6, "link (TIM6_DAC)"),
];

/// What decides what the next fetches and loads cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Standing {
    line: u32,
    since: u64,
    instructions: [u16; 64],
    data: [u16; 8],
}

/// Cycles by the table, by the model of the accelerator, and with nothing but misses.
pub type Bounds = [u64; 3];

/// A longest time, and the instruction at which it began.
pub type Longest = (u64, u32);

/// What was seen so far.
#[derive(Clone, Debug)]
pub struct Profile {
    line: u32,
    line_since: u64,
    instructions: Cache<64>,
    data: Cache<8>,
    /// Cycles beyond the table: by the accelerator's model, and with nothing but misses.
    pub(crate) extra: [u64; 2],
    began: Option<Bounds>,
    pended: [Option<Bounds>; USED.len()],
    masked: [Option<Longest>; 16],
    /// Cycles of the control task, from its first instruction to its return: longest.
    pub longest: Bounds,
    /// Cycles of the control task over all its runs.
    pub sum: Bounds,
    /// How often the control task has run: once per block.
    pub blocks: u64,
    /// From the control task's interrupt to its end: longest.
    pub response: Bounds,
    /// From an interrupt to its first instruction, by the table: longest.
    pub waited: [u64; USED.len()],
    /// By priority (its upper four bits): the most instructions for which it was masked.
    pub longest_mask: [Longest; 16],
}

impl Profile {
    fn new() -> Self {
        Self {
            line: u32::MAX,
            line_since: 0,
            instructions: Cache::new(),
            data: Cache::new(),
            extra: [0; 2],
            began: None,
            pended: [None; USED.len()],
            masked: [None; 16],
            longest: [0; 3],
            sum: [0; 3],
            blocks: 0,
            response: [0; 3],
            waited: [0; USED.len()],
            longest_mask: [(0, 0); 16],
        }
    }

    /// An instruction is fetched; most lie in the line of the one before.
    #[inline(always)]
    pub(crate) fn fetch(&mut self, pc: u32, len: u8, cycles: u64) {
        let last = pc.wrapping_add(u32::from(len) - 1);
        if pc >> LINE != self.line || last >> LINE != self.line {
            self.fetch_lines(pc, len, cycles);
        }
    }

    /// One new line, or two.
    #[inline(never)]
    fn fetch_lines(&mut self, pc: u32, len: u8, cycles: u64) {
        for byte in [pc, pc.wrapping_add(u32::from(len) - 1)] {
            let line = byte >> LINE;
            if line == self.line {
                continue;
            }
            let ahead = line == self.line.wrapping_add(1);
            let now = cycles + self.extra[0];
            self.extra[1] += WAIT_STATES;
            if !self.instructions.has(line) {
                if ahead {
                    // Read since the line before was begun; such a line does not go into the cache.
                    let passed = now - self.line_since;
                    self.extra[0] += (WAIT_STATES + 1).saturating_sub(passed).min(WAIT_STATES);
                } else {
                    self.extra[0] += WAIT_STATES;
                    self.instructions.put(line);
                }
            }
            self.line = line;
            self.line_since = cycles + self.extra[0];
        }
    }

    /// Data are loaded from the flash.
    pub(crate) fn load(&mut self, offset: usize) {
        let line = offset as u32 >> LINE;
        self.extra[1] += WAIT_STATES;
        if !self.data.has(line) {
            self.extra[0] += WAIT_STATES;
            self.data.put(line);
        }
    }

    /// A register is accessed: on APB1 and APB2 three cycles of the bus, one of them until its next edge; on AHB1 two.
    pub(crate) fn register(&mut self, address: u32) {
        self.extra[1] += match address {
            0..0x4001_0000 => 3 * 4,
            0x4001_0000..0x4002_0000 => 3 * 2,
            _ => 2,
        };
    }

    /// The DMA makes a transfer, and keeps the control task, if that is at work, from the bus for an access at either end.
    pub(crate) fn transfer(&mut self) {
        if self.began.is_some() {
            self.extra[1] += 2;
        }
    }

    /// How it stands when `cycles` have passed.
    pub(crate) fn standing(&self, cycles: u64) -> Standing {
        Standing {
            line: self.line,
            since: cycles + self.extra[0] - self.line_since,
            instructions: self.instructions.order(),
            data: self.data.order(),
        }
    }

    /// So many times again what has cost `each` beyond the table's `cycles`, and has left everything as it stood.
    pub(crate) fn repeat(&mut self, each: [u64; 2], cycles: u64, times: u64) {
        self.extra[0] += each[0] * times;
        self.extra[1] += each[1] * times;
        self.line_since += (cycles + each[0]) * times;
    }

    fn at(&self, cycles: u64) -> Bounds {
        [cycles, cycles + self.extra[0], cycles + self.extra[1]]
    }

    fn exception(&mut self, number: usize, begins: bool, cycles: u64) {
        let now = self.at(cycles);
        let since = |from: Bounds| [0, 1, 2].map(|i| now[i] - from[i]);
        if begins && let Some(i) = USED.iter().position(|(own, _)| *own == number) {
            let waited = self.pended[i].map_or(0, |from| cycles - from[0]);
            self.waited[i] = self.waited[i].max(waited);
            if number == CONTROL {
                self.began = Some(now);
            } else {
                self.pended[i] = None;
            }
        }
        if begins || number != CONTROL {
            return;
        }
        if let Some(from) = self.began.take() {
            let took = since(from);
            for (i, cycles) in took.into_iter().enumerate() {
                self.longest[i] = self.longest[i].max(cycles);
                self.sum[i] += cycles;
            }
            self.blocks += 1;
        }
        let own = USED.iter().position(|(own, _)| *own == CONTROL);
        if let Some(from) = own.and_then(|i| self.pended[i].take()) {
            let took = since(from);
            (0..3).for_each(|i| self.response[i] = self.response[i].max(took[i]));
        }
    }

    /// Priorities from `mask` on are masked now; `active`: what is at work, which holds off its own priority in any case.
    fn masks(&mut self, mask: i16, active: i16, instructions: u64, pc: u32) {
        for level in 0..16 {
            let priority = (level << 4) as i16;
            match self.masked[level] {
                None if mask <= priority && active > priority => {
                    self.masked[level] = Some((instructions, pc))
                }
                Some((since, at)) if mask > priority => {
                    let lasted = instructions - since;
                    if lasted > self.longest_mask[level].0 {
                        self.longest_mask[level] = (lasted, at);
                    }
                    self.masked[level] = None;
                }
                _ => {}
            }
        }
    }
}

impl Machine {
    /// From now on it is noted what the run costs.
    pub fn start_profile(&mut self) {
        self.profile = Some(Box::new(Profile::new()));
        // Its longest masks are those of times round that are executed.
        self.forget_waiting();
    }

    pub(crate) fn profile_exception(&mut self, number: usize, begins: bool) {
        let cycles = self.cycles;
        if let Some(profile) = &mut self.profile {
            profile.exception(number, begins, cycles);
        }
    }

    /// An interrupt's line may have risen.
    pub(crate) fn profile_lines(&mut self) {
        let Some(profile) = &mut self.profile else {
            return;
        };
        let now = profile.at(self.cycles);
        for (i, (number, _)) in USED.iter().enumerate() {
            if self.nvic.pending[*number] && profile.pended[i].is_none() {
                profile.pended[i] = Some(now);
            }
        }
    }

    /// A mask may have changed.
    pub(crate) fn profile_masks(&mut self) {
        let Some(profile) = &mut self.profile else {
            return;
        };
        let cpu = &self.cpu;
        let base = match cpu.basepri & self.nvic.group_mask() {
            0 => 256,
            base => i16::from(base),
        };
        let mask = match (cpu.faultmask, cpu.primask) {
            (true, _) => -1,
            (_, true) => 0,
            _ => base,
        };
        let active = self.nvic.active_priority();
        profile.masks(mask, active, self.instructions, cpu.r[15].wrapping_sub(4));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_costs_its_wait_states_once_in_the_model_and_each_time_with_nothing_but_misses() {
        let mut profile = Profile::new();
        let jumps = |profile: &mut Profile| {
            profile.fetch(0x0800_0000, 2, 10);
            profile.fetch(0x0800_0002, 2, 11);
            profile.fetch(0x0800_0100, 4, 12);
        };
        jumps(&mut profile);
        assert_eq!(profile.extra, [10, 10]);
        jumps(&mut profile);
        assert_eq!(profile.extra, [10, 20]);
    }

    #[test]
    fn the_next_line_is_read_while_this_one_is_executed() {
        let mut profile = Profile::new();
        profile.fetch(0x0800_0000, 4, 0);
        // After 4 of the 6 cycles that reading takes.
        profile.fetch(0x0800_0010, 4, 4);
        assert_eq!(profile.extra, [5 + 2, 10]);
        // Astride of two lines.
        profile.fetch(0x0800_002e, 4, 40);
        assert_eq!(profile.extra[1], 20);
    }

    #[test]
    fn data_are_kept_in_eight_lines() {
        let mut profile = Profile::new();
        let load = |profile: &mut Profile, lines: std::ops::Range<usize>| {
            lines.for_each(|line| profile.load(16 * line));
            profile.extra
        };
        assert_eq!(load(&mut profile, 0..8), [40, 40]);
        assert_eq!(load(&mut profile, 0..8), [40, 80]);
        assert_eq!(load(&mut profile, 0..9), [45, 125]);
        assert_eq!(load(&mut profile, 0..1), [50, 130], "the oldest has gone");
    }

    #[test]
    fn the_longest_mask_of_each_priority() {
        let mut profile = Profile::new();
        profile.masks(0xd0, 256, 100, 1);
        profile.masks(0, 256, 110, 2);
        profile.masks(0xd0, 256, 117, 3);
        profile.masks(256, 256, 130, 4);
        assert_eq!(profile.longest_mask[0xd], (30, 1));
        assert_eq!(profile.longest_mask[0xc], (7, 2));
        // A task that masks its own priority holds nobody up.
        profile.masks(0xd0, 0xd0, 200, 5);
        profile.masks(256, 0xd0, 300, 6);
        assert_eq!(profile.longest_mask[0xd], (30, 1));
    }
}
