//! The processor's own registers: system control block, SysTick, cycle counter, floating point, debug
//! (ARMv7-M Architecture Reference Manual, B3.2, B3.3, C1.6, C1.8).

use super::nvic::PRIORITY_BITS;
use super::{Trap, Try};
use crate::machine::Machine;

/// What those registers hold.
#[derive(Clone, Debug)]
pub struct System {
    /// Address of the vectors.
    pub vector_table: u32,
    /// Which faults of memory, bus and usage happened: CFSR.
    pub fault_status: u32,
    /// Why there was a hard fault: HFSR.
    pub hard_status: u32,
    /// Address of the last bus fault: BFAR.
    pub bus_address: u32,
    /// Floating point is to be stacked when it is next used.
    pub lazy: bool,
    /// Where floating point is to be stacked: FPCAR.
    pub float_address: u32,
    /// Status with which floating point begins: FPDSCR.
    pub default_status: u32,
    configuration: u32,
    float_control: u32,
    access: u32,
    sleep: u32,
    debug_status: u32,
    debug: u32,
    /// DEMCR: which faults and resets halt, and whether the cycle counter is on.
    pub traps: u32,
    counter_on: bool,
    /// Cycle count at which the counter was 0.
    counter_zero: u64,
    /// SysTick's control, reload, and the cycle at which it last was reloaded.
    pub tick_control: u32,
    tick_reload: u32,
    tick_start: u64,
    tick_flag_seen: u64,
}

impl System {
    /// As after a reset. What the debugger has set stays.
    pub fn reset(before: Option<&Self>) -> Self {
        Self {
            vector_table: 0,
            fault_status: 0,
            hard_status: 0,
            bus_address: 0,
            lazy: false,
            float_address: 0,
            default_status: 0,
            configuration: 0x200,
            float_control: 0xc000_0000,
            access: 0,
            sleep: 0,
            debug_status: 0,
            debug: before.map_or(0, |b| b.debug),
            traps: before.map_or(0, |b| b.traps),
            counter_on: false,
            counter_zero: 0,
            tick_control: 0,
            tick_reload: 0,
            tick_start: 0,
            tick_flag_seen: 0,
        }
    }

    /// Whether floating point is switched on.
    #[inline(always)]
    pub fn float_enabled(&self) -> bool {
        self.access & 0x00f0_0000 == 0x00f0_0000
    }

    /// Switches floating point on, as a write of CPACR does.
    pub fn switch_float_on(&mut self) {
        self.access = 0x00f0_0000;
    }

    /// Whether its use is noted by itself.
    #[inline(always)]
    pub fn automatic_state(&self) -> bool {
        self.float_control >> 31 == 1
    }

    /// Whether room is left for it at entry, to be filled later.
    pub fn lazy_enabled(&self) -> bool {
        self.float_control >> 30 & 1 == 1
    }

    /// Whether a division by zero is a fault.
    pub fn faults_on_zero(&self) -> bool {
        self.configuration & 0x10 != 0
    }

    /// Whether an address that is not a multiple is a fault everywhere.
    pub fn faults_on_unaligned(&self) -> bool {
        self.configuration & 8 != 0
    }

    /// Attaches a debugger with these traps (DEMCR), or takes it away.
    pub fn attach(&mut self, traps: Option<u32>) {
        self.debug = u32::from(traps.is_some());
        self.traps = traps.unwrap_or(0) | self.traps & 1 << 24;
    }

    /// Whether halting debug is enabled.
    pub fn debugger_attached(&self) -> bool {
        self.debug & 1 == 1
    }

    /// Whether a HardFault halts.
    pub fn catches_hard_faults(&self) -> bool {
        self.debugger_attached() && self.traps >> 10 & 1 == 1
    }

    /// Whether a reset halts.
    pub fn catches_reset(&self) -> bool {
        self.debugger_attached() && self.traps & 1 == 1
    }
}

