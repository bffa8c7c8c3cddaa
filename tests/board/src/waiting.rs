//! A loop in which the program waits: one time round is written down, and if nothing in it can change, later times are not
//! executed (`skip`).
//!
//! The program waits at an address if a branch leads back to it twice with the same registers, outside of exceptions. The
//! next time round is written down: instructions, the words of RAM that are touched, the cycles at each instruction. It is a
//! waiting loop if it touches nothing but RAM and flash, and leaves registers and words as they were. One word may grow by
//! a constant, if the instructions show that nothing else depends on it (`Round::is_free_of`).

use std::collections::HashMap;

use crate::core::Cpu;
use crate::core::op::{Kind, Op};
use crate::machine::Machine;

/// The most instructions of a loop.
const MOST: usize = 2_000;
/// The most visits that a place is left alone after it was found not to wait.
const LONGEST_PATIENCE: u32 = 1_024;

/// An instruction as it was executed, and the cycles since the loop began.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Executed {
    pub op: Op,
    pub pc: u32,
    pub cycles: u32,
    /// In an IT block; and whether its condition held.
    conditional: bool,
    held: bool,
}

/// A word of RAM that is touched.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Word {
    pub number: u32,
    /// What it holds: before, if it is read; in the end, if it is first written.
    pub value: u32,
    pub written_first: bool,
}

/// An access: of which instruction, to which word of RAM, and whether to just that word.
#[derive(Clone, Copy, Debug)]
struct Touch {
    instruction: u32,
    word: u32,
    whole: bool,
}

/// One time round, being written down or known.
#[derive(Clone, Debug)]
pub(crate) struct Round {
    pub head: u32,
    pub cpu: Cpu,
    pub executed: Vec<Executed>,
    /// Words touched, in the order of their numbers once it is known.
    pub words: Vec<Word>,
    touched: Vec<Touch>,
    /// Loads from the flash: of which instruction, and from where.
    pub literals: Vec<(u32, u32)>,
    /// Cycles of the whole.
    pub cycles: u32,
    /// The word that grows, and by how much.
    pub grows: Option<(u32, u32)>,
    began: u64,
    failed: bool,
}

/// What is known of a place that branches lead back to.
#[derive(Clone, Debug, Default)]
struct Place {
    last: Option<Cpu>,
    round: Option<Box<Round>>,
    /// Visits to let pass, and how many the next time.
    wait: u32,
    patience: u32,
}

/// What is known of all places.
#[derive(Clone, Debug, Default)]
pub(crate) struct Waiting {
    places: HashMap<u32, Place>,
    /// The round that is being written down, if one is.
    pub open: Option<Box<Round>>,
}

impl Round {
    fn new(head: u32, cpu: Cpu, cycles: u64) -> Self {
        Self {
            head,
            cpu,
            executed: Vec::new(),
            words: Vec::new(),
            touched: Vec::new(),
            literals: Vec::new(),
            cycles: 0,
            grows: None,
            began: cycles,
            failed: false,
        }
    }

