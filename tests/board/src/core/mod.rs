//! The processor: a Cortex-M4 with floating point (ARMv7-M Architecture Reference Manual, DDI 0403).

pub mod arithmetic;
pub mod decode16;
pub mod decode32;
pub mod decode_fp;
pub mod dispatch;
pub mod dsp;
pub mod exception;
pub mod execute;
pub mod execute_fp;
pub mod execute_memory;
pub mod nvic;
pub mod op;
pub mod special;
pub mod system;

/// Why an instruction did not end as it should.
#[derive(Clone, Debug, PartialEq)]
pub enum Trap {
    /// The processor faults: the program sees it.
    Fault(Fault),
    /// A rule of this machine is broken: the run ends.
    Stop(Box<String>),
}

impl Trap {
    /// A rule of this machine is broken, as `why` says: the run ends.
    pub fn stop(why: impl Into<String>) -> Self {
        Self::Stop(Box::new(why.into()))
    }
}

/// What an instruction that can fail gives.
pub type Try<T = ()> = Result<T, Trap>;

/// A fault of the processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// A load from where nothing is.
    Bus(u32),
    /// A store to where nothing is: noticed when the instruction is over.
    BusLate,
    /// An instruction fetched from where nothing is.
    BusFetch,
    /// While a frame was stacked.
    BusStacking,
    /// While a frame was taken off.
    BusUnstacking,
    /// An instruction fetched from where none may be.
    Fetch,
    /// An instruction that is none.
    Undefined,
    /// An address that is not a multiple of its width, where it must be.
    Unaligned,
    /// A division by zero, where that is a fault.
    DivideByZero,
    /// A branch to an address whose bit 0 says "not Thumb".
    State,
    /// An exception's return that is none.
    Return,
    /// Floating point that is switched off.
    NoFloat,
    /// A breakpoint without a debugger.
    Breakpoint,
}

/// Registers and flags of the processor, and what it waits for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cpu {
    /// General registers; 13 is the stack pointer in use, 15 the address of the instruction and 4 more.
    pub r: [u32; 16],
    /// The stack pointer that is not in use.
    pub other_sp: u32,
    /// Address of the next instruction.
    pub pc: u32,
    /// Flag N: the result was negative.
    pub n: bool,
    /// Flag Z: the result was zero.
    pub z: bool,
    /// Flag C: an addition carried, or a subtraction did not borrow.
    pub c: bool,
    /// Flag V: signed arithmetic overflowed.
    pub v: bool,
    /// Flag Q: something has saturated.
    pub q: bool,
    /// Greater-or-equal flags of parallel arithmetic.
    pub ge: u8,
    /// State of the IT block, of the next instruction.
    pub it: u8,
    /// State of the IT block, of the instruction in work.
    pub it_now: u8,
    /// Number of the exception in work; 0: none.
    pub ipsr: u16,
    /// Bit 0: unprivileged, 1: process stack, 2: floating point in use.
    pub control: u32,
    /// PRIMASK: every exception with a priority of its own to set is masked.
    pub primask: bool,
    /// FAULTMASK: all but NMI is masked.
    pub faultmask: bool,
    /// The priority from which on all is masked; 0: none.
    pub basepri: u8,
    /// Floating-point registers S0 to S31, as bits.
    pub s: [u32; 32],
    /// Status of the floating point.
    pub fpscr: u32,
    /// An address is reserved by a load-exclusive.
    pub exclusive: bool,
    /// Waits for an interrupt.
    pub sleeping: bool,
    /// An event is noted.
    pub event: bool,
}

impl Cpu {
    /// Status register: flags, IT block and exception together.
    pub fn xpsr(&self) -> u32 {
        u32::from(self.n) << 31
            | u32::from(self.z) << 30
            | u32::from(self.c) << 29
            | u32::from(self.v) << 28
            | u32::from(self.q) << 27
            | u32::from(self.it & 3) << 25
            | 1 << 24
            | u32::from(self.ge) << 16
            | u32::from(self.it >> 2) << 10
            | u32::from(self.ipsr)
    }

    /// Sets flags and IT block from a status register; not the exception's number.
    pub fn set_xpsr(&mut self, x: u32) {
        self.set_apsr(x);
        self.ge = (x >> 16 & 15) as u8;
        self.it = ((x >> 25 & 3) | (x >> 8 & 0xfc)) as u8;
    }

    /// Sets the flags N, Z, C, V and Q from a status register.
    pub fn set_apsr(&mut self, x: u32) {
        self.n = x >> 31 & 1 == 1;
        self.z = x >> 30 & 1 == 1;
        self.c = x >> 29 & 1 == 1;
        self.v = x >> 28 & 1 == 1;
        self.q = x >> 27 & 1 == 1;
    }

    /// Whether the process stack is in use.
    pub fn on_process_stack(&self) -> bool {
        self.control & 2 != 0 && self.ipsr == 0
    }

    /// Changes to the other stack if `process` says so.
    pub fn use_stack(&mut self, was_process: bool, process: bool) {
        if was_process != process {
            std::mem::swap(&mut self.r[13], &mut self.other_sp);
        }
    }

    /// Main and process stack pointer.
    pub fn stacks(&self) -> (u32, u32) {
        if self.on_process_stack() {
            (self.other_sp, self.r[13])
        } else {
            (self.r[13], self.other_sp)
        }
    }

    /// Writes a register; the stack pointer is a multiple of 4.
    #[inline(always)]
    pub fn set(&mut self, d: u8, value: u32) {
        self.r[usize::from(d & 15)] = if d == 13 { value & !3 } else { value };
    }

    /// Whether a condition holds.
    #[inline(always)]
    pub fn holds(&self, condition: u8) -> bool {
        let yes = match condition >> 1 & 7 {
            0 => self.z,
            1 => self.c,
            2 => self.n,
            3 => self.v,
            4 => self.c && !self.z,
            5 => self.n == self.v,
            6 => !self.z && self.n == self.v,
            _ => return true,
        };
        yes != (condition & 1 == 1)
    }
}