impl Machine {
    /// When SysTick next interrupts, in cycles.
    pub(crate) fn tick_due(&self) -> Option<u64> {
        let system = &self.system;
        if system.tick_control & 3 != 3 || system.tick_reload == 0 {
            return None;
        }
        let period = u64::from(system.tick_reload) + 1;
        let elapsed = self.cycles.saturating_sub(system.tick_start);
        Some(system.tick_start + (elapsed / period + 1) * period)
    }

    fn tick_now(&self) -> u32 {
        let system = &self.system;
        if system.tick_control & 1 == 0 || system.tick_reload == 0 {
            return 0;
        }
        let period = u64::from(system.tick_reload) + 1;
        let elapsed = self.cycles.saturating_sub(system.tick_start);
        (u64::from(system.tick_reload) - elapsed % period) as u32
    }

    /// Reads a word of the processor's own registers.
    pub(crate) fn read_system(&mut self, address: u32) -> Try<u32> {
        let word = address & !3;
        let system = &self.system;
        Ok(match word {
            0xe000_1000 => 0x4000_0000 | u32::from(system.counter_on),
            0xe000_1004 => {
                if system.counter_on {
                    (self.cycles - system.counter_zero) as u32
                } else {
                    system.counter_zero as u32
                }
            }
            0xe000_e010 => {
                let period = u64::from(system.tick_reload) + 1;
                let wraps = self.cycles.saturating_sub(system.tick_start) / period;
                let flag = u32::from(system.tick_control & 1 == 1 && wraps > system.tick_flag_seen);
                let value = system.tick_control | flag << 16;
                self.system.tick_flag_seen = wraps;
                value
            }
            0xe000_e014 => system.tick_reload,
            0xe000_e018 => self.tick_now(),
            0xe000_e100..=0xe000_e4ff => {
                let value = self.nvic.read(word - 0xe000_e100);
                value.ok_or_else(|| Trap::stop(format!("no interrupt register at {word:#010x}")))?
            }
            0xe000_ed00 => 0x410f_c241,
            0xe000_ed04 => self.interrupt_state(),
            0xe000_ed08 => system.vector_table,
            0xe000_ed0c => 0xfa05_0000 | u32::from(self.nvic.grouping) << 8,
            0xe000_ed10 => system.sleep,
            0xe000_ed14 => system.configuration,
            0xe000_ed18..=0xe000_ed20 => {
                let first = (word - 0xe000_ed18) as usize + 4;
                (0..4).fold(0, |value, i| {
                    value | u32::from(self.nvic.priority[first + i]) << (8 * i)
                })
            }
            0xe000_ed24 => (4..7).fold(0, |value, n| {
                value | u32::from(self.nvic.enabled[n]) << (12 + n)
            }),
            0xe000_ed28 => system.fault_status,
            0xe000_ed2c => system.hard_status,
            0xe000_ed30 => system.debug_status,
            0xe000_ed38 => system.bus_address,
            0xe000_ed88 => system.access,
            0xe000_edf0 => system.debug & 1,
            0xe000_edfc => system.traps,
            0xe000_ef34 => system.float_control | u32::from(system.lazy),
            0xe000_ef38 => system.float_address,
            0xe000_ef3c => system.default_status,
            _ => {
                return Err(Trap::stop(format!(
                    "register {word:#010x} of the processor is not modelled"
                )));
            }
        })
    }

    fn interrupt_state(&self) -> u32 {
        let pending = self.nvic.most_urgent().map_or(0, |n| n as u32);
        u32::from(self.cpu.ipsr)
            | u32::from(self.nvic.active.len() <= 1) << 11
            | pending << 12
            | u32::from(self.nvic.pending[14]) << 28
            | u32::from(self.nvic.pending[15]) << 26
            | u32::from(self.nvic.pending[2]) << 31
    }

