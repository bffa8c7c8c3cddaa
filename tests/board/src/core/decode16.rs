//! Instructions of 16 bits (ARMv7-M Architecture Reference Manual, A5.2).

use super::op::{Kind, Op, mode, shift, width};

const LOW: u32 = 7;

/// Decodes the instruction `h` at `pc`.
pub fn decode(pc: u32, h: u32) -> Op {
    let op = |kind| Op::new(kind, 2);
    let undefined = op(Kind::Undefined).imm(h);
    let (r0, r3, r6, r8) = (h & LOW, h >> 3 & LOW, h >> 6 & LOW, h >> 8 & LOW);
    let imm8 = h & 0xff;
    let imm5 = h >> 6 & 0x1f;
    match h >> 11 {
        // Shift by a constant: a move with a shifted operand.
        0b00000 => op(Kind::MovR).regs(r0, 0, r3).imm(imm5).s(2),
        0b00001 => op(Kind::MovR)
            .regs(r0, 0, r3)
            .ra(shift::LSR)
            .imm(if imm5 == 0 { 32 } else { imm5 })
            .s(2),
        0b00010 => op(Kind::MovR)
            .regs(r0, 0, r3)
            .ra(shift::ASR)
            .imm(if imm5 == 0 { 32 } else { imm5 })
            .s(2),
        0b00011 => match h >> 9 & 3 {
            0 => op(Kind::AddR).regs(r0, r3, r6).s(2),
            1 => op(Kind::SubR).regs(r0, r3, r6).s(2),
            2 => op(Kind::AddI).regs(r0, r3, 0).imm(r6).s(2),
            _ => op(Kind::SubI).regs(r0, r3, 0).imm(r6).s(2),
        },
        0b00100 => op(Kind::MovI).regs(r8, 0, 0).imm(imm8).s(2),
        0b00101 => op(Kind::CmpI).regs(0, r8, 0).imm(imm8).s(1),
        0b00110 => op(Kind::AddI).regs(r8, r8, 0).imm(imm8).s(2),
        0b00111 => op(Kind::SubI).regs(r8, r8, 0).imm(imm8).s(2),
        0b01000 if h >> 10 & 1 == 0 => data_processing(h),
        0b01000 => special(h),
        0b01001 => op(Kind::LdrLiteral)
            .regs(r8, 15, 0)
            .imm((pc.wrapping_add(4) & !3).wrapping_add(imm8 * 4))
            .cost(2),
        0b01010 | 0b01011 => {
            let (kind, cost) = [
                (Kind::StrR, 1),
                (Kind::StrhR, 1),
                (Kind::StrbR, 1),
                (Kind::LdrsbR, 2),
                (Kind::LdrR, 2),
                (Kind::LdrhR, 2),
                (Kind::LdrbR, 2),
                (Kind::LdrshR, 2),
            ][(h >> 9 & 7) as usize];
            op(kind).regs(r0, r3, r6).cost(cost)
        }
        0b01100 => op(Kind::Str).regs(r0, r3, 0).imm(imm5 * 4),
        0b01101 => op(Kind::Ldr).regs(r0, r3, 0).imm(imm5 * 4).cost(2),
        0b01110 => op(Kind::Strb).regs(r0, r3, 0).imm(imm5),
        0b01111 => op(Kind::Ldrb).regs(r0, r3, 0).imm(imm5).cost(2),
        0b10000 => op(Kind::Strh).regs(r0, r3, 0).imm(imm5 * 2),
        0b10001 => op(Kind::Ldrh).regs(r0, r3, 0).imm(imm5 * 2).cost(2),
        0b10010 => op(Kind::Str).regs(r8, 13, 0).imm(imm8 * 4),
        0b10011 => op(Kind::Ldr).regs(r8, 13, 0).imm(imm8 * 4).cost(2),
        0b10100 => op(Kind::MovI)
            .regs(r8, 0, 0)
            .imm((pc.wrapping_add(4) & !3).wrapping_add(imm8 * 4)),
        0b10101 => op(Kind::AddI).regs(r8, 13, 0).imm(imm8 * 4),
        0b10110 | 0b10111 => miscellaneous(pc, h),
        0b11000 | 0b11001 if imm8 == 0 => undefined,
        0b11000 => op(Kind::StoreMany)
            .regs(0, r8, 0)
            .imm(imm8)
            .ra(mode::WRITE_BACK)
            .cost(1 + imm8.count_ones()),
        0b11001 => op(Kind::LoadMany)
            .regs(0, r8, 0)
            .imm(imm8)
            .ra(if imm8 >> r8 & 1 == 0 {
                mode::WRITE_BACK
            } else {
                0
            })
            .cost(1 + imm8.count_ones()),
        0b11010 | 0b11011 => {
            let offset = ((imm8 << 24) as i32 >> 23) as u32;
            match h >> 8 & 0xf {
                14 => undefined,
                15 => op(Kind::Svc).imm(imm8),
                condition => op(Kind::BranchIf)
                    .regs(condition, 0, 0)
                    .imm(pc.wrapping_add(4).wrapping_add(offset)),
            }
        }
        0b11100 => {
            let offset = (((h & 0x7ff) << 21) as i32 >> 20) as u32;
            op(Kind::Branch).imm(pc.wrapping_add(4).wrapping_add(offset))
        }
        _ => undefined,
    }
}

