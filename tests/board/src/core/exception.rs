//! Exceptions: entry, return, faults (ARMv7-M Architecture Reference Manual, B1.5).
//!
//! Cycles: 12 to enter, 10 to leave, 6 from one to the next without leaving (Cortex-M4 Technical Reference Manual, 3.9).

use super::{Fault, Trap, Try};
use crate::machine::Machine;

const ENTRY_CYCLES: u32 = 12;
const EXIT_CYCLES: u32 = 10;
const TAIL_CYCLES: u32 = 6;

const HARD_FAULT: usize = 3;
const CALL: usize = 11;
const MEM_MANAGE: usize = 4;
const BUS_FAULT: usize = 5;
const USAGE_FAULT: usize = 6;

/// Bits of the fault status register.
#[rustfmt::skip]
mod status {
    pub const IACCVIOL: u32 = 1;
    pub const IBUSERR: u32 = 1 << 8;
    pub const PRECISERR: u32 = 1 << 9;
    pub const IMPRECISERR: u32 = 1 << 10;
    pub const UNSTKERR: u32 = 1 << 11;
    pub const STKERR: u32 = 1 << 12;
    pub const BFARVALID: u32 = 1 << 15;
    pub const UNDEFINSTR: u32 = 1 << 16;
    pub const INVSTATE: u32 = 1 << 17;
    pub const INVPC: u32 = 1 << 18;
    pub const NOCP: u32 = 1 << 19;
    pub const UNALIGNED: u32 = 1 << 24;
    pub const DIVBYZERO: u32 = 1 << 25;
}

impl Machine {
    /// An exception becomes pending.
    pub(crate) fn pend_exception(&mut self, number: usize) {
        self.nvic.pend(number);
        self.attend();
    }

    /// The priority at which the processor works now, masks included.
    pub(crate) fn execution_priority(&self) -> i16 {
        let mut priority = self.nvic.active_priority();
        if self.cpu.basepri != 0 {
            priority = priority.min(i16::from(self.cpu.basepri & self.nvic.group_mask()));
        }
        if self.cpu.primask {
            priority = priority.min(0);
        }
        if self.cpu.faultmask {
            priority = priority.min(-1);
        }
        priority
    }

    /// The exception that must be taken now, if any.
    pub(crate) fn due(&self) -> Option<usize> {
        let number = self.nvic.most_urgent()?;
        (self.nvic.group_of(number) < self.execution_priority()).then_some(number)
    }

    /// Whether a sleeping processor wakes: masks by PRIMASK do not count.
    pub(crate) fn wakes(&self) -> bool {
        let Some(number) = self.nvic.most_urgent() else {
            return false;
        };
        let mut limit = self.nvic.active_priority();
        if self.cpu.basepri != 0 {
            limit = limit.min(i16::from(self.cpu.basepri));
        }
        self.nvic.group_of(number) < limit
    }

    /// Enters an exception from the program in work.
    pub(crate) fn enter_exception(&mut self, number: usize) -> Try {
        self.spend(ENTRY_CYCLES);
        let process = self.cpu.on_process_stack();
        let float = self.cpu.control & 4 != 0;
        let stacked = self.push_frame(float);
        let thread = self.cpu.ipsr == 0;
        let link = match (thread, process) {
            (false, _) => 0xffff_fff1,
            (true, false) => 0xffff_fff9,
            (true, true) => 0xffff_fffd,
        };
        self.cpu.r[14] = if float { link & !0x10 } else { link };
        self.start_handler(number, process)?;
        match stacked {
            // A HardFault goes on without its frame: it locks up only at a fault of its own.
            Err(Trap::Fault(_)) if number == HARD_FAULT => {
                self.system.fault_status |= status::STKERR;
                Ok(())
            }
            Err(Trap::Fault(_)) => self.raise(Fault::BusStacking),
            other => other,
        }
    }

