//! Instructions of 32 bits without floating point (ARMv7-M Architecture Reference Manual, A5.3).

use super::decode_fp;
use super::decode16::{hint, plain};
use super::op::{Kind, Op, mode, shift, width};

fn op(kind: Kind) -> Op {
    Op::new(kind, 4)
}

fn undefined(a: u32, b: u32) -> Op {
    op(Kind::Undefined).imm(a << 16 | b)
}

/// Decodes the instruction of the half words `a` and `b` at `pc`. What has a bit other than the manual writes in brackets,
/// "(0)" or "(1)", is refused like one that does not exist.
pub fn decode(pc: u32, a: u32, b: u32) -> Op {
    match (a >> 11 & 3, a >> 4 & 0x7f) {
        (1, op2) if op2 & 0x64 == 0 => many(a, b),
        (1, op2) if op2 & 0x64 == 4 => pair_or_table(a, b),
        (1, op2) if op2 & 0x60 == 0x20 => shifted_register(a, b),
        (1 | 3, op2) if op2 & 0x40 != 0 => decode_fp::decode(a, b),
        (2, _) if b >> 15 == 1 => branch(pc, a, b),
        (2, op2) if op2 & 0x20 == 0 => modified_immediate(a, b),
        (2, _) => plain_immediate(pc, a, b),
        (3, op2) if op2 & 0x71 == 0 || op2 & 0x67 == 1 || op2 & 0x67 == 3 || op2 & 0x67 == 5 => {
            single(pc, a, b)
        }
        (3, op2) if op2 & 0x70 == 0x20 => register(a, b),
        (3, op2) if op2 & 0x78 == 0x30 => multiply(a, b),
        (3, op2) if op2 & 0x78 == 0x38 => long_multiply(a, b),
        _ => undefined(a, b),
    }
}

fn many(a: u32, b: u32) -> Op {
    let (n, load, back) = (a & 15, a >> 4 & 1 == 1, a >> 5 & 1);
    let before = match a >> 7 & 3 {
        1 => 0,
        2 => mode::BEFORE,
        _ => return undefined(a, b),
    };
    let (kind, brackets) = if load {
        (Kind::LoadMany, 0x2000)
    } else {
        (Kind::StoreMany, 0xa000)
    };
    if b & brackets != 0 {
        return undefined(a, b);
    }
    op(kind)
        .regs(0, n, 0)
        .imm(b)
        .ra(before | (back * mode::WRITE_BACK))
        .cost(1 + b.count_ones())
}

fn pair_or_table(a: u32, b: u32) -> Op {
    let (n, t, t2, imm) = (a & 15, b >> 12, b >> 8 & 15, (b & 0xff) * 4);
    let (p, u, w, load) = (a >> 8 & 1, a >> 7 & 1, a >> 5 & 1, a >> 4 & 1);
    if p == 0 && w == 0 {
        let size = match b >> 4 & 15 {
            4 => width::BYTE,
            5 => width::HALF,
            _ => width::WORD,
        };
        return match (u, load, b >> 4 & 15) {
            (0, 0, _) => op(Kind::StoreExclusive).regs(t, n, t2).imm(imm).cost(2),
            (0, 1, _) if t2 == 15 => op(Kind::LoadExclusive).regs(t, n, 0).imm(imm).cost(2),
            (1, 1, 0) if b >> 8 == 0xf0 => op(Kind::TableByte).regs(0, n, b & 15).cost(4),
            (1, 1, 1) if b >> 8 == 0xf0 => op(Kind::TableHalf).regs(0, n, b & 15).cost(4),
            (1, 0, 4 | 5) if t2 == 15 => {
                op(Kind::StoreExclusive).regs(t, n, b & 15).s(size).cost(2)
            }
            (1, 1, 4 | 5) if b & 0xf0f == 0xf0f => {
                op(Kind::LoadExclusive).regs(t, n, 0).s(size).cost(2)
            }
            _ => undefined(a, b),
        };
    }
    let kind = if load == 1 {
        Kind::LoadPair
    } else {
        Kind::StorePair
    };
    let imm = if u == 1 { imm } else { imm.wrapping_neg() };
    op(kind)
        .regs(t, n, 0)
        .s(t2)
        .imm(imm)
        .ra((p * mode::BEFORE) | (w * mode::WRITE_BACK))
        .cost(3)
}