    /// Whether what follows from word number `word` is that word alone: it is loaded, a constant is added or taken off,
    /// and it is stored again; registers and flags that followed from it are overwritten unseen.
    fn is_free_of(&self, word: u32) -> bool {
        let touches = self.touched.iter().filter(|touch| touch.word == word);
        let touches: Vec<Touch> = touches.copied().collect();
        let mut tainted = 0u32;
        let mut flags = false;
        for (i, executed) in self.executed.iter().enumerate() {
            let op = executed.op;
            if flags && executed.conditional {
                return false;
            }
            if !executed.held {
                continue;
            }
            let touch = touches.iter().find(|touch| touch.instruction as usize == i);
            let has = |register: u8| tainted >> (register & 15) & 1 == 1;
            let bit = |register: u8| 1u32 << (register & 15);
            let sets = op.s == 1 || op.s == 2 && !executed.conditional;
            if let Some(touch) = touch {
                match op.kind {
                    _ if !touch.whole => return false,
                    Kind::Ldr | Kind::LoadExclusive if !has(op.rn) && op.rd < 13 => {
                        tainted |= bit(op.rd);
                    }
                    Kind::Str if !has(op.rn) && has(op.rd) => {}
                    Kind::StoreExclusive if !has(op.rn) && has(op.rd) => tainted &= !bit(op.rm),
                    _ => return false,
                }
                continue;
            }
            if tainted == 0 && !flags {
                continue;
            }
            match op.kind {
                Kind::AddI | Kind::SubI if has(op.rn) && op.rd < 13 => {
                    tainted |= bit(op.rd);
                    flags |= sets;
                }
                Kind::CmpI if !has(op.rn) => flags = false,
                Kind::BranchIf if !flags => {}
                Kind::Branch | Kind::Nop | Kind::Barrier | Kind::Vmov => {}
                // Carry and overflow stay.
                Kind::MovI => tainted &= !bit(op.rd),
                Kind::Ldr if !has(op.rn) => tainted &= !bit(op.rd),
                Kind::Str if !has(op.rn) && !has(op.rd) => {}
                // Of all others every field counts as a register that is used, and so do the flags.
                Kind::LoadMany | Kind::StoreMany => {
                    if flags || tainted & op.imm != 0 || has(op.rn) {
                        return false;
                    }
                }
                _ => {
                    let fields = [op.rd, op.rn, op.rm, op.ra, op.s];
                    if flags || fields.into_iter().any(has) {
                        return false;
                    }
                }
            }
        }
        tainted == 0 && !flags
    }

    /// Whether the words hold what they did, but for the one that grows.
    pub fn words_hold(&self, machine: &Machine) -> bool {
        let growing = self.grows.map(|(word, _)| word);
        self.words.iter().all(|word| {
            word.written_first
                || machine.word(word.number) == word.value
                || growing == Some(word.number)
        })
    }

    /// Whether any of these bytes of RAM is touched.
    pub fn touches(&self, address: u32, bytes: u32) -> bool {
        let first = address.wrapping_sub(crate::memory::RAM) / 4;
        let from = self.words.partition_point(|word| word.number < first);
        let last = first + bytes / 4;
        self.words.get(from).is_some_and(|word| word.number <= last)
    }
}

impl Machine {
    /// A word of RAM by its number.
    pub(crate) fn word(&self, number: u32) -> u32 {
        let at = 4 * number as usize;
        let bytes = &self.ram[at..at + 4];
        u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
    }

    /// A branch was taken: back, and outside of exceptions, it may close a loop that waits.
    #[inline(always)]
    pub(crate) fn came_round(&mut self, op: &Op) {
        if op.imm < self.cpu.r[15] && self.cpu.ipsr == 0 && self.skips {
            self.head = op.imm;
            self.attend();
        }
    }

    /// The next instruction is written down, if one time round is.
    pub(crate) fn write_down(&mut self) {
        let cycles = self.cycles;
        let Some(mut round) = self.waiting.open.take() else {
            return;
        };
        let pc = self.cpu.pc;
        let index = (pc.wrapping_sub(crate::memory::FLASH) >> 1) as usize;
        let op = match self.ops.get(index) {
            Some(op) if op.kind != Kind::NotDecoded => *op,
            _ => return,
        };
        let alone = matches!(
            op.kind,
            Kind::Svc | Kind::Breakpoint | Kind::WaitInterrupt | Kind::WaitEvent | Kind::SendEvent
        );
        if round.failed || alone || self.cpu.ipsr != 0 || round.executed.len() == MOST {
            self.leave_alone(round.head);
            return;
        }
        let it = self.cpu.it;
        round.executed.push(Executed {
            op,
            pc,
            cycles: (cycles - round.began) as u32,
            conditional: it != 0,
            held: it == 0 || self.cpu.holds(it >> 4),
        });
        self.waiting.open = Some(round);
    }