fn data_processing(h: u32) -> Op {
    let op = |kind| Op::new(kind, 2);
    let (d, m) = (h & LOW, h >> 3 & LOW);
    let both = |kind| op(kind).regs(d, d, m).s(2);
    match h >> 6 & 0xf {
        0 => both(Kind::AndR),
        1 => both(Kind::EorR),
        2 => both(Kind::Lsl),
        3 => both(Kind::Lsr),
        4 => both(Kind::Asr),
        5 => both(Kind::AdcR),
        6 => both(Kind::SbcR),
        7 => both(Kind::Ror),
        8 => op(Kind::TstR).regs(0, d, m).s(1),
        9 => op(Kind::RsbI).regs(d, m, 0).s(2),
        10 => op(Kind::CmpR).regs(0, d, m).s(1),
        11 => op(Kind::CmnR).regs(0, d, m).s(1),
        12 => both(Kind::OrrR),
        13 => op(Kind::Mul).regs(d, m, d).s(2),
        14 => both(Kind::BicR),
        _ => op(Kind::MvnR).regs(d, 0, m).s(2),
    }
}

/// Those that reach the high registers, and branches to a register.
fn special(h: u32) -> Op {
    let op = |kind| Op::new(kind, 2);
    let (d, m) = (h & 7 | h >> 4 & 8, h >> 3 & 0xf);
    match h >> 8 & 3 {
        0 if d == 15 => op(Kind::AddPc).regs(15, 15, m),
        0 => op(Kind::AddR).regs(d, d, m),
        1 => op(Kind::CmpR).regs(0, d, m).s(1),
        2 if d == 15 => op(Kind::MovPc).regs(15, 0, m),
        2 => op(Kind::MovR).regs(d, 0, m),
        _ if h & 7 != 0 => op(Kind::Undefined).imm(h),
        _ if h >> 7 & 1 == 1 => op(Kind::BranchLinkReg).regs(0, 0, m),
        _ => op(Kind::BranchReg).regs(0, 0, m),
    }
}

fn miscellaneous(pc: u32, h: u32) -> Op {
    let op = |kind| Op::new(kind, 2);
    let (d, m) = (h & LOW, h >> 3 & LOW);
    let count = |list: u32| 1 + list.count_ones();
    match h >> 8 & 0xf {
        0 if h >> 7 & 1 == 0 => op(Kind::AddI).regs(13, 13, 0).imm((h & 0x7f) * 4),
        0 => op(Kind::SubI).regs(13, 13, 0).imm((h & 0x7f) * 4),
        1 | 3 | 9 | 11 => {
            let kind = if h >> 11 & 1 == 0 {
                Kind::BranchZero
            } else {
                Kind::BranchNotZero
            };
            let offset = h >> 2 & 0x3e | h >> 3 & 0x40;
            op(kind)
                .regs(0, d, 0)
                .imm(pc.wrapping_add(4).wrapping_add(offset))
        }
        2 => match h >> 6 & 3 {
            0 => op(Kind::Sxth).regs(d, 15, m),
            1 => op(Kind::Sxtb).regs(d, 15, m),
            2 => op(Kind::Uxth).regs(d, 15, m),
            _ => op(Kind::Uxtb).regs(d, 15, m),
        },
        4 | 5 => {
            let list = h & 0xff | (h >> 8 & 1) << 14;
            op(Kind::StoreMany)
                .regs(0, 13, 0)
                .imm(list)
                .ra(mode::WRITE_BACK | mode::BEFORE)
                .cost(count(list))
        }
        6 if h & 0xffec == 0xb660 => op(Kind::Cps).imm(h & 3).ra(h >> 4 & 1),
        10 => match h >> 6 & 3 {
            0 => op(Kind::Rev).regs(d, 0, m),
            1 => op(Kind::Rev16).regs(d, 0, m),
            3 => op(Kind::Revsh).regs(d, 0, m),
            _ => op(Kind::Undefined).imm(h),
        },
        12 | 13 => {
            let list = h & 0xff | (h >> 8 & 1) << 15;
            op(Kind::LoadMany)
                .regs(0, 13, 0)
                .imm(list)
                .ra(mode::WRITE_BACK)
                .cost(count(list))
        }
        14 => op(Kind::Breakpoint).imm(h & 0xff),
        15 if h & 0xf != 0 => op(Kind::IfThen).imm(h & 0xff),
        15 => hint(h >> 4 & 0xf, 2),
        _ => op(Kind::Undefined).imm(h),
    }
}

/// A hint by its number.
pub fn hint(number: u32, len: u8) -> Op {
    Op::new(
        match number {
            2 => Kind::WaitEvent,
            3 => Kind::WaitInterrupt,
            4 => Kind::SendEvent,
            _ => Kind::Nop,
        },
        len,
    )
}

/// The load or store of `width` with a constant offset, and its cycles.
pub fn plain(load: bool, signed: bool, size: u32) -> (Kind, Kind, u32) {
    match (load, signed, size) {
        (false, _, 0) => (Kind::Strb, Kind::StrbR, width::BYTE),
        (false, _, 1) => (Kind::Strh, Kind::StrhR, width::HALF),
        (false, _, _) => (Kind::Str, Kind::StrR, width::WORD),
        (true, false, 0) => (Kind::Ldrb, Kind::LdrbR, width::BYTE),
        (true, false, 1) => (Kind::Ldrh, Kind::LdrhR, width::HALF),
        (true, true, 0) => (Kind::Ldrsb, Kind::LdrsbR, width::SIGNED_BYTE),
        (true, true, 1) => (Kind::Ldrsh, Kind::LdrshR, width::SIGNED_HALF),
        (true, _, _) => (Kind::Ldr, Kind::LdrR, width::WORD),
    }
}
