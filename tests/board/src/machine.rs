//! The whole board: processor, memory, peripherals, time.

use std::rc::Rc;

use crate::core::Cpu;
use crate::core::nvic::Nvic;
use crate::core::op::Op;
use crate::core::system::System;
use crate::image::Image;
use crate::memory::{RAM_SIZE, Ram};
use crate::parts::adc::Adc;
use crate::parts::capture::Capture;
use crate::parts::dac::Dac;
use crate::parts::dbgmcu::Dbgmcu;
use crate::parts::dma::Dma;
use crate::parts::exti::Exti;
use crate::parts::flash::{Flash, SIZE as FLASH_SIZE};
use crate::parts::gpio::{Gpio, Outside};
use crate::parts::pwr::Pwr;
use crate::parts::rcc::{External, Rcc, cause};
use crate::parts::timer::Timer;
use crate::parts::usart::Usart;
use crate::parts::watchdog::Watchdog;
use crate::parts::{Clocks, NEVER};
use crate::profile::Profile;
use crate::waiting::Waiting;

/// Something that changed at the board's edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// The enable line, PA8; `None`: not driven.
    Enable(Option<bool>),
    /// The code at PA4; `None`: the converter is off.
    Dac(Option<u16>),
    /// The LED at PA5; `None`: not driven.
    Led(Option<bool>),
    /// The motor's duty cycle at PC7.
    Duty(Option<f64>),
    /// A reset, with the flags that it leaves.
    Reset(u32),
    /// The processor halts for the debugger.
    Halt(&'static str),
    /// The processor has locked up.
    LockUp,
}

/// The peripherals of the microcontroller, and its clocks.
#[derive(Clone, Debug)]
#[allow(missing_docs)]
pub struct Parts {
    pub clocks: Clocks,
    pub rcc: Rcc,
    pub pwr: Pwr,
    pub flash: Flash,
    pub gpio: [Gpio; 8],
    pub exti: Exti,
    pub tim: [Timer; 4],
    pub capture: Capture,
    pub adc: Adc,
    pub dma: [Dma; 2],
    pub dac: Dac,
    pub usart: Usart,
    pub watchdog: Watchdog,
    pub dbgmcu: Dbgmcu,
}

/// What the program writes to some bits of a register is another value: a mistake in its set-up.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    /// Address of the register.
    pub register: u32,
    /// The bits of the register that become another value.
    pub mask: u32,
    /// What these bits become, in their places.
    pub value: u32,
}

impl Patch {
    /// No mistake: every register gets what is written.
    pub const NONE: Self = Self {
        register: 0,
        mask: 0,
        value: 0,
    };

    /// What is written in place of `value`.
    pub(crate) fn changed(&self, address: u32, value: u32) -> u32 {
        if address & !3 == self.register {
            value & !self.mask | self.value
        } else {
            value
        }
    }
}

/// What stays the same over a reset: what is around the part.
#[derive(Clone, Copy, Debug)]
pub struct Around {
    /// What the HSE's pin is given.
    pub hse: External,
    /// What is outside the pins of ports A to H.
    pub pins: [[Outside; 16]; 8],
    /// Supply voltage, V.
    pub supply_v: f64,
    /// The watchdog's clock, Hz: 17,000 to 47,000 (DS10693, 6.3.9).
    pub lsi_hz: u64,
    /// The flash takes the longest times of the data sheet, not the typical ones.
    pub slow_flash: bool,
    /// Option bytes at power-up: brown-out level, write protection.
    pub options: u32,
    /// Rate of the link's other end.
    pub baud: u64,
    /// A mistake in the program's set-up.
    pub patch: Patch,
}

