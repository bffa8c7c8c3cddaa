//! Floating point. Rounding to nearest only, no flush to zero, and no cumulative exception flags: a program that asks
//! for the first two is stopped, and the flags read as 0.

use super::op::{Kind, Op, mode};
use super::{Fault, Trap, Try};
use crate::machine::Machine;

const DEFAULT_NAN: u32 = 0x7fc0_0000;
const QUIET: u32 = 0x0040_0000;
const SIGN: u32 = 0x8000_0000;

fn is_nan(bits: u32) -> bool {
    bits & !SIGN > 0x7f80_0000
}

fn is_signalling(bits: u32) -> bool {
    is_nan(bits) && bits & QUIET == 0
}

/// What an operation gives whose result is no number: the first signalling operand, else the first that is none.
fn nan_of(operands: &[u32]) -> u32 {
    let signalling = operands.iter().find(|bits| is_signalling(**bits));
    let quiet = operands.iter().find(|bits| is_nan(**bits));
    signalling
        .or(quiet)
        .map_or(DEFAULT_NAN, |bits| bits | QUIET)
}

#[inline(always)]
fn two(a: u32, b: u32, f: impl Fn(f32, f32) -> f32) -> u32 {
    let result = f(f32::from_bits(a), f32::from_bits(b));
    if result.is_nan() {
        nan_of(&[a, b])
    } else {
        result.to_bits()
    }
}

/// `addend + a · b`, rounded once.
fn fused(addend: u32, a: u32, b: u32) -> u32 {
    let result = f32::from_bits(a).mul_add(f32::from_bits(b), f32::from_bits(addend));
    if !result.is_nan() {
        return result.to_bits();
    }
    // Infinity times zero is invalid, whatever quiet operand is added to it.
    let product_invalid =
        (f32::from_bits(a) * f32::from_bits(b)).is_nan() && !is_nan(a) && !is_nan(b);
    if product_invalid && !is_signalling(addend) {
        return DEFAULT_NAN;
    }
    nan_of(&[addend, a, b])
}

impl Machine {
    /// To be called before each instruction on floating point: makes room for it, and says whether it is allowed.
    #[inline(always)]
    pub(super) fn prepare_float(&mut self) -> Try {
        if !self.system.float_enabled() {
            return Err(Trap::Fault(Fault::NoFloat));
        }
        if self.system.lazy {
            self.stack_lazily()?;
        }
        if self.cpu.control & 4 == 0 && self.system.automatic_state() {
            self.cpu.control |= 4;
            self.cpu.fpscr = self.system.default_status;
        }
        Ok(())
    }

    /// What a sum, a difference or a product is.
    #[inline(always)]
    pub(super) fn float_of_two(&mut self, op: &Op, f: impl Fn(f32, f32) -> f32) -> Try {
        self.prepare_float()?;
        let s = &mut self.cpu.s;
        let (a, b) = (s[usize::from(op.rn & 31)], s[usize::from(op.rm & 31)]);
        s[usize::from(op.rd & 31)] = two(a, b, f);
        Ok(())
    }

    /// All else that works on singles.
    #[inline(never)]
    pub(super) fn execute_float(&mut self, op: &Op) -> Try {
        self.prepare_float()?;
        let (d, n, m) = (usize::from(op.rd), usize::from(op.rn), usize::from(op.rm));
        let s = |machine: &Self, i: usize| machine.cpu.s[i & 31];
        let (a, b, was) = (s(self, n), s(self, m), s(self, d));
        self.cpu.s[d & 31] = match op.kind {
            Kind::Vnmul => two(a, b, |x, y| x * y) ^ SIGN,
            Kind::Vdiv => two(a, b, |x, y| x / y),
            Kind::Vmla => two(was, two(a, b, |x, y| x * y), |x, y| x + y),
            Kind::Vmls => two(was, two(a, b, |x, y| x * y) ^ SIGN, |x, y| x + y),
            Kind::Vnmla => two(was ^ SIGN, two(a, b, |x, y| x * y) ^ SIGN, |x, y| x + y),
            Kind::Vnmls => two(was ^ SIGN, two(a, b, |x, y| x * y), |x, y| x + y),
            Kind::Vfma => fused(was, a, b),
            Kind::Vfms => fused(was, a ^ SIGN, b),
            Kind::Vfnma => fused(was ^ SIGN, a ^ SIGN, b),
            Kind::Vfnms => fused(was ^ SIGN, a, b),
            Kind::VmovI => op.imm,
            Kind::Vabs => b & !SIGN,
            Kind::Vneg => b ^ SIGN,
            Kind::Vsqrt => {
                let root = f32::from_bits(b).sqrt();
                if root.is_nan() {
                    nan_of(&[b])
                } else {
                    root.to_bits()
                }
            }
            Kind::VfromInt if op.imm == 1 => (b as i32 as f32).to_bits(),
            Kind::VfromInt => (b as f32).to_bits(),
            Kind::VtoInt => {
                let value = f32::from_bits(b);
                let value = if op.imm & 2 == 0 {
                    value.round_ties_even()
                } else {
                    value
                };
                if op.imm & 1 == 1 {
                    value as i32 as u32
                } else {
                    value as u32
                }
            }
            Kind::Vfixed => fixed(was, op),
            _ => return self.move_float(op),
        };
        Ok(())
    }

    fn compare(&mut self, a: u32, b: u32) {
        let (x, y) = (f32::from_bits(a), f32::from_bits(b));
        let nzcv = match x.partial_cmp(&y) {
            Some(std::cmp::Ordering::Equal) => 6,
            Some(std::cmp::Ordering::Less) => 8,
            Some(std::cmp::Ordering::Greater) => 2,
            None => 3,
        };
        self.cpu.fpscr = self.cpu.fpscr & 0x0fff_ffff | nzcv << 28;
    }