/// The data operations by their number, with a constant and with a register; what a missing operand makes of them.
fn data(number: u32, n: u32, d: u32, s: u32) -> Option<(Kind, Kind)> {
    Some(match number {
        0 if d == 15 && s == 1 => (Kind::TstI, Kind::TstR),
        4 if d == 15 && s == 1 => (Kind::TeqI, Kind::TeqR),
        8 if d == 15 && s == 1 => (Kind::CmnI, Kind::CmnR),
        13 if d == 15 && s == 1 => (Kind::CmpI, Kind::CmpR),
        _ if d == 15 => return None,
        0 => (Kind::AndI, Kind::AndR),
        1 => (Kind::BicI, Kind::BicR),
        2 if n == 15 => (Kind::MovI, Kind::MovR),
        2 => (Kind::OrrI, Kind::OrrR),
        3 if n == 15 => (Kind::MvnI, Kind::MvnR),
        3 => (Kind::OrnI, Kind::OrnR),
        4 => (Kind::EorI, Kind::EorR),
        8 => (Kind::AddI, Kind::AddR),
        10 => (Kind::AdcI, Kind::AdcR),
        11 => (Kind::SbcI, Kind::SbcR),
        13 => (Kind::SubI, Kind::SubR),
        14 => (Kind::RsbI, Kind::RsbR),
        _ => return None,
    })
}

fn shifted_register(a: u32, b: u32) -> Op {
    let (n, d, m, s) = (a & 15, b >> 8 & 15, b & 15, a >> 4 & 1);
    let (amount, kind) = decode_shift(b >> 4 & 3, b >> 10 & 0x1c | b >> 6 & 3);
    let number = a >> 5 & 15;
    if b >> 15 == 1 {
        return undefined(a, b);
    }
    if number == 6 && s == 0 {
        let pack = if b >> 5 & 1 == 0 {
            Kind::PackBt
        } else {
            Kind::PackTb
        };
        return op(pack).regs(d, n, m).imm(amount).ra(kind);
    }
    match data(number, n, d, s) {
        Some((_, with)) => op(with).regs(d, n, m).imm(amount).ra(kind).s(s),
        None => undefined(a, b),
    }
}

/// Amount and kind of a shift by a constant.
fn decode_shift(kind: u32, amount: u32) -> (u32, u32) {
    match (kind, amount) {
        (shift::LSL, n) => (n, shift::LSL),
        (shift::ROR, 0) => (1, shift::RRX),
        (shift::ROR, n) => (n, shift::ROR),
        (kind, 0) => (32, kind),
        (kind, n) => (n, kind),
    }
}

/// A constant of 12 bits as Thumb writes it, and whether the carry becomes its top bit.
pub fn expand(imm12: u32) -> (u32, bool) {
    let byte = imm12 & 0xff;
    match imm12 >> 8 {
        0 => (byte, false),
        1 => (byte << 16 | byte, false),
        2 => (byte << 24 | byte << 8, false),
        3 => (byte * 0x0101_0101, false),
        _ => ((0x80 | imm12 & 0x7f).rotate_right(imm12 >> 7), true),
    }
}

fn modified_immediate(a: u32, b: u32) -> Op {
    let (n, d, s) = (a & 15, b >> 8 & 15, a >> 4 & 1);
    let (value, carry) = expand((a >> 10 & 1) << 11 | (b >> 12 & 7) << 8 | b & 0xff);
    match data(a >> 5 & 15, n, d, s) {
        Some((with, _)) => op(with).regs(d, n, 0).imm(value).ra(u32::from(carry)).s(s),
        None => undefined(a, b),
    }
}

fn plain_immediate(pc: u32, a: u32, b: u32) -> Op {
    let (n, d) = (a & 15, b >> 8 & 15);
    let imm12 = (a >> 10 & 1) << 11 | (b >> 12 & 7) << 8 | b & 0xff;
    let imm16 = n << 12 | imm12;
    let (low, wide) = (b >> 10 & 0x1c | b >> 6 & 3, b & 0x1f);
    let here = pc.wrapping_add(4) & !3;
    let sh = if a >> 5 & 1 == 1 {
        shift::ASR
    } else {
        shift::LSL
    };
    // Saturations and bit fields.
    if a >> 8 & 1 == 1 && (a >> 10 & 1 == 1 || b >> 5 & 1 == 1) {
        return undefined(a, b);
    }
    match a >> 4 & 0x1f {
        0 if n == 15 => op(Kind::MovI).regs(d, 0, 0).imm(here.wrapping_add(imm12)),
        0 => op(Kind::AddI).regs(d, n, 0).imm(imm12),
        4 => op(Kind::MovI).regs(d, 0, 0).imm(imm16),
        10 if n == 15 => op(Kind::MovI).regs(d, 0, 0).imm(here.wrapping_sub(imm12)),
        10 => op(Kind::SubI).regs(d, n, 0).imm(imm12),
        12 => op(Kind::Movt).regs(d, 0, 0).imm(imm16),
        18 if low == 0 && b >> 4 & 1 == 0 => op(Kind::Ssat16).regs(d, n, 0).imm((b & 15) + 1),
        16 | 18 => op(Kind::Ssat).regs(d, n, 0).imm(wide + 1).s(low).ra(sh),
        20 => op(Kind::Sbfx).regs(d, n, 0).imm(low).s(wide + 1),
        22 if wide >= low => op(Kind::Bfi).regs(d, n, 0).imm(low).s(wide - low + 1),
        26 if low == 0 && b >> 4 & 1 == 0 => op(Kind::Usat16).regs(d, n, 0).imm(b & 15),
        24 | 26 => op(Kind::Usat).regs(d, n, 0).imm(wide).s(low).ra(sh),
        28 => op(Kind::Ubfx).regs(d, n, 0).imm(low).s(wide + 1),
        _ => undefined(a, b),
    }
}

