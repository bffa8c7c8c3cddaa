//! Parallel arithmetic and products of half words (ARMv7-M Architecture Reference Manual, A5.3.14 to A5.3.16).

use super::Cpu;
use super::arithmetic::{half, saturate_signed, saturate_unsigned};
use super::op::{Kind, Op};

/// Does one of them.
pub fn execute(cpu: &mut Cpu, op: &Op) {
    let (n, m) = (cpu.r[usize::from(op.rn)], cpu.r[usize::from(op.rm)]);
    let a = cpu.r[usize::from(op.ra & 15)];
    let none = op.ra == 15;
    let added = if none { 0 } else { i64::from(a as i32) };
    let wide = |low: u32| (u64::from(a) << 32 | u64::from(low)) as i64;
    match op.kind {
        Kind::SmulHalf => cpu.set(op.rd, (half(n, op.imm >> 1) * half(m, op.imm & 1)) as u32),
        Kind::SmlaHalf => {
            let sum = half(n, op.imm >> 1) * half(m, op.imm & 1) + added;
            note(cpu, op.rd, sum);
        }
        Kind::SmulWide => {
            let sum = ((i64::from(n as i32) * half(m, op.imm)) >> 16) + added;
            note(cpu, op.rd, sum);
        }
        Kind::SmulDual => {
            let sum = dual(n, m, op.imm) + added;
            note(cpu, op.rd, sum);
        }
        Kind::SmlalHalf | Kind::SmlalDual => {
            let product = if op.kind == Kind::SmlalHalf {
                half(n, op.imm >> 1) * half(m, op.imm & 1)
            } else {
                dual(n, m, op.imm)
            };
            let sum = wide(cpu.r[usize::from(op.rd)]).wrapping_add(product);
            cpu.set(op.rd, sum as u32);
            cpu.set(op.ra, (sum >> 32) as u32);
        }
        Kind::MulHigh => {
            let product = i64::from(n as i32) * i64::from(m as i32);
            let base = if none { 0 } else { i64::from(a as i32) << 32 };
            let round = if op.imm & 1 == 1 { 0x8000_0000 } else { 0 };
            let sum = if op.imm & 2 == 0 {
                base.wrapping_add(product)
            } else {
                base.wrapping_sub(product)
            };
            cpu.set(op.rd, (sum.wrapping_add(round) >> 32) as u32);
        }
        Kind::SumDiff => {
            let sum: u32 = n
                .to_le_bytes()
                .iter()
                .zip(m.to_le_bytes())
                .map(|(x, y)| u32::from(x.abs_diff(y)))
                .sum();
            cpu.set(op.rd, sum.wrapping_add(if none { 0 } else { a }));
        }
        Kind::Saturating => {
            let (n, m) = (i64::from(n as i32), i64::from(m as i32));
            let (n, first) = if op.imm & 1 == 1 {
                saturate_signed(2 * n, 32)
            } else {
                (n as i32, false)
            };
            let sum = if op.imm & 2 == 0 {
                m + i64::from(n)
            } else {
                m - i64::from(n)
            };
            let (result, second) = saturate_signed(sum, 32);
            cpu.q |= first | second;
            cpu.set(op.rd, result as u32);
        }
        _ => parallel(cpu, op, n, m),
    }
}

fn note(cpu: &mut Cpu, d: u8, sum: i64) {
    cpu.q |= sum != i64::from(sum as i32);
    cpu.set(d, sum as u32);
}

/// Two products of halves, added or (bit 1) subtracted; bit 0 swaps the second operand's halves.
fn dual(n: u32, m: u32, how: u32) -> i64 {
    let m = if how & 1 == 1 { m.rotate_left(16) } else { m };
    let (low, high) = (half(n, 0) * half(m, 0), half(n, 1) * half(m, 1));
    if how & 2 == 0 { low + high } else { low - high }
}

/// Sums and differences of the halves or bytes of a word: `imm` which, `ra` how they end.
fn parallel(cpu: &mut Cpu, op: &Op, n: u32, m: u32) {
    let unsigned = op.ra & 4 != 0;
    let how = op.ra & 3;
    let bytes = op.imm & 3 == 0;
    let (count, bits) = if bytes { (4, 8) } else { (2, 16) };
    let mask = (1u32 << bits) - 1;
    let lane = |value: u32, i: u32| {
        let raw = value >> (i * bits) & mask;
        if unsigned {
            i64::from(raw)
        } else {
            i64::from((raw << (32 - bits)) as i32 >> (32 - bits))
        }
    };
    let (mut result, mut ge) = (0, 0);
    for i in 0..count {
        // 0 bytes added, 1 halves added, 2 crossed add-subtract, 4 bytes subtracted, 5 halves, 6 crossed.
        let (other, minus) = match op.imm {
            2 => (1 - i, i == 0),
            6 => (1 - i, i == 1),
            which => (i, which & 4 != 0),
        };
        let (x, y) = (lane(n, i), lane(m, other));
        let sum = if minus { x - y } else { x + y };
        let ok = match (unsigned, minus) {
            (true, false) => sum > i64::from(mask),
            _ => sum >= 0,
        };
        let value = match (how, unsigned) {
            (0, _) => sum as u32,
            (1, false) => saturate_signed(sum, bits).0 as u32,
            (1, true) => saturate_unsigned(sum, bits).0,
            _ => (sum >> 1) as u32,
        };
        result |= (value & mask) << (i * bits);
        if ok {
            ge |= if bytes { 1 } else { 3 } << (i * bits / 8);
        }
    }
    if how == 0 {
        cpu.ge = ge;
    }
    cpu.set(op.rd, result);
}