    /// RAM is about to be touched by the instruction in work.
    #[cold]
    pub(crate) fn touch(&mut self, at: usize, width: usize, store: bool) {
        let Some(mut round) = self.waiting.open.take() else {
            return;
        };
        let whole = width == 4 && at.is_multiple_of(4);
        for number in at / 4..=(at + width - 1) / 4 {
            let number = number as u32;
            if !round.words.iter().any(|word| word.number == number) {
                round.words.push(Word {
                    number,
                    value: self.word(number),
                    written_first: store && whole,
                });
            }
            round.touched.push(Touch {
                instruction: round.executed.len().wrapping_sub(1) as u32,
                word: number,
                whole,
            });
        }
        self.waiting.open = Some(round);
    }

    /// The flash is read as data.
    #[cold]
    pub(crate) fn touch_flash(&mut self, at: usize) {
        if let Some(round) = &mut self.waiting.open {
            let instruction = round.executed.len().wrapping_sub(1) as u32;
            round.literals.push((instruction, at as u32));
        }
    }

    /// Something else is touched: this is no loop that waits.
    pub(crate) fn touch_elsewhere(&mut self) {
        if let Some(round) = &mut self.waiting.open {
            round.failed = true;
        }
    }

    fn leave_alone(&mut self, head: u32) {
        let place = self.waiting.places.entry(head).or_default();
        place.patience = (2 * place.patience).clamp(1, LONGEST_PATIENCE);
        place.wait = place.patience;
        place.last = None;
    }

    /// All that is known is forgotten.
    pub(crate) fn forget_waiting(&mut self) {
        self.waiting = Waiting::default();
    }

    /// An exception begins: the time round that is being written down is none.
    pub(crate) fn break_round(&mut self) {
        self.waiting.open = None;
        self.settle_horizon();
    }

    /// At the head of a loop: a time round that is known and holds now, if there is one.
    pub(crate) fn known_round(&mut self) -> Option<Box<Round>> {
        let head = self.cpu.pc;
        if self.cpu.basepri != 0 || self.cpu.primask || self.cpu.faultmask {
            // How long a mask lasts is counted; a loop is not begun within one.
            return None;
        }
        match self.waiting.open.take() {
            Some(round) if round.head == head => self.close(round),
            // A loop within the one that is being written down.
            Some(round) => {
                self.waiting.open = Some(round);
                return None;
            }
            None => {}
        }
        let place = self.waiting.places.entry(head).or_default();
        if place.wait > 0 {
            place.wait -= 1;
            return None;
        }
        let round = place.round.take().filter(|round| round.cpu == self.cpu);
        let was_known = round.is_some();
        if let Some(round) = round.filter(|round| round.words_hold(self)) {
            return Some(round);
        }
        let place = self.waiting.places.entry(head).or_default();
        if was_known || place.last.as_ref() == Some(&self.cpu) {
            place.last = None;
            let round = Round::new(head, self.cpu.clone(), self.cycles);
            self.waiting.open = Some(Box::new(round));
        } else {
            place.last = Some(self.cpu.clone());
        }
        None
    }

    /// Keeps what is known for the next time.
    pub(crate) fn keep_round(&mut self, round: Box<Round>) {
        let place = self.waiting.places.entry(round.head).or_default();
        place.round = Some(round);
    }

    /// A time round is complete: keeps it if it was one of waiting.
    fn close(&mut self, mut round: Box<Round>) {
        round.words.sort_unstable_by_key(|word| word.number);
        round.cycles = (self.cycles - round.began) as u32;
        let mut grows = Vec::new();
        for word in &mut round.words {
            let now = self.word(word.number);
            if word.written_first {
                word.value = now;
            } else if now != word.value {
                grows.push((word.number, now.wrapping_sub(word.value)));
            }
        }
        let waits = !round.failed
            && round.cpu == self.cpu
            && grows.len() < 2
            && grows.iter().all(|(word, _)| round.is_free_of(*word));
        if !waits {
            self.leave_alone(round.head);
            return;
        }
        round.grows = grows.pop();
        let place = self.waiting.places.entry(round.head).or_default();
        place.patience = 0;
        place.round = Some(round);
    }
}