fn branch(pc: u32, a: u32, b: u32) -> Op {
    let (s, j1, j2) = (a >> 10 & 1, b >> 13 & 1, b >> 11 & 1);
    let sign = (s << 31) as i32;
    if b >> 12 & 5 == 0 {
        if a >> 7 & 7 != 7 {
            let offset =
                (sign >> 11) as u32 | j2 << 19 | j1 << 18 | (a & 0x3f) << 12 | (b & 0x7ff) << 1;
            return op(Kind::BranchIf)
                .regs(a >> 6 & 15, 0, 0)
                .imm(pc.wrapping_add(4).wrapping_add(offset));
        }
        return control(a, b);
    }
    let (i1, i2) = (1 ^ j1 ^ s, 1 ^ j2 ^ s);
    let offset = (sign >> 7) as u32 | i1 << 23 | i2 << 22 | (a & 0x3ff) << 12 | (b & 0x7ff) << 1;
    let kind = match b >> 12 & 5 {
        1 => Kind::Branch,
        5 => Kind::BranchLink,
        _ => return undefined(a, b),
    };
    op(kind).imm(pc.wrapping_add(4).wrapping_add(offset))
}

fn control(a: u32, b: u32) -> Op {
    match a >> 4 & 0x7f {
        0x38 if b & 0x2300 == 0 => op(Kind::Msr)
            .regs(0, a & 15, 0)
            .imm(b & 0xff)
            .ra(b >> 10 & 3)
            .cost(2),
        0x3a if a & 15 == 15 && b & 0x2f00 == 0 => hint(b & 0xff, 4),
        0x3b if a & 15 == 15 && b & 0x2f00 == 0x0f00 => match b >> 4 & 15 {
            2 if b & 15 == 15 => op(Kind::ClearExclusive),
            4..=6 => op(Kind::Barrier),
            _ => undefined(a, b),
        },
        0x3e if a & 15 == 15 && b & 0x2000 == 0 => {
            op(Kind::Mrs).regs(b >> 8 & 15, 0, 0).imm(b & 0xff).cost(2)
        }
        _ => undefined(a, b),
    }
}

/// Loads and stores of one register.
fn single(pc: u32, a: u32, b: u32) -> Op {
    let (n, t) = (a & 15, b >> 12);
    let (load, signed, size) = (a >> 4 & 1 == 1, a >> 8 & 1 == 1, a >> 5 & 3);
    if size == 3 || (!load && (signed || n == 15)) {
        return undefined(a, b);
    }
    let (kind, with, width) = plain(load, signed, size);
    // A load of a byte or half word to the program counter is a hint to a cache: nothing.
    if load && t == 15 && size != 2 {
        return op(Kind::Nop);
    }
    let cost = if load { 2 } else { 1 };
    let indexed = if load {
        Kind::LoadIndexed
    } else {
        Kind::StoreIndexed
    };
    let to_pc = load && t == 15;
    let constant = |imm: u32| {
        if to_pc {
            op(indexed)
                .regs(t, n, 0)
                .imm(imm)
                .ra(mode::BEFORE)
                .s(width)
                .cost(4)
        } else {
            op(kind).regs(t, n, 0).imm(imm).cost(cost)
        }
    };
    if n == 15 {
        let offset = if a >> 7 & 1 == 1 {
            b & 0xfff
        } else {
            (b & 0xfff).wrapping_neg()
        };
        return op(Kind::LdrLiteral)
            .regs(t, 15, 0)
            .imm((pc.wrapping_add(4) & !3).wrapping_add(offset))
            .s(width)
            .cost(cost);
    }
    if a >> 7 & 1 == 1 {
        return constant(b & 0xfff);
    }
    let (p, u, w, imm8) = (b >> 10 & 1, b >> 9 & 1, b >> 8 & 1, b & 0xff);
    if b >> 11 & 1 == 1 {
        let offset = if u == 1 { imm8 } else { imm8.wrapping_neg() };
        // P, U without W is the unprivileged form, which here is a plain one.
        return match (p, w) {
            (1, 0) => constant(offset),
            (0, 0) => undefined(a, b),
            _ => op(indexed)
                .regs(t, n, 0)
                .imm(offset)
                .ra((p * mode::BEFORE) | mode::WRITE_BACK)
                .s(width)
                .cost(cost + if to_pc { 2 } else { 0 }),
        };
    }
    if b >> 6 & 0x3f != 0 {
        return undefined(a, b);
    }
    if to_pc {
        // Marked by a destination of 15.
        return op(Kind::LdrR).regs(15, n, b & 15).imm(b >> 4 & 3).cost(4);
    }
    op(with).regs(t, n, b & 15).imm(b >> 4 & 3).cost(cost)
}

