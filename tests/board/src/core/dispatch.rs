//! What each instruction does, found by one look at its kind. The frequent ones are done here or in what is inlined here;
//! the others are in `execute_more`, `execute_rare`, `execute_float` and `move_float`.

use super::arithmetic::add;
use super::op::{Kind, Op, shift as kinds};
use super::{Fault, Trap, Try};
use crate::machine::Machine;

/// A copy for what is not inlined: so the instruction itself need not lie in memory, from which it would have to be
/// loaded just after it was stored.
#[inline(always)]
fn copy(op: &Op) -> Op {
    *op
}

impl Machine {
    /// Does what one decoded instruction says.
    #[inline(always)]
    pub(crate) fn execute(&mut self, op: &Op) -> Try {
        match op.kind {
            Kind::AndI => self.with_constant(op, |n, b| n & b),
            Kind::BicI => self.with_constant(op, |n, b| n & !b),
            Kind::OrrI => self.with_constant(op, |n, b| n | b),
            Kind::OrnI => self.with_constant(op, |n, b| n | !b),
            Kind::EorI => self.with_constant(op, |n, b| n ^ b),
            Kind::MovI => self.with_constant(op, |_, b| b),
            Kind::MvnI => self.with_constant(op, |_, b| !b),
            Kind::AndR => self.with_shifted(op, |n, b| n & b),
            Kind::BicR => self.with_shifted(op, |n, b| n & !b),
            Kind::OrrR => self.with_shifted(op, |n, b| n | b),
            Kind::OrnR => self.with_shifted(op, |n, b| n | !b),
            Kind::EorR => self.with_shifted(op, |n, b| n ^ b),
            Kind::MovR => self.with_shifted(op, |_, b| b),
            Kind::MvnR => self.with_shifted(op, |_, b| !b),
            Kind::AddI => self.sum(op, self.n(op), op.imm, false),
            Kind::AddR => self.sum(op, self.n(op), self.shifted(op).0, false),
            Kind::AdcI => self.sum(op, self.n(op), op.imm, self.cpu.c),
            Kind::AdcR => self.sum(op, self.n(op), self.shifted(op).0, self.cpu.c),
            Kind::SbcI => self.sum(op, self.n(op), !op.imm, self.cpu.c),
            Kind::SbcR => self.sum(op, self.n(op), !self.shifted(op).0, self.cpu.c),
            Kind::SubI => self.sum(op, self.n(op), !op.imm, true),
            Kind::SubR => self.sum(op, self.n(op), !self.shifted(op).0, true),
            Kind::RsbI => self.sum(op, !self.n(op), op.imm, true),
            Kind::RsbR => self.sum(op, !self.n(op), self.shifted(op).0, true),
            Kind::CmpI => self.flags(add(self.n(op), !op.imm, true)),
            Kind::CmpR => self.flags(add(self.n(op), !self.shifted(op).0, true)),
            Kind::CmnI => self.flags(add(self.n(op), op.imm, false)),
            Kind::CmnR => self.flags(add(self.n(op), self.shifted(op).0, false)),
            Kind::TstI => self.test_constant(op, |n, b| n & b),
            Kind::TeqI => self.test_constant(op, |n, b| n ^ b),
            Kind::TstR => self.test_shifted(op, |n, b| n & b),
            Kind::TeqR => self.test_shifted(op, |n, b| n ^ b),
            Kind::Lsl => self.shift_by_register(op, kinds::LSL),
            Kind::Lsr => self.shift_by_register(op, kinds::LSR),
            Kind::Asr => self.shift_by_register(op, kinds::ASR),
            Kind::Ror => self.shift_by_register(op, kinds::ROR),
            Kind::Movt => {
                let low = self.cpu.r[usize::from(op.rd & 15)] & 0xffff;
                self.cpu.set(op.rd, op.imm << 16 | low);
            }
            Kind::Mul => {
                let carry = self.cpu.c;
                self.logical(op, self.n(op).wrapping_mul(self.m(op)), carry);
            }
            Kind::Umull => {
                let product = u64::from(self.n(op)) * u64::from(self.m(op));
                self.long(op, product);
            }
            Kind::Umlal => {
                let product = u64::from(self.n(op)) * u64::from(self.m(op));
                let before = u64::from(self.a(op)) << 32 | u64::from(self.d(op));
                self.long(op, before.wrapping_add(product));
            }
            Kind::Mla => {
                let product = self.n(op).wrapping_mul(self.m(op));
                self.cpu.set(op.rd, self.a(op).wrapping_add(product));
            }
            Kind::Branch => {
                self.jump(op.imm);
                self.came_round(op);
            }
            Kind::BranchIf => {
                if self.cpu.holds(op.rd) {
                    self.jump(op.imm);
                }
            }
            Kind::BranchLink => {
                self.cpu.r[14] = self.cpu.pc | 1;
                self.jump(op.imm);
            }
            Kind::BranchLinkReg => {
                let target = self.m(op);
                self.cpu.r[14] = self.cpu.pc | 1;
                return self.interwork(target);
            }
            Kind::BranchReg => return self.interwork(self.m(op)),
            Kind::BranchZero => {
                if self.n(op) == 0 {
                    self.jump(op.imm);
                }
            }
            Kind::BranchNotZero => {
                if self.n(op) != 0 {
                    self.jump(op.imm);
                }
            }
            Kind::MovPc => self.jump(self.m(op)),
            Kind::AddPc => self.jump(self.n(op).wrapping_add(self.m(op))),
            Kind::IfThen => self.cpu.it = op.imm as u8,
            Kind::Nop | Kind::Barrier => {}
            Kind::Uxtb if op.rn == 15 => {
                let turned = self.m(op).rotate_right(op.imm);
                self.cpu.set(op.rd, turned & 0xff);
            }
            Kind::Ubfx => {
                let mask = ((1u64 << op.s) - 1) as u32;
                self.cpu.set(op.rd, self.n(op) >> op.imm & mask);
            }
            Kind::Ldr => return self.load_to::<4>(op, self.offset(op), |word| word),
            Kind::Ldrb => return self.load_to::<1>(op, self.offset(op), |byte| byte),
            Kind::Ldrh => return self.load_to::<2>(op, self.offset(op), |half| half),
            Kind::Ldrsb => return self.load_to::<1>(op, self.offset(op), |b| b as i8 as u32),
            Kind::Ldrsh => return self.load_to::<2>(op, self.offset(op), |h| h as i16 as u32),
            Kind::LdrR => return self.load_to::<4>(op, self.indexed(op), |word| word),
            Kind::LdrbR => return self.load_to::<1>(op, self.indexed(op), |byte| byte),
            Kind::LdrhR => return self.load_to::<2>(op, self.indexed(op), |half| half),
            Kind::LdrsbR => return self.load_to::<1>(op, self.indexed(op), |b| b as i8 as u32),
            Kind::LdrshR => return self.load_to::<2>(op, self.indexed(op), |h| h as i16 as u32),
            Kind::Str => return self.store::<4>(self.offset(op), self.d(op)),
            Kind::Strb => return self.store::<1>(self.offset(op), self.d(op)),
            Kind::Strh => return self.store::<2>(self.offset(op), self.d(op)),
            Kind::StrR => return self.store::<4>(self.indexed(op), self.d(op)),
            Kind::StrbR => return self.store::<1>(self.indexed(op), self.d(op)),
            Kind::StrhR => return self.store::<2>(self.indexed(op), self.d(op)),
            Kind::LoadMany => return self.load_many(&copy(op)),
            Kind::StoreMany => return self.store_many(&copy(op)),
            Kind::LoadIndexed => return self.load_indexed(op),
            Kind::StoreIndexed => return self.store_indexed(op),
            Kind::LoadPair => return self.load_pair(op),
            Kind::StorePair => return self.store_pair(op),
            Kind::Vldr => return self.load_float(op),
            Kind::Vstr => return self.store_float_registers(op),
            Kind::Vadd => return self.float_of_two(op, |x, y| x + y),
            Kind::Vsub => return self.float_of_two(op, |x, y| x - y),
            Kind::Vmul => return self.float_of_two(op, |x, y| x * y),
            Kind::Vmov => {
                self.prepare_float()?;
                self.cpu.s[usize::from(op.rd & 31)] = self.cpu.s[usize::from(op.rm & 31)];
            }
            Kind::VmovToCore => {
                self.prepare_float()?;
                self.cpu.set(op.rd, self.cpu.s[usize::from(op.rn & 31)]);
            }
            Kind::VmovFromCore => {
                self.prepare_float()?;
                self.cpu.s[usize::from(op.rd & 31)] = self.cpu.r[usize::from(op.rn & 15)];
            }
            Kind::NotDecoded | Kind::Undefined => return Err(Trap::Fault(Fault::Undefined)),
            Kind::Mls
            | Kind::Smull
            | Kind::Smlal
            | Kind::Umaal
            | Kind::Sdiv
            | Kind::Udiv
            | Kind::SmulHalf
            | Kind::SmlaHalf
            | Kind::SmulWide
            | Kind::SmlalHalf
            | Kind::SmulDual
            | Kind::SmlalDual
            | Kind::MulHigh
            | Kind::SumDiff
            | Kind::Sxtb
            | Kind::Sxth
            | Kind::Uxtb
            | Kind::Uxth
            | Kind::Sxtb16
            | Kind::Uxtb16
            | Kind::Rev
            | Kind::Rev16
            | Kind::Revsh
            | Kind::Rbit
            | Kind::Clz
            | Kind::Sel
            | Kind::Bfi
            | Kind::Sbfx
            | Kind::Ssat
            | Kind::Usat
            | Kind::Ssat16
            | Kind::Usat16
            | Kind::PackBt
            | Kind::PackTb
            | Kind::Parallel
            | Kind::Saturating => return self.execute_more(&copy(op)),
            Kind::LdrLiteral
            | Kind::LoadExclusive
            | Kind::StoreExclusive
            | Kind::ClearExclusive
            | Kind::TableByte
            | Kind::TableHalf
            | Kind::Mrs
            | Kind::Msr
            | Kind::Cps
            | Kind::Svc
            | Kind::Breakpoint
            | Kind::WaitInterrupt
            | Kind::WaitEvent
            | Kind::SendEvent => return self.execute_rare(&copy(op)),
            _ => return self.execute_float(&copy(op)),
        }
        Ok(())
    }
}
