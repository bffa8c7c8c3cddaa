//! Instructions on the general registers, and branches.

use super::arithmetic::{add, saturate_signed, saturate_unsigned, shift};
use super::op::{Kind, Op};
use super::{Fault, Trap, Try, dsp};
use crate::machine::Machine;

impl Machine {
    /// Whether this instruction sets the flags.
    #[inline(always)]
    fn sets(&self, op: &Op) -> bool {
        op.s == 1 || (op.s == 2 && self.cpu.it_now == 0)
    }

    #[inline(always)]
    pub(super) fn n(&self, op: &Op) -> u32 {
        self.cpu.r[usize::from(op.rn & 15)]
    }

    #[inline(always)]
    pub(super) fn m(&self, op: &Op) -> u32 {
        self.cpu.r[usize::from(op.rm & 15)]
    }

    /// What the destination holds.
    #[inline(always)]
    pub(super) fn d(&self, op: &Op) -> u32 {
        self.cpu.r[usize::from(op.rd & 15)]
    }

    /// What the fourth register holds.
    #[inline(always)]
    pub(super) fn a(&self, op: &Op) -> u32 {
        self.cpu.r[usize::from(op.ra & 15)]
    }

    /// The second operand, shifted, and the shifter's carry.
    #[inline(always)]
    pub(super) fn shifted(&self, op: &Op) -> (u32, bool) {
        let value = self.m(op);
        if op.imm == 0 {
            (value, self.cpu.c)
        } else {
            shift(u32::from(op.ra), value, op.imm, self.cpu.c)
        }
    }

    /// A constant operand and its carry.
    #[inline(always)]
    fn constant(&self, op: &Op) -> (u32, bool) {
        let carry = if op.ra == 1 {
            op.imm >> 31 == 1
        } else {
            self.cpu.c
        };
        (op.imm, carry)
    }

    #[inline(always)]
    pub(super) fn logical(&mut self, op: &Op, value: u32, carry: bool) {
        if self.sets(op) {
            self.cpu.n = value >> 31 == 1;
            self.cpu.z = value == 0;
            self.cpu.c = carry;
        }
        self.cpu.set(op.rd, value);
    }

    #[inline(always)]
    pub(super) fn flags(&mut self, (value, carry, overflow): (u32, bool, bool)) {
        self.cpu.n = value >> 31 == 1;
        self.cpu.z = value == 0;
        self.cpu.c = carry;
        self.cpu.v = overflow;
    }

    #[inline(always)]
    pub(super) fn sum(&mut self, op: &Op, a: u32, b: u32, carry: bool) {
        let sum = add(a, b, carry);
        if self.sets(op) {
            self.flags(sum);
        }
        self.cpu.set(op.rd, sum.0);
    }

    #[inline(always)]
    fn test(&mut self, value: u32, carry: bool) {
        self.cpu.n = value >> 31 == 1;
        self.cpu.z = value == 0;
        self.cpu.c = carry;
    }

    /// Goes on at `target`, which takes the pipeline time to fill.
    #[inline(always)]
    pub(super) fn jump(&mut self, target: u32) {
        self.cpu.pc = target & !1;
        self.spend(2);
    }

    /// A branch to an address that says by bit 0 that it is Thumb, or an exception's return.
    pub(crate) fn interwork(&mut self, target: u32) -> Try {
        if self.cpu.ipsr != 0 && target >= 0xf000_0000 {
            return self.leave_exception(target);
        }
        if target & 1 == 0 {
            // The state changes at once, and the fault comes with the next instruction, at the target.
            self.cpu.pc = target;
            return Err(Trap::Fault(Fault::State));
        }
        self.jump(target);
        Ok(())
    }

    /// Register and constant, and what comes of them.
    #[inline(always)]
    pub(super) fn with_constant(&mut self, op: &Op, f: impl Fn(u32, u32) -> u32) {
        let (b, carry) = self.constant(op);
        self.logical(op, f(self.n(op), b), carry);
    }

    /// First operand and shifted register, and what comes of them.
    #[inline(always)]
    pub(super) fn with_shifted(&mut self, op: &Op, f: impl Fn(u32, u32) -> u32) {
        let (b, carry) = self.shifted(op);
        self.logical(op, f(self.n(op), b), carry);
    }

    #[inline(always)]
    pub(super) fn test_constant(&mut self, op: &Op, f: impl Fn(u32, u32) -> u32) {
        let (b, carry) = self.constant(op);
        self.test(f(self.n(op), b), carry);
    }

    #[inline(always)]
    pub(super) fn test_shifted(&mut self, op: &Op, f: impl Fn(u32, u32) -> u32) {
        let (b, carry) = self.shifted(op);
        self.test(f(self.n(op), b), carry);
    }

    #[inline(always)]
    pub(super) fn shift_by_register(&mut self, op: &Op, kind: u32) {
        let (value, carry) = shift(kind, self.n(op), self.m(op) & 0xff, self.cpu.c);
        self.logical(op, value, carry);
    }