/// Data operations on registers: shifts, extensions, parallel and saturating arithmetic, and bits.
fn register(a: u32, b: u32) -> Op {
    let (n, d, m) = (a & 15, b >> 8 & 15, b & 15);
    let (op1, op2) = (a >> 4 & 15, b >> 4 & 15);
    if b >> 12 != 15 {
        return undefined(a, b);
    }
    if op2 == 0 && op1 < 8 {
        let kind = [Kind::Lsl, Kind::Lsr, Kind::Asr, Kind::Ror][(op1 >> 1) as usize];
        return op(kind).regs(d, n, m).s(op1 & 1);
    }
    if op2 & 12 == 8 && op1 < 6 {
        let kind = [
            Kind::Sxth,
            Kind::Uxth,
            Kind::Sxtb16,
            Kind::Uxtb16,
            Kind::Sxtb,
            Kind::Uxtb,
        ][op1 as usize];
        return op(kind).regs(d, n, m).imm((op2 & 3) * 8);
    }
    if op1 & 8 == 8 && op2 < 8 {
        return op(Kind::Parallel).regs(d, n, m).imm(op1 & 7).ra(op2);
    }
    let kind = match (op1, op2) {
        (8, 8..=11) => return op(Kind::Saturating).regs(d, n, m).imm(op2 & 3),
        (9, 8) => Kind::Rev,
        (9, 9) => Kind::Rev16,
        (9, 10) => Kind::Rbit,
        (9, 11) => Kind::Revsh,
        (10, 8) => Kind::Sel,
        (11, 8) => Kind::Clz,
        _ => return undefined(a, b),
    };
    op(kind).regs(d, n, m)
}

fn multiply(a: u32, b: u32) -> Op {
    let (n, t, d, m) = (a & 15, b >> 12, b >> 8 & 15, b & 15);
    let (op1, op2) = (a >> 4 & 7, b >> 4 & 3);
    if b >> 6 & 3 != 0 {
        return undefined(a, b);
    }
    let with = |kind, imm| op(kind).regs(d, n, m).ra(t).imm(imm);
    match (op1, op2) {
        (0, 0) if t == 15 => op(Kind::Mul).regs(d, n, m),
        (0, 0) => with(Kind::Mla, 0).cost(2),
        (0, 1) => with(Kind::Mls, 0).cost(2),
        (1, half) if t == 15 => with(Kind::SmulHalf, half),
        (1, half) => with(Kind::SmlaHalf, half),
        // Dual products: bit 0 swaps halves, bit 1 subtracts.
        (2, 0 | 1) => with(Kind::SmulDual, op2),
        (3, 0 | 1) => with(Kind::SmulWide, op2),
        (4, 0 | 1) => with(Kind::SmulDual, op2 | 2),
        // Bit 0 rounds, bit 1 subtracts.
        (5, 0 | 1) => with(Kind::MulHigh, op2),
        (6, 0 | 1) => with(Kind::MulHigh, op2 | 2),
        (7, 0) => with(Kind::SumDiff, 0),
        _ => undefined(a, b),
    }
}

fn long_multiply(a: u32, b: u32) -> Op {
    let (n, low, high, m) = (a & 15, b >> 12, b >> 8 & 15, b & 15);
    let with = |kind, imm| op(kind).regs(low, n, m).ra(high).imm(imm);
    match (a >> 4 & 7, b >> 4 & 15) {
        (0, 0) => with(Kind::Smull, 0),
        (1, 15) if low == 15 => op(Kind::Sdiv).regs(high, n, m).cost(7),
        (2, 0) => with(Kind::Umull, 0),
        (3, 15) if low == 15 => op(Kind::Udiv).regs(high, n, m).cost(7),
        (4, 0) => with(Kind::Smlal, 0),
        (4, half @ 8..=11) => with(Kind::SmlalHalf, half & 3),
        (4, dual @ 12..=13) => with(Kind::SmlalDual, dual & 1),
        (5, dual @ 12..=13) => with(Kind::SmlalDual, dual & 1 | 2),
        (6, 0) => with(Kind::Umlal, 0),
        (6, 6) => with(Kind::Umaal, 0),
        _ => undefined(a, b),
    }
}