    /// Writes the bits of `mask` of a word of the processor's own registers.
    pub(crate) fn write_system(&mut self, address: u32, value: u32, mask: u32) -> Try {
        let word = address & !3;
        let value = self.around.patch.changed(address, value);
        let merged = |before: u32| before & !mask | value & mask;
        let only = |bits: u32| {
            if value & mask & !bits == 0 {
                Ok(())
            } else {
                Err(Trap::stop(format!(
                    "{value:#010x} to {word:#010x} sets reserved bits"
                )))
            }
        };
        match word {
            0xe000_1000 => {
                only(0x4000_0001)?;
                let on = value & 1 == 1;
                if on != self.system.counter_on {
                    self.system.counter_zero = self.cycles.wrapping_sub(self.system.counter_zero);
                    self.system.counter_on = on && self.system.traps >> 24 & 1 == 1;
                }
            }
            0xe000_1004 => {
                let now = if self.system.counter_on {
                    self.cycles
                } else {
                    0
                };
                self.system.counter_zero = now.wrapping_sub(u64::from(value));
            }
            0xe000_e010 => {
                only(7)?;
                if value & 4 == 0 && value & 1 == 1 {
                    return Err(Trap::stop("SysTick from HCLK/8 is not modelled"));
                }
                self.system.tick_control = value & 7;
                self.system.tick_start = self.cycles;
            }
            0xe000_e014 => {
                only(0x00ff_ffff)?;
                self.system.tick_reload = value;
            }
            0xe000_e018 => self.system.tick_start = self.cycles,
            0xe000_e100..=0xe000_e4ff => {
                let done = self.nvic.write(word - 0xe000_e100, value, mask);
                done.map_err(Trap::stop)?;
            }
            0xe000_ed04 => self.pend_by_register(value),
            0xe000_ed08 => {
                if merged(0) & 0x1ff != 0 {
                    return Err(Trap::stop(format!(
                        "vector table at {value:#010x}: not a multiple of 512"
                    )));
                }
                self.system.vector_table = value;
            }
            0xe000_ed0c => {
                if value >> 16 == 0x05fa {
                    self.nvic.grouping = (value >> 8 & 7) as u8;
                    if value & 4 != 0 {
                        self.request_reset();
                    }
                }
            }
            0xe000_ed10 => {
                only(0x16)?;
                self.system.sleep = merged(self.system.sleep);
            }
            0xe000_ed14 => {
                only(0x31b)?;
                self.system.configuration = merged(self.system.configuration);
            }
            0xe000_ed18..=0xe000_ed20 => {
                let first = (word - 0xe000_ed18) as usize + 4;
                for i in (0..4).filter(|i| mask >> (8 * i) & 0xff != 0) {
                    self.nvic.priority[first + i] = (value >> (8 * i)) as u8 & PRIORITY_BITS;
                }
            }
            0xe000_ed24 => {
                let new = merged(self.read_system(word)?);
                (4..7).for_each(|n| self.nvic.enabled[n] = new >> (12 + n) & 1 == 1);
            }
            0xe000_ed28 => self.system.fault_status &= !(value & mask),
            0xe000_ed2c => self.system.hard_status &= !(value & mask),
            0xe000_ed30 => self.system.debug_status &= !(value & mask),
            0xe000_ed88 => {
                only(0x00f0_0000)?;
                self.system.access = merged(self.system.access);
            }
            // Key and halting are the debugger's.
            0xe000_edf0 => {}
            0xe000_edfc => self.system.traps = merged(self.system.traps),
            0xe000_ef34 => {
                self.system.float_control = merged(self.system.float_control) & 0xc000_0000
            }
            0xe000_ef3c => self.system.default_status = merged(self.system.default_status),
            _ => {
                return Err(Trap::stop(format!(
                    "register {word:#010x} of the processor is not modelled"
                )));
            }
        }
        self.nvic.changed = true;
        self.attend();
        self.reschedule();
        Ok(())
    }

    fn pend_by_register(&mut self, value: u32) {
        for (bit, number, set) in [
            (28, 14, true),
            (27, 14, false),
            (26, 15, true),
            (25, 15, false),
            (31, 2, true),
        ] {
            if value >> bit & 1 == 1 {
                self.nvic.pending[number] = set;
            }
        }
    }
}