    fn push_frame(&mut self, float: bool) -> Try {
        let size = if float { 0x68 } else { 0x20 };
        let sp = self.cpu.r[13];
        let frame = sp.wrapping_sub(size) & !7;
        let padded = sp & 4;
        self.cpu.r[13] = frame;
        let words = [
            self.cpu.r[0],
            self.cpu.r[1],
            self.cpu.r[2],
            self.cpu.r[3],
            self.cpu.r[12],
            self.cpu.r[14],
            self.cpu.pc,
            self.cpu.xpsr() | padded << 7,
        ];
        if float {
            self.system.float_address = frame.wrapping_add(0x20);
            if self.system.lazy_enabled() {
                self.system.lazy = true;
                // Room that the floating point may be stacked into later counts as written.
                self.know(frame.wrapping_add(0x20), 0x48);
            } else {
                self.store_float()?;
            }
        }
        for (i, word) in words.into_iter().enumerate() {
            self.store_stack(frame.wrapping_add(4 * i as u32), word)?;
        }
        Ok(())
    }

    /// A store of the stacking, whose fault comes at once.
    fn store_stack(&mut self, address: u32, word: u32) -> Try {
        if !self.is_memory(address) {
            return Err(Trap::Fault(Fault::BusStacking));
        }
        self.store::<4>(address, word)
    }

    fn store_float(&mut self) -> Try {
        let address = self.system.float_address;
        for i in 0..16 {
            self.store_stack(address.wrapping_add(4 * i), self.cpu.s[i as usize])?;
        }
        self.store_stack(address.wrapping_add(0x40), self.cpu.fpscr)
    }

    /// Stacks the floating point whose room was left at entry.
    pub(crate) fn stack_lazily(&mut self) -> Try {
        self.system.lazy = false;
        self.spend(17);
        self.store_float()
    }

    /// Starts a handler; the frame is there.
    fn start_handler(&mut self, number: usize, was_process: bool) -> Try {
        self.nvic.begin(number);
        self.cpu.ipsr = number as u16;
        self.cpu.control &= !6;
        self.cpu.use_stack(was_process, false);
        self.cpu.it = 0;
        self.cpu.exclusive = false;
        self.cpu.event = true;
        let vector = self.system.vector_table.wrapping_add(4 * number as u32);
        let Ok(target) = self.load::<4>(vector) else {
            self.system.hard_status |= 2;
            return Err(Trap::stop(format!(
                "no vector for exception {number} at {vector:#010x}"
            )));
        };
        if target & 1 == 0 {
            return Err(Trap::stop(format!(
                "vector {number} is {target:#010x}: not an address of code"
            )));
        }
        self.observe_exception(number, true);
        self.cpu.pc = target & !1;
        Ok(())
    }

    /// A branch to `link`, one of the special values, from a handler.
    pub(crate) fn leave_exception(&mut self, link: u32) -> Try {
        let number = usize::from(self.cpu.ipsr);
        let (thread, process) = match link & 0xffff_ffef {
            0xffff_ffe1 => (false, false),
            0xffff_ffe9 => (true, false),
            0xffff_ffed => (true, true),
            _ => return Err(Trap::Fault(Fault::Return)),
        };
        if !self.nvic.end(number) || thread != self.nvic.active.is_empty() {
            return Err(Trap::Fault(Fault::Return));
        }
        self.observe_exception(number, false);
        self.cpu.faultmask &= number == 2;
        self.attend();
        // What is due now is entered without taking the frame off and putting it on again.
        let due = self.nvic.most_urgent();
        if let Some(next) = due.filter(|n| self.nvic.group_of(*n) < self.execution_priority()) {
            self.cpu.r[14] = link;
            self.spend(TAIL_CYCLES);
            return self.start_handler(next, false);
        }
        self.pop_frame(link, process)
    }

