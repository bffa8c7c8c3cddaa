//! Loads and stores, and what changes the processor's own state.

use super::op::{Kind, Op, mode, width};
use super::{Fault, Trap, Try};
use crate::machine::Machine;

impl Machine {
    #[inline(always)]
    fn base(&self, op: &Op) -> u32 {
        self.cpu.r[usize::from(op.rn & 15)]
    }

    /// Address of a register offset.
    #[inline(always)]
    pub(super) fn indexed(&self, op: &Op) -> u32 {
        self.base(op)
            .wrapping_add(self.cpu.r[usize::from(op.rm & 15)] << op.imm)
    }

    /// Address of a constant offset.
    #[inline(always)]
    pub(super) fn offset(&self, op: &Op) -> u32 {
        self.base(op).wrapping_add(op.imm)
    }

    fn load_as(&mut self, how: u32, address: u32) -> Try<u32> {
        Ok(match how {
            width::WORD => self.load::<4>(address)?,
            width::BYTE => self.load::<1>(address)?,
            width::HALF => self.load::<2>(address)?,
            width::SIGNED_BYTE => self.load::<1>(address)? as i8 as u32,
            _ => self.load::<2>(address)? as i16 as u32,
        })
    }

    fn store_as(&mut self, how: u32, address: u32, value: u32) -> Try {
        match how {
            width::WORD => self.store::<4>(address, value),
            width::BYTE => self.store::<1>(address, value),
            _ => self.store::<2>(address, value),
        }
    }

    /// Loads `W` bytes, made into a word by `extend`, into the destination.
    #[inline(always)]
    pub(super) fn load_to<const W: usize>(
        &mut self,
        op: &Op,
        address: u32,
        extend: impl Fn(u32) -> u32,
    ) -> Try {
        let loaded = extend(self.load::<W>(address)?);
        if op.rd == 15 {
            return self.interwork(loaded);
        }
        self.cpu.set(op.rd, loaded);
        Ok(())
    }

    pub(super) fn load_many(&mut self, op: &Op) -> Try {
        let base = self.base(op);
        let size = 4 * op.imm.count_ones();
        let down = op.ra & mode::BEFORE as u8 != 0;
        let start = if down { base.wrapping_sub(size) } else { base };
        if start & 3 != 0 {
            return Err(Trap::Fault(Fault::Unaligned));
        }
        let mut values = [0; 16];
        let mut address = start;
        for (i, slot) in values.iter_mut().enumerate() {
            if op.imm >> i & 1 == 1 {
                *slot = self.load::<4>(address)?;
                address = address.wrapping_add(4);
            }
        }
        if op.ra & mode::WRITE_BACK as u8 != 0 {
            self.cpu.set(op.rn, if down { start } else { address });
        }
        for (i, value) in values.iter().enumerate().take(15) {
            if op.imm >> i & 1 == 1 {
                self.cpu.set(i as u8, *value);
            }
        }
        if op.imm >> 15 & 1 == 1 {
            return self.interwork(values[15]);
        }
        Ok(())
    }

    pub(super) fn store_many(&mut self, op: &Op) -> Try {
        let base = self.base(op);
        let size = 4 * op.imm.count_ones();
        let down = op.ra & mode::BEFORE as u8 != 0;
        let start = if down { base.wrapping_sub(size) } else { base };
        if start & 3 != 0 {
            return Err(Trap::Fault(Fault::Unaligned));
        }
        let mut address = start;
        for i in 0..15 {
            if op.imm >> i & 1 == 1 {
                self.store::<4>(address, self.cpu.r[i])?;
                address = address.wrapping_add(4);
            }
        }
        if op.ra & mode::WRITE_BACK as u8 != 0 {
            self.cpu.set(op.rn, if down { start } else { address });
        }
        Ok(())
    }

    /// The address of an access with an addressing mode, and what the base becomes.
    #[inline(always)]
    fn addressed(&self, op: &Op) -> (u32, u32) {
        let base = self.base(op);
        let moved = base.wrapping_add(op.imm);
        let before = op.ra & mode::BEFORE as u8 != 0;
        (if before { moved } else { base }, moved)
    }

    #[inline(always)]
    fn write_back(&mut self, op: &Op, moved: u32) {
        if op.ra & mode::WRITE_BACK as u8 != 0 {
            self.cpu.set(op.rn, moved);
        }
    }

