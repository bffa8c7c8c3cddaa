//! Time goes on: instructions, waiting, what is looked at between them.

use crate::core::op::Kind;
use crate::core::{Fault, Trap, Try, decode16, decode32};
use crate::machine::Machine;
use crate::memory::FLASH;
use crate::parts::rcc::cause;
use crate::skip::Ended;
use crate::stop::Stop;

impl Machine {
    /// Time goes on to `to`, with what happens on the way.
    fn wait_until(&mut self, to: u64) -> Try {
        while self.now < to {
            let next = self.next_event.clamp(self.now, to);
            self.cycles += (next - self.now) / u64::from(self.unit);
            self.now = next.max(self.now);
            let before = self.parts.flash.operations;
            self.happen()?;
            if self.next_event <= self.now || before != self.parts.flash.operations {
                break;
            }
            if self.pause {
                break;
            }
        }
        Ok(())
    }

    /// Stands until the flash is free.
    pub(crate) fn wait_for_flash(&mut self) -> Try {
        while let Some((_, until)) = self.parts.flash.work {
            self.wait_until(until)?;
        }
        Ok(())
    }

    /// Nothing is executed until something happens, or until `end`; gives the time that passes.
    fn idle_until(&mut self, end: u64) -> u64 {
        let by = self.next_event.min(end).saturating_sub(self.now);
        self.cycles += by / u64::from(self.unit);
        self.now += by;
        by
    }

    /// What is to be looked at between instructions.
    fn look(&mut self, end: u64) -> Try {
        self.attention = false;
        if self.reset_asked {
            self.reset(cause::SOFTWARE | cause::PIN);
        }
        if self.late_fault {
            self.late_fault = false;
            self.raise(Fault::BusLate)?;
        }
        if self.halted {
            self.attend();
            let by = self.idle_until(end);
            if self.parts.dbgmcu.freezes_watchdog() {
                self.parts.watchdog.freeze(by);
            }
            if self.parts.dbgmcu.freezes_tim2() {
                self.parts.tim[0].freeze(by);
            }
            self.reschedule();
            return Ok(());
        }
        if self.cpu.sleeping {
            if self.wakes() {
                self.cpu.sleeping = false;
            } else {
                self.attend();
                self.idle_until(end);
                return Ok(());
            }
        }
        if self.nvic.changed {
            self.nvic.changed = false;
            if let Some(number) = self.due() {
                self.enter_exception(number)?;
                // The stack and the vector came by the bus; something may be due at once.
                self.nvic.changed = true;
                self.attend();
            }
        }
        Ok(())
    }

    /// Runs until `end`, or until a sampling tick begins.
    ///
    /// # Errors
    /// A rule of the machine is broken.
    pub fn run_until(&mut self, end: u64) -> Result<(), Stop> {
        self.pause = false;
        self.until = end;
        while self.now < end && !self.pause {
            if let Err(trap) = self.turn(end) {
                return Err(match trap {
                    Trap::Stop(why) => self.stop(*why),
                    Trap::Fault(fault) => {
                        self.stop(format!("a fault that was not handled: {fault:?}"))
                    }
                });
            }
        }
        Ok(())
    }

    /// What is due, and instructions until something else is.
    fn turn(&mut self, end: u64) -> Try {
        if self.now >= self.next_event {
            self.happen()?;
        }
        if let Some((_, until)) = &self.parts.flash.work
            && !self.reset_asked
            && !self.halted
        {
            // The next fetch waits; the world goes on meanwhile.
            let until = *until;
            return self.wait_until(until.min(end));
        }
        if self.attention {
            self.look(end)?;
            if self.halted || self.cpu.sleeping {
                return Ok(());
            }
        }
        if self.head == self.cpu.pc && !self.pause {
            self.head = u32::MAX;
            if self.at_head()? == Ended::Here {
                return Ok(());
            }
            if self.attention {
                self.look(end)?;
                if self.halted || self.cpu.sleeping {
                    return Ok(());
                }
            }
        }
        self.settle_horizon();
        if self.waiting.open.is_some() {
            self.write_down();
            self.watching = self.waiting.open.is_some();
        }
        loop {
            let pc = self.cpu.pc;
            if let Err(trap) = self.step() {
                self.watching = false;
                self.trapped(trap, pc)?;
            }
            if self.now >= self.horizon || self.pause {
                self.watching = false;
                return Ok(());
            }
        }
    }

    /// An instruction has failed: a fault is the program's, all else the run's end.
    #[cold]
    fn trapped(&mut self, trap: Trap, pc: u32) -> Try {
        let Trap::Fault(fault) = trap else {
            return Err(trap);
        };
        if !matches!(fault, Fault::State | Fault::Return) {
            self.cpu.pc = pc;
            self.cpu.it = self.cpu.it_now;
        }
        self.raise(fault)?;
        self.attend();
        Ok(())
    }

    /// Executes the next instruction.
    #[inline(always)]
    pub(crate) fn step(&mut self) -> Try {
        let pc = self.cpu.pc;
        let index = (pc.wrapping_sub(FLASH) >> 1) as usize;
        if index >= self.ops.len() {
            return Err(self.fetch_elsewhere(pc));
        }
        if self.ops[index].kind == Kind::NotDecoded {
            self.decode(index, pc);
        }
        let op = self.ops[index];
        self.cpu.r[15] = pc.wrapping_add(4);
        self.cpu.pc = pc.wrapping_add(u32::from(op.len));
        self.instructions += 1;
        if let Some(profile) = &mut self.profile {
            profile.fetch(pc, op.len, self.cycles);
        }
        self.spend(u32::from(op.cost));
        let it = self.cpu.it;
        self.cpu.it_now = it;
        if it != 0 {
            self.cpu.it = if it & 7 == 0 {
                0
            } else {
                it & 0xe0 | it << 1 & 0x1f
            };
            if !self.cpu.holds(it >> 4) {
                return Ok(());
            }
        }
        self.execute(&op)
    }

    fn fetch_elsewhere(&self, pc: u32) -> Trap {
        if self.is_memory(pc) {
            return Trap::stop(format!("code in RAM at {pc:#010x} is not modelled"));
        }
        match pc >> 29 {
            // Peripherals and the processor's own space: code may not be there.
            2 | 5 | 7 => Trap::Fault(Fault::Fetch),
            _ => Trap::Fault(Fault::BusFetch),
        }
    }

    pub(crate) fn half(&self, pc: u32) -> u32 {
        let at = pc.wrapping_sub(FLASH) as usize;
        self.flash
            .get(at..at + 2)
            .map_or(0, |b| u32::from(b[0]) | u32::from(b[1]) << 8)
    }

    #[cold]
    fn decode(&mut self, index: usize, pc: u32) {
        let first = self.half(pc);
        self.ops[index] = if first >> 11 >= 0b11101 {
            decode32::decode(pc, first, self.half(pc.wrapping_add(2)))
        } else {
            decode16::decode(pc, first)
        };
    }
}
