//! Special registers: status, stack pointers, masks and control (ARMv7-M Architecture Reference Manual, B5.2).

use super::nvic::PRIORITY_BITS;
use super::op::Op;
use crate::machine::Machine;

impl Machine {
    pub(crate) fn read_special(&mut self, op: &Op) {
        let cpu = &self.cpu;
        let x = cpu.xpsr();
        let value = match op.imm {
            0 => x & 0xf80f_0000,
            1 => x & 0xf80f_01ff,
            3 => x & 0xf80f_01ff,
            5 => x & 0x1ff,
            2 | 6 | 7 => 0,
            8 => cpu.stacks().0,
            9 => cpu.stacks().1,
            16 => u32::from(cpu.primask),
            17 | 18 => u32::from(cpu.basepri),
            19 => u32::from(cpu.faultmask),
            20 => cpu.control,
            _ => 0,
        };
        self.cpu.set(op.rd, value);
    }

    pub(crate) fn write_special(&mut self, op: &Op) {
        let value = self.cpu.r[usize::from(op.rn)];
        let process = self.cpu.on_process_stack();
        match op.imm {
            0..=3 => {
                if op.ra & 2 != 0 {
                    self.cpu.set_apsr(value);
                }
                if op.ra & 1 != 0 {
                    self.cpu.ge = (value >> 16 & 15) as u8;
                }
            }
            8 | 9 if (op.imm == 9) == process => self.cpu.set(13, value),
            8 | 9 => self.cpu.other_sp = value & !3,
            16 => self.cpu.primask = value & 1 == 1,
            17 => self.cpu.basepri = value as u8 & PRIORITY_BITS,
            18 => {
                let new = value as u8 & PRIORITY_BITS;
                if new != 0 && (new < self.cpu.basepri || self.cpu.basepri == 0) {
                    self.cpu.basepri = new;
                }
            }
            19 => self.cpu.faultmask = value & 1 == 1 && self.execution_priority() > -1,
            20 => {
                let stack = if self.cpu.ipsr == 0 {
                    value & 2
                } else {
                    self.cpu.control & 2
                };
                self.cpu.control = value & 5 | stack;
                self.cpu.use_stack(process, self.cpu.on_process_stack());
            }
            _ => {}
        }
        self.nvic.changed = true;
        self.attend();
        if self.profile.is_some() {
            self.profile_masks();
        }
    }

    /// Masks exceptions (`cpsid`), or no longer (`cpsie`), by PRIMASK and FAULTMASK.
    pub(crate) fn change_masks(&mut self, op: &Op) {
        let off = op.ra == 1;
        if op.imm & 2 != 0 {
            self.cpu.primask = off;
        }
        if op.imm & 1 != 0 {
            self.cpu.faultmask = off;
        }
        self.nvic.changed = true;
        self.attend();
        if self.profile.is_some() {
            self.profile_masks();
        }
    }
}