    #[inline(always)]
    pub(super) fn load_indexed(&mut self, op: &Op) -> Try {
        let (address, moved) = self.addressed(op);
        let loaded = self.load_as(u32::from(op.s), address)?;
        self.write_back(op, moved);
        if op.rd == 15 {
            return self.interwork(loaded);
        }
        self.cpu.set(op.rd, loaded);
        Ok(())
    }

    #[inline(always)]
    pub(super) fn store_indexed(&mut self, op: &Op) -> Try {
        let (address, moved) = self.addressed(op);
        self.store_as(u32::from(op.s), address, self.d(op))?;
        self.write_back(op, moved);
        Ok(())
    }

    #[inline(always)]
    pub(super) fn load_pair(&mut self, op: &Op) -> Try {
        let (address, moved) = self.addressed(op);
        let address = if op.rn == 15 { address & !3 } else { address };
        must_align(address, 4)?;
        let first = self.load::<4>(address)?;
        let second = self.load::<4>(address.wrapping_add(4))?;
        self.write_back(op, moved);
        self.cpu.set(op.rd, first);
        self.cpu.set(op.s, second);
        Ok(())
    }

    #[inline(always)]
    pub(super) fn store_pair(&mut self, op: &Op) -> Try {
        let (address, moved) = self.addressed(op);
        must_align(address, 4)?;
        self.store::<4>(address, self.d(op))?;
        self.store::<4>(address.wrapping_add(4), self.cpu.r[usize::from(op.s & 15)])?;
        self.write_back(op, moved);
        Ok(())
    }

    /// Instructions that are rare: exclusive access, branches by table, special registers, calls, breakpoints, waiting.
    #[inline(never)]
    pub(super) fn execute_rare(&mut self, op: &Op) -> Try {
        let base = self.base(op);
        let moved = base.wrapping_add(op.imm);
        match op.kind {
            Kind::LdrLiteral => {
                let loaded = self.load_as(u32::from(op.s), op.imm)?;
                if op.rd == 15 {
                    return self.interwork(loaded);
                }
                self.cpu.set(op.rd, loaded);
            }
            Kind::LoadExclusive => {
                let size = [4, 1, 2][usize::from(op.s)];
                must_align(moved, size)?;
                let loaded = self.load_as(u32::from(op.s), moved)?;
                self.cpu.exclusive = true;
                self.cpu.set(op.rd, loaded);
            }
            Kind::StoreExclusive => {
                let size = [4, 1, 2][usize::from(op.s)];
                must_align(moved, size)?;
                let free = std::mem::take(&mut self.cpu.exclusive);
                if free {
                    self.store_as(u32::from(op.s), moved, self.cpu.r[usize::from(op.rd)])?;
                }
                self.cpu.set(op.rm, u32::from(!free));
            }
            Kind::ClearExclusive => self.cpu.exclusive = false,
            Kind::TableByte | Kind::TableHalf => {
                let index = self.cpu.r[usize::from(op.rm)];
                let entry = if op.kind == Kind::TableByte {
                    self.load::<1>(base.wrapping_add(index))?
                } else {
                    self.load::<2>(base.wrapping_add(index << 1))?
                };
                self.cpu.pc = self.cpu.r[15].wrapping_add(2 * entry);
            }
            Kind::Mrs => self.read_special(op),
            Kind::Msr => self.write_special(op),
            Kind::Cps => self.change_masks(op),
            Kind::Svc => return self.call(),
            Kind::Breakpoint => return self.breakpoint(),
            Kind::WaitInterrupt => self.sleep(),
            Kind::WaitEvent => {
                if !std::mem::take(&mut self.cpu.event) {
                    self.sleep();
                }
            }
            _ => self.cpu.event = true,
        }
        Ok(())
    }

    fn sleep(&mut self) {
        self.cpu.sleeping = true;
        self.attend();
    }
}

/// These accesses fault at an address that is no multiple of `size`, whatever the program has set.
#[inline(always)]
fn must_align(address: u32, size: u32) -> Try {
    if address & (size - 1) == 0 {
        Ok(())
    } else {
        Err(Trap::Fault(Fault::Unaligned))
    }
}