    fn pop_frame(&mut self, link: u32, process: bool) -> Try {
        self.spend(EXIT_CYCLES);
        let float = link & 0x10 == 0;
        let sp = if process {
            self.cpu.other_sp
        } else {
            self.cpu.r[13]
        };
        let mut words = [0; 8];
        for (i, word) in words.iter_mut().enumerate() {
            let word_at = sp.wrapping_add(4 * i as u32);
            *word = self.load::<4>(word_at).map_err(|trap| match trap {
                Trap::Fault(_) => Trap::Fault(Fault::BusUnstacking),
                stop => stop,
            })?;
        }
        if float {
            if self.system.lazy {
                self.system.lazy = false;
            } else {
                for i in 0..16u32 {
                    self.cpu.s[i as usize] = self.load::<4>(sp.wrapping_add(0x20 + 4 * i))?;
                }
                self.cpu.fpscr = self.load::<4>(sp.wrapping_add(0x60))?;
            }
        }
        let [r0, r1, r2, r3, r12, lr, pc, status] = words;
        for (i, value) in [(0, r0), (1, r1), (2, r2), (3, r3), (12, r12), (14, lr)] {
            self.cpu.r[i] = value;
        }
        let size = if float { 0x68 } else { 0x20 };
        let sp = sp.wrapping_add(size) | (status >> 7 & 4);
        self.cpu.control = self.cpu.control & !6 | u32::from(process) << 1 | u32::from(float) << 2;
        if process {
            self.cpu.other_sp = self.cpu.r[13];
        }
        self.cpu.r[13] = sp;
        self.cpu.ipsr = (status & 0x1ff) as u16;
        self.cpu.set_xpsr(status);
        self.cpu.pc = pc & !1;
        if (self.cpu.ipsr == 0) != self.nvic.active.is_empty() || status & 1 << 24 == 0 {
            return Err(Trap::Fault(Fault::Return));
        }
        self.cpu.exclusive = false;
        Ok(())
    }

    /// The processor faults: at the instruction that [`super::Cpu::pc`] names.
    pub(crate) fn raise(&mut self, fault: Fault) -> Try {
        let (number, bits) = match fault {
            Fault::Bus(address) => {
                self.system.bus_address = address;
                (BUS_FAULT, status::PRECISERR | status::BFARVALID)
            }
            Fault::BusLate => (BUS_FAULT, status::IMPRECISERR),
            Fault::BusFetch => (BUS_FAULT, status::IBUSERR),
            Fault::BusStacking => (BUS_FAULT, status::STKERR),
            Fault::BusUnstacking => (BUS_FAULT, status::UNSTKERR),
            Fault::Fetch => (MEM_MANAGE, status::IACCVIOL),
            Fault::Undefined => (USAGE_FAULT, status::UNDEFINSTR),
            Fault::Unaligned => (USAGE_FAULT, status::UNALIGNED),
            Fault::DivideByZero => (USAGE_FAULT, status::DIVBYZERO),
            Fault::State => (USAGE_FAULT, status::INVSTATE),
            Fault::Return => (USAGE_FAULT, status::INVPC),
            Fault::NoFloat => (USAGE_FAULT, status::NOCP),
            Fault::Breakpoint => {
                self.system.hard_status |= 1 << 31;
                return self.enter_hard_fault();
            }
        };
        self.system.fault_status |= bits;
        let own =
            self.nvic.enabled[number] && self.nvic.group_of(number) < self.execution_priority();
        if own {
            return self.enter_fault(number);
        }
        self.system.hard_status |= 1 << 30;
        self.enter_hard_fault()
    }

    /// `svc`: where it may not be taken it is a HardFault, which goes on behind it, as QEMU has it.
    pub(crate) fn call(&mut self) -> Try {
        if self.nvic.group_of(CALL) < self.execution_priority() {
            self.pend_exception(CALL);
            return Ok(());
        }
        self.system.hard_status |= 1 << 30;
        self.attend();
        self.enter_hard_fault()
    }

    fn enter_hard_fault(&mut self) -> Try {
        if self.execution_priority() <= -1 {
            self.lock_up();
            return Ok(());
        }
        if self.system.catches_hard_faults() {
            self.halt("a HardFault, which the debugger catches");
            return Ok(());
        }
        self.enter_fault(HARD_FAULT)
    }

    fn enter_fault(&mut self, number: usize) -> Try {
        if self.system.fault_status & status::STKERR != 0 {
            // The frame is lost already; the handler starts where the stack is.
            self.spend(ENTRY_CYCLES);
            self.cpu.r[14] = 0xffff_fff1;
            return self.start_handler(number, false);
        }
        self.enter_exception(number)
    }

    /// `bkpt`: halts with a debugger, else a HardFault.
    pub(crate) fn breakpoint(&mut self) -> Try {
        if self.system.debugger_attached() {
            self.halt("a breakpoint");
            return Ok(());
        }
        Err(Trap::Fault(Fault::Breakpoint))
    }
}