    fn move_float(&mut self, op: &Op) -> Try {
        let (d, n, m) = (usize::from(op.rd), usize::from(op.rn), usize::from(op.rm));
        let base = self.cpu.r[n & 15];
        match op.kind {
            Kind::Vcmp => self.compare(self.cpu.s[d], self.cpu.s[m]),
            Kind::VcmpZero => self.compare(self.cpu.s[d], 0),
            Kind::VmovPair | Kind::VmovPairDouble => {
                if op.imm == 1 {
                    let (low, high) = (self.cpu.s[m], self.cpu.s[(m + 1) & 31]);
                    self.cpu.set(op.rd, low);
                    self.cpu.set(op.rn, high);
                } else {
                    self.cpu.s[m] = self.cpu.r[d];
                    self.cpu.s[(m + 1) & 31] = self.cpu.r[n];
                }
            }
            Kind::Vmrs if op.rd == 15 => self.cpu.set_float_flags(),
            Kind::Vmrs => self.cpu.set(op.rd, self.cpu.fpscr),
            Kind::Vmsr => {
                let value = self.cpu.r[d];
                if value & 0x03c0_0000 != 0 {
                    return Err(Trap::stop(format!(
                        "FPSCR {value:#010x}: rounding, flush to zero or default NaN are not modelled"
                    )));
                }
                self.cpu.fpscr = value & 0xf000_0000;
            }
            Kind::Vldm | Kind::Vstm => {
                let size = 4 * op.imm;
                let down = op.ra & mode::BEFORE as u8 != 0;
                let start = if down { base.wrapping_sub(size) } else { base };
                self.float_words(op, start, op.imm as usize, op.kind == Kind::Vldm)?;
                if op.ra & mode::WRITE_BACK as u8 != 0 {
                    self.cpu
                        .set(op.rn, if down { start } else { base.wrapping_add(size) });
                }
            }
            _ => return Err(Trap::stop(format!("{:?} is not modelled", op.kind))),
        }
        Ok(())
    }

    #[inline(always)]
    fn float_address(&self, op: &Op) -> u32 {
        let base = self.cpu.r[usize::from(op.rn & 15)];
        let base = if op.rn == 15 { base & !3 } else { base };
        base.wrapping_add(op.imm)
    }

    #[inline(always)]
    pub(super) fn load_float(&mut self, op: &Op) -> Try {
        self.prepare_float()?;
        self.float_words(op, self.float_address(op), usize::from(op.s), true)
    }

    #[inline(always)]
    pub(super) fn store_float_registers(&mut self, op: &Op) -> Try {
        self.prepare_float()?;
        self.float_words(op, self.float_address(op), usize::from(op.s), false)
    }

    #[inline(always)]
    fn float_words(&mut self, op: &Op, start: u32, count: usize, load: bool) -> Try {
        if start & 3 != 0 {
            return Err(Trap::Fault(Fault::Unaligned));
        }
        for i in 0..count {
            let address = start.wrapping_add(4 * i as u32);
            let register = (usize::from(op.rd) + i) & 31;
            if load {
                self.cpu.s[register] = self.load::<4>(address)?;
            } else {
                self.store::<4>(address, self.cpu.s[register])?;
            }
        }
        Ok(())
    }
}

/// Between a single and a fixed point number in the same register.
fn fixed(was: u32, op: &Op) -> u32 {
    let unsigned = op.ra & 2 != 0;
    let wide = op.ra & 4 != 0;
    let scale = 2f64.powi(op.imm as i32);
    if op.ra & 1 == 0 {
        let value = match (wide, unsigned) {
            (true, false) => f64::from(was as i32),
            (true, true) => f64::from(was),
            (false, false) => f64::from(was as i16),
            (false, true) => f64::from(was as u16),
        };
        return ((value / scale) as f32).to_bits();
    }
    let value = (f64::from(f32::from_bits(was)) * scale).trunc();
    match (wide, unsigned) {
        (true, false) => value as i32 as u32,
        (true, true) => value as u32,
        (false, false) => value as i16 as u32,
        (false, true) => u32::from(value as u16),
    }
}

impl super::Cpu {
    /// Copies the flags of a comparison.
    fn set_float_flags(&mut self) {
        let flags = self.fpscr;
        self.n = flags >> 31 & 1 == 1;
        self.z = flags >> 30 & 1 == 1;
        self.c = flags >> 29 & 1 == 1;
        self.v = flags >> 28 & 1 == 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_comes_out_as_arm_has_it() {
        let signalling = 0x7f80_0001;
        let quiet = 0xffc0_1234;
        assert_eq!(two(quiet, signalling, |x, y| x + y), signalling | QUIET);
        assert_eq!(two(quiet, 0, |x, y| x * y), quiet);
        let infinite = f32::INFINITY.to_bits();
        assert_eq!(two(infinite, infinite | SIGN, |x, y| x + y), DEFAULT_NAN);
        assert_eq!(fused(quiet, infinite, 0), DEFAULT_NAN);
    }

    #[test]
    fn the_fused_product_is_rounded_once() {
        let a = 1.0 + 3.0 * f32::EPSILON;
        let apart = a * a - 1.0;
        let once = f32::from_bits(fused((-1f32).to_bits(), a.to_bits(), a.to_bits()));
        assert!(once != apart);
        let exact = f64::from(a) * f64::from(a) - 1.0;
        assert_eq!(once, exact as f32);
    }
}
