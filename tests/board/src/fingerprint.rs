//! One number for all that a run did, to tell whether two runs were the same.

use crate::machine::{Change, Machine};

/// What was added so far (FNV-1a, by words).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fingerprint(u64);

impl Default for Fingerprint {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fingerprint {
    /// Mixes a word into the number.
    pub fn add(&mut self, word: u64) {
        self.0 = (self.0 ^ word).wrapping_mul(0x0100_0000_01b3);
        self.0 ^= self.0 >> 29;
    }

    /// Mixes bytes into the number, one by one.
    pub fn add_bytes(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.add(u64::from(*byte)));
    }

    /// Adds a change at the edge, and when it was.
    pub fn add_change(&mut self, at: u64, change: &Change) {
        self.add(at);
        let level = |level: Option<bool>| level.map_or(2, u64::from);
        let (kind, value) = match change {
            Change::Enable(on) => (0, level(*on)),
            Change::Dac(code) => (1, code.map_or(u64::MAX, u64::from)),
            Change::Led(on) => (2, level(*on)),
            Change::Duty(duty) => (3, duty.map_or(u64::MAX, f64::to_bits)),
            Change::Reset(flags) => (4, u64::from(*flags)),
            Change::Halt(why) => (5, why.len() as u64),
            Change::LockUp => (6, 0),
        };
        self.add(kind);
        self.add(value);
    }

    /// Adds time, counts, registers and RAM.
    pub fn add_machine(&mut self, machine: &Machine) {
        let cpu = &machine.cpu;
        let counts = [machine.now, machine.cycles, machine.instructions];
        counts.into_iter().for_each(|word| self.add(word));
        let registers = cpu.r.iter().chain(&cpu.s);
        let others = [cpu.pc, cpu.xpsr(), cpu.other_sp, cpu.control, cpu.fpscr];
        for register in registers.chain(&others) {
            self.add(u64::from(*register));
        }
        self.add(u64::from(cpu.basepri));
        machine.entered.iter().for_each(|count| self.add(*count));
        self.add_bytes(&machine.ram[..]);
        self.add_bytes(&machine.known[..]);
    }

    /// The number that all that was added has come to.
    pub fn number(self) -> u64 {
        self.0
    }
}
