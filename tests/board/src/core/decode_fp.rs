//! Floating point of one precision (ARMv7-M Architecture Reference Manual, A6): FPv4-SP.
//!
//! Registers are numbered as singles; `D` registers by their first single.

use super::op::{Kind, Op, mode};

fn op(kind: Kind) -> Op {
    Op::new(kind, 4)
}

fn undefined(a: u32, b: u32) -> Op {
    op(Kind::Undefined).imm(a << 16 | b)
}

/// Decodes an instruction of coprocessor 10 or 11.
pub fn decode(a: u32, b: u32) -> Op {
    if !matches!(b >> 8 & 15, 10 | 11) || a >> 12 & 1 == 1 {
        return undefined(a, b);
    }
    match (a >> 8 & 15, b >> 4 & 1) {
        (14, 0) if b >> 8 & 1 == 0 => data(a, b),
        (14, 1) => transfer(a, b),
        (12 | 13, _) => memory(a, b),
        _ => undefined(a, b),
    }
}

fn data(a: u32, b: u32) -> Op {
    let d = (b >> 12) * 2 + (a >> 6 & 1);
    let n = (a & 15) * 2 + (b >> 7 & 1);
    let m = (b & 15) * 2 + (b >> 5 & 1);
    let kind = match (a >> 4 & 0xb, b >> 6 & 1) {
        (0, 0) => (Kind::Vmla, 3),
        (0, _) => (Kind::Vmls, 3),
        (1, 0) => (Kind::Vnmls, 3),
        (1, _) => (Kind::Vnmla, 3),
        (2, 0) => (Kind::Vmul, 1),
        (2, _) => (Kind::Vnmul, 1),
        (3, 0) => (Kind::Vadd, 1),
        (3, _) => (Kind::Vsub, 1),
        (8, 0) => (Kind::Vdiv, 14),
        (9, 0) => (Kind::Vfnms, 3),
        (9, _) => (Kind::Vfnma, 3),
        (10, 0) => (Kind::Vfma, 3),
        (10, _) => (Kind::Vfms, 3),
        (11, _) => return other(a, b, d, m),
        _ => return undefined(a, b),
    };
    op(kind.0).regs(d, n, m).cost(kind.1)
}

fn other(a: u32, b: u32, d: u32, m: u32) -> Op {
    let (opc2, opc3) = (a & 15, b >> 6 & 3);
    if opc3 & 1 == 0 {
        if b & 0xa0 != 0 {
            return undefined(a, b);
        }
        return op(Kind::VmovI)
            .regs(d, 0, 0)
            .imm(expand(opc2 << 4 | b & 15));
    }
    let with = |kind| op(kind).regs(d, 0, m);
    match (opc2, opc3) {
        (0, 1) => with(Kind::Vmov),
        (0, 3) => with(Kind::Vabs),
        (1, 1) => with(Kind::Vneg),
        (1, 3) => with(Kind::Vsqrt).cost(14),
        (4, _) => with(Kind::Vcmp),
        (5, _) if b & 0x2f == 0 => with(Kind::VcmpZero),
        (8, _) => with(Kind::VfromInt).imm(b >> 7 & 1),
        // Bit 0: signed; bit 1: towards zero.
        (12 | 13, _) => with(Kind::VtoInt).imm(opc2 & 1 | (b >> 7 & 1) << 1),
        (10 | 11 | 14 | 15, _) => {
            let size: u32 = if b >> 7 & 1 == 1 { 32 } else { 16 };
            let fraction = size.wrapping_sub((b & 15) << 1 | b >> 5 & 1);
            // To fixed point, unsigned, of 32 bits.
            let mode = (opc2 >> 2 & 1) | (opc2 & 1) << 1 | (b >> 7 & 1) << 2;
            op(Kind::Vfixed).regs(d, 0, d).imm(fraction).ra(mode)
        }
        _ => undefined(a, b),
    }
}

/// A constant of 8 bits as a single.
fn expand(imm: u32) -> u32 {
    let exponent = if imm >> 6 & 1 == 1 { 0x1f } else { 0x20 };
    (imm >> 7) << 31 | exponent << 25 | (imm & 0x3f) << 19
}

/// Between the core's registers and those of the floating point.
fn transfer(a: u32, b: u32) -> Op {
    let (n, t) = ((a & 15) * 2 + (b >> 7 & 1), b >> 12);
    let double = b >> 8 & 1 == 1;
    // There are 16 doubles, and what the manual writes in brackets is 0.
    let brackets = if double { 0x8f } else { 0x6f };
    if b & brackets != 0 || a >> 7 & 1 == 1 && b & 0x80 != 0 {
        return undefined(a, b);
    }
    match (a >> 5 & 7, a >> 4 & 1) {
        (0, 0) if !double => op(Kind::VmovFromCore).regs(n, t, 0),
        (0, 1) if !double => op(Kind::VmovToCore).regs(t, n, 0),
        // Half of a double: bit 5 says which.
        (half @ 0..=1, 0) if double && b >> 5 & 3 == 0 => {
            op(Kind::VmovFromCore).regs(2 * (a & 15) + half, t, 0)
        }
        (half @ 0..=1, 1) if double && b >> 5 & 3 == 0 => {
            op(Kind::VmovToCore).regs(t, 2 * (a & 15) + half, 0)
        }
        (7, 0) if a & 15 == 1 => op(Kind::Vmsr).regs(t, 0, 0),
        (7, 1) if a & 15 == 1 => op(Kind::Vmrs).regs(t, 0, 0),
        _ => undefined(a, b),
    }
}

/// Loads and stores, and moves of two registers.
fn memory(a: u32, b: u32) -> Op {
    let (p, u, extra, w, load) = (a >> 8 & 1, a >> 7 & 1, a >> 6 & 1, a >> 5 & 1, a >> 4 & 1);
    let n = a & 15;
    let double = b >> 8 & 1 == 1;
    if p == 0 && u == 0 {
        if extra == 0 || w == 1 || b & 0xd0 != 0x10 || double && b & 0x20 != 0 {
            return undefined(a, b);
        }
        let kind = if double {
            Kind::VmovPairDouble
        } else {
            Kind::VmovPair
        };
        let m = (b & 15) * 2 + (b >> 5 & 1);
        // To the core where `imm` is 1.
        return op(kind).regs(b >> 12, n, m).imm(load).cost(2);
    }
    // d16 and those above are not there.
    if double && extra == 1 {
        return undefined(a, b);
    }
    let d = (b >> 12) * 2 + extra;
    let words = b & 0xff;
    if p == 1 && w == 0 {
        let offset = if u == 1 {
            words * 4
        } else {
            (words * 4).wrapping_neg()
        };
        let kind = if load == 1 { Kind::Vldr } else { Kind::Vstr };
        let cost = if double { 3 } else { 2 };
        return op(kind)
            .regs(d, n, 0)
            .imm(offset)
            .s(u32::from(double) + 1)
            .cost(cost);
    }
    let kind = if load == 1 { Kind::Vldm } else { Kind::Vstm };
    let before = if p == 1 { mode::BEFORE } else { 0 };
    let words = if double { words & !1 } else { words };
    if words == 0 || d + words > 32 {
        return undefined(a, b);
    }
    op(kind)
        .regs(d, n, 0)
        .imm(words)
        .ra(before | (w * mode::WRITE_BACK))
        .cost(1 + words)
}