    /// Products, divisions, fields, saturation.
    #[inline(never)]
    pub(super) fn execute_more(&mut self, op: &Op) -> Try {
        let (n, m) = (self.n(op), self.m(op));
        let a = self.cpu.r[usize::from(op.ra & 15)];
        let wide = |signed: bool| {
            if signed {
                (i64::from(n as i32) * i64::from(m as i32)) as u64
            } else {
                u64::from(n) * u64::from(m)
            }
        };
        match op.kind {
            Kind::Mls => self.cpu.set(op.rd, a.wrapping_sub(n.wrapping_mul(m))),
            Kind::Smull => self.long(op, wide(true)),
            Kind::Smlal => {
                let before = u64::from(a) << 32 | u64::from(self.cpu.r[usize::from(op.rd)]);
                self.long(op, before.wrapping_add(wide(true)));
            }
            Kind::Umaal => {
                let sum = wide(false) + u64::from(a) + u64::from(self.cpu.r[usize::from(op.rd)]);
                self.long(op, sum);
            }
            Kind::Sdiv | Kind::Udiv => {
                if m == 0 && self.system.faults_on_zero() {
                    return Err(Trap::Fault(Fault::DivideByZero));
                }
                let value = match (m, op.kind) {
                    (0, _) => 0,
                    (_, Kind::Sdiv) => (n as i32).wrapping_div(m as i32) as u32,
                    _ => n / m,
                };
                self.cpu.set(op.rd, value);
            }
            Kind::Sxtb | Kind::Sxth | Kind::Uxtb | Kind::Uxth | Kind::Sxtb16 | Kind::Uxtb16 => {
                self.extend(op, n, m.rotate_right(op.imm));
            }
            Kind::Rev => self.cpu.set(op.rd, m.swap_bytes()),
            Kind::Rev16 => self.cpu.set(op.rd, m.swap_bytes().rotate_left(16)),
            Kind::Revsh => self.cpu.set(op.rd, (m as u16).swap_bytes() as i16 as u32),
            Kind::Rbit => self.cpu.set(op.rd, m.reverse_bits()),
            Kind::Clz => self.cpu.set(op.rd, m.leading_zeros()),
            Kind::Sel => {
                let pick =
                    |i: u32| if self.cpu.ge >> i & 1 == 1 { n } else { m } & (0xff << (8 * i));
                let value = (0..4).map(pick).fold(0, |all, byte| all | byte);
                self.cpu.set(op.rd, value);
            }
            Kind::Bfi => {
                let mask = ((1u64 << op.s) - 1) as u32;
                let field = if op.rn == 15 { 0 } else { n & mask };
                let before = self.cpu.r[usize::from(op.rd)] & !(mask << op.imm);
                self.cpu.set(op.rd, before | field << op.imm);
            }
            Kind::Sbfx => {
                let up = 32u32.saturating_sub(op.imm + u32::from(op.s));
                let value = ((n << up) as i32 >> (32 - u32::from(op.s))) as u32;
                self.cpu.set(op.rd, value);
            }
            Kind::Ssat | Kind::Usat => {
                let amount = if op.ra == 2 && op.s == 0 {
                    31
                } else {
                    u32::from(op.s)
                };
                let value = i64::from(shift(u32::from(op.ra), n, amount, false).0 as i32);
                let (held, changed) = if op.kind == Kind::Ssat {
                    let (held, changed) = saturate_signed(value, op.imm);
                    (held as u32, changed)
                } else {
                    saturate_unsigned(value, op.imm)
                };
                self.cpu.q |= changed;
                self.cpu.set(op.rd, held);
            }
            Kind::Ssat16 | Kind::Usat16 => self.saturate_halves(op, n),
            Kind::PackBt => {
                let value = n & 0xffff | self.shifted(op).0 & 0xffff_0000;
                self.cpu.set(op.rd, value);
            }
            Kind::PackTb => {
                let value = n & 0xffff_0000 | self.shifted(op).0 & 0xffff;
                self.cpu.set(op.rd, value);
            }
            _ => dsp::execute(&mut self.cpu, op),
        }
        Ok(())
    }

    #[inline(always)]
    pub(super) fn long(&mut self, op: &Op, value: u64) {
        self.cpu.set(op.rd, value as u32);
        self.cpu.set(op.ra, (value >> 32) as u32);
    }

    fn extend(&mut self, op: &Op, n: u32, turned: u32) {
        let base = if op.rn == 15 { 0 } else { n };
        let halves = |low: u32, high: u32| {
            base.wrapping_add(low) & 0xffff | (base >> 16).wrapping_add(high) << 16
        };
        let value = match op.kind {
            Kind::Sxtb => base.wrapping_add(turned as i8 as u32),
            Kind::Sxth => base.wrapping_add(turned as i16 as u32),
            Kind::Uxtb => base.wrapping_add(turned & 0xff),
            Kind::Uxth => base.wrapping_add(turned & 0xffff),
            Kind::Sxtb16 => halves(turned as i8 as u32, (turned >> 16) as i8 as u32),
            _ => halves(turned & 0xff, turned >> 16 & 0xff),
        };
        self.cpu.set(op.rd, value);
    }

    fn saturate_halves(&mut self, op: &Op, n: u32) {
        let held = [n, n >> 16].map(|half| {
            let value = i64::from(half as u16 as i16);
            if op.kind == Kind::Ssat16 {
                let (held, changed) = saturate_signed(value, op.imm);
                (held as u32 & 0xffff, changed)
            } else {
                saturate_unsigned(value, op.imm)
            }
        });
        self.cpu.q |= held[0].1 | held[1].1;
        self.cpu.set(op.rd, held[0].0 | held[1].0 << 16);
    }
}