/// The whole board as a model: processor, memory, peripherals, and their time.
#[derive(Clone)]
pub struct Machine {
    /// Registers and flags of the processor.
    pub cpu: Cpu,
    /// The interrupt controller, with what is pending and in work.
    pub nvic: Nvic,
    /// The processor's own registers.
    pub system: System,
    /// The peripherals, and the clocks that they have.
    pub parts: Parts,
    /// What is around the part.
    pub around: Around,
    /// Names and places of the program.
    pub image: Rc<Image>,
    /// Bytes of the flash.
    pub flash: Vec<u8>,
    /// Bytes of the RAM.
    pub ram: Box<Ram>,
    /// Which of them were written since power-up.
    pub known: Box<Ram>,
    pub(crate) ops: Vec<Op>,
    /// Time, in units of 1/720 MHz.
    pub now: u64,
    /// Units per cycle of the processor.
    pub unit: u32,
    /// Cycles of the processor since power-up, by the static table.
    pub cycles: u64,
    /// Instructions since power-up, with those of waiting that was passed over.
    pub instructions: u64,
    /// Sampling ticks since power-up.
    pub ticks: u64,
    /// Codes that the ADC's channels measure.
    pub codes: [u16; 19],
    pub(crate) next_event: u64,
    /// How long instructions follow each other with nothing to be looked at; 0: something is.
    pub(crate) horizon: u64,
    /// Until when the run goes.
    pub(crate) until: u64,
    pub(crate) pause: bool,
    /// Whether loops in which the program waits are passed over; what comes out is the same.
    pub skips: bool,
    /// Instructions since power-up that were passed over.
    pub passed: u64,
    pub(crate) waiting: Waiting,
    /// Where a branch back has led to.
    pub(crate) head: u32,
    /// Whether what the instruction in work touches is written down.
    pub(crate) watching: bool,
    pub(crate) late_fault: bool,
    pub(crate) attention: bool,
    pub(crate) reset_asked: bool,
    pub(crate) halted: bool,
    /// The flash as a power cut in the middle of each operation would leave it, while somebody wants that.
    pub(crate) cuts: Option<Vec<Vec<u8>>>,
    /// What happened at the edge: when, and what.
    pub changes: Vec<(u64, Change)>,
    last: [Option<Change>; 4],
    /// Times that each exception was entered.
    pub entered: [u64; 113],
    /// Lowest stack pointer seen at an exception's entry.
    pub lowest_stack: u32,
    /// What it costs, while somebody wants that.
    pub profile: Option<Box<Profile>>,
}

/// HSI: all clocks at 16 MHz.
const AFTER_RESET: Clocks = Clocks {
    hclk: 45,
    pclk1: 45,
    pclk2: 45,
    timclk1: 45,
};

fn filled(bytes: impl Iterator<Item = u8>) -> Box<Ram> {
    let mut ram = Box::new([0; RAM_SIZE]);
    ram.iter_mut()
        .zip(bytes)
        .for_each(|(slot, byte)| *slot = byte);
    ram
}

fn parts(flags: u32, around: &Around) -> Parts {
    Parts {
        clocks: AFTER_RESET,
        rcc: Rcc::new(flags, around.hse),
        pwr: Pwr::new(around.supply_v),
        flash: Flash::new(around.options, around.slow_flash),
        gpio: std::array::from_fn(|port| Gpio::new(port, around.pins[port])),
        exti: Exti::default(),
        tim: [
            Timer::new(false, true),
            Timer::new(false, false),
            Timer::new(true, false),
            Timer::new(true, false),
        ],
        capture: Capture::default(),
        adc: Adc::default(),
        dma: [Dma::new(1), Dma::new(2)],
        dac: Dac::default(),
        usart: Usart::new(around.baud),
        watchdog: Watchdog::new(around.lsi_hz),
        dbgmcu: Dbgmcu::default(),
    }
}

impl Machine {
    /// Power comes on: the image in flash, RAM random but the same for each `seed`.
    pub fn power_up(image: Rc<Image>, around: Around, seed: u64) -> Self {
        let mut flash = vec![0xff; FLASH_SIZE];
        image.place(&mut flash);
        let mut state = seed | 1;
        let random = std::iter::from_fn(move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            Some((state >> 56) as u8)
        });
        let mut machine = Self {
            cpu: Cpu::default(),
            nvic: Nvic::default(),
            system: System::reset(None),
            parts: parts(0, &around),
            around,
            image,
            flash,
            ram: filled(random),
            known: filled(std::iter::repeat(0)),
            ops: vec![Op::NOT_DECODED; FLASH_SIZE / 2],
            now: 0,
            unit: AFTER_RESET.hclk,
            cycles: 0,
            instructions: 0,
            ticks: 0,
            codes: [0; 19],
            next_event: NEVER,
            horizon: 0,
            until: 0,
            pause: false,
            skips: true,
            passed: 0,
            waiting: Waiting::default(),
            head: u32::MAX,
            watching: false,
            late_fault: false,
            attention: false,
            reset_asked: false,
            halted: false,
            cuts: None,
            changes: Vec::new(),
            last: [None; 4],
            entered: [0; 113],
            lowest_stack: u32::MAX,
            profile: None,
        };
        machine.reset(cause::POWER_ON | cause::BROWN_OUT | cause::PIN);
        machine
    }

    /// A reset: RAM and flash stay, flags are added to those not cleared yet.
    pub fn reset(&mut self, flags: u32) {
        let before = self.parts.rcc.read(0x74, self.now).unwrap_or(0) & 0xfe00_0000;
        // An operation of the flash under way is broken off.
        let broken = self.parts.flash.end();
        self.break_off(broken);
        let debug = std::mem::take(&mut self.parts.dbgmcu);
        self.parts = parts(before | flags, &self.around);
        self.parts.dbgmcu = debug;
        self.unit = AFTER_RESET.hclk;
        self.cpu = Cpu::default();
        self.nvic = Nvic::default();
        self.system = System::reset(Some(&self.system));
        self.reset_asked = false;
        self.late_fault = false;
        self.halted = false;
        let word = |flash: &[u8], at: usize| {
            u32::from_le_bytes(flash[at..at + 4].try_into().unwrap_or_default())
        };
        self.cpu.r[13] = word(&self.flash, 0) & !3;
        self.cpu.r[14] = u32::MAX;
        self.cpu.pc = word(&self.flash, 4) & !1;
        self.note(Change::Reset(before | flags));
        self.settle_pins();
        self.changes_dac_off();
        if self.system.catches_reset() {
            self.halt("the reset, which the debugger catches");
        }
        self.reschedule();
    }

    fn changes_dac_off(&mut self) {
        self.note(Change::Dac(None));
        self.note(Change::Duty(None));
    }

    /// Half of what was under way is done: bits that were to change are what they may be.
    pub(crate) fn break_off(&mut self, work: Option<crate::parts::flash::Work>) {
        use crate::parts::flash::{SECTORS, Work};
        // What is left of it has no rule: one pattern after the other.
        let pattern = self.cuts.as_ref().map_or(0, Vec::len) % 3;
        let left = [0x55, 0xaa, 0x33][pattern];
        match work {
            Some(Work::Program(at, bytes)) => {
                for (i, byte) in bytes.iter().enumerate() {
                    // Half of the bits that were to be cleared are.
                    self.flash[at as usize + i] &= byte | left;
                }
                self.forget(at as usize..at as usize + bytes.len());
            }
            Some(Work::Erase(sector)) => {
                let range = SECTORS[sector] as usize..SECTORS[sector + 1] as usize;
                let middle = range.start.midpoint(range.end);
                match pattern {
                    0 => self.flash[range.start..middle].fill(0xff),
                    1 => self.flash[middle..range.end].fill(0xff),
                    _ => self.flash[range.clone()]
                        .iter_mut()
                        .for_each(|byte| *byte |= left),
                }
                self.forget(range);
            }
            // They are what they were: what silicon has then is not said.
            Some(Work::Options(_)) | None => {}
        }
    }

    /// Decoded instructions of these bytes are decoded anew.
    pub(crate) fn forget(&mut self, range: std::ops::Range<usize>) {
        self.ops[range.start / 2..range.end / 2].fill(Op::NOT_DECODED);
        self.forget_waiting();
    }

    /// Writes down a change at the edge, unless it is none.
    pub(crate) fn note(&mut self, change: Change) {
        let slot = match change {
            Change::Enable(_) => 0,
            Change::Dac(_) => 1,
            Change::Led(_) => 2,
            Change::Duty(_) => 3,
            _ => {
                self.changes.push((self.now, change));
                return;
            }
        };
        if self.last[slot] != Some(change) {
            self.last[slot] = Some(change);
            self.changes.push((self.now, change));
        }
    }

    /// The enable line now: high?
    pub fn enabled(&self) -> bool {
        self.parts.gpio[0].driven(8) == Some(true)
    }

    /// Lets `cycles` of the processor pass.
    #[inline(always)]
    pub(crate) fn spend(&mut self, cycles: u32) {
        self.cycles += u64::from(cycles);
        self.now += u64::from(cycles) * u64::from(self.unit);
    }

    /// Something wants to be looked at before the next instruction.
    #[inline(always)]
    pub(crate) fn attend(&mut self) {
        self.attention = true;
        self.horizon = 0;
    }

    /// Nothing is to be looked at until something happens by itself.
    #[inline(always)]
    pub(crate) fn settle_horizon(&mut self) {
        self.horizon = if self.attention || self.waiting.open.is_some() {
            0
        } else {
            self.next_event.min(self.until)
        };
    }

    /// The program asks for a reset.
    pub(crate) fn request_reset(&mut self) {
        self.reset_asked = true;
        self.attend();
    }

    /// Stands still for the debugger.
    pub(crate) fn halt(&mut self, why: &'static str) {
        self.halted = true;
        self.note(Change::Halt(why));
        self.attend();
    }

    /// The processor can do nothing more until a reset.
    pub(crate) fn lock_up(&mut self) {
        self.halted = true;
        self.note(Change::LockUp);
        self.attend();
    }

    /// Whether the last run ended at a sampling tick.
    pub fn take_pause(&mut self) -> bool {
        std::mem::take(&mut self.pause)
    }

    /// Whether it stands still for good.
    pub fn is_halted(&self) -> bool {
        self.halted
    }

    pub(crate) fn observe_exception(&mut self, number: usize, begins: bool) {
        if begins {
            self.entered[number] += 1;
            self.break_round();
            self.lowest_stack = self.lowest_stack.min(self.cpu.r[13]);
        }
        if self.profile.is_some() {
            self.profile_exception(number, begins);
        }
    }

    /// Where the program is: source file and line.
    pub fn place(&self) -> String {
        self.image.place_of(self.cpu.pc)
    }
}
