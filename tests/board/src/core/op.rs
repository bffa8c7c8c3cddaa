//! A decoded instruction, as the core keeps it.

/// What an instruction does. Letters at the end: `I` with a constant, `R` with a register that may be shifted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[rustfmt::skip]
#[allow(missing_docs)]
pub enum Kind {
    NotDecoded, Undefined, Nop,
    AndI, BicI, OrrI, OrnI, EorI, AddI, AdcI, SbcI, SubI, RsbI, MovI, MvnI, TstI, TeqI, CmpI, CmnI,
    AndR, BicR, OrrR, OrnR, EorR, AddR, AdcR, SbcR, SubR, RsbR, MovR, MvnR, TstR, TeqR, CmpR, CmnR,
    Lsl, Lsr, Asr, Ror, Movt,
    Branch, BranchIf, BranchLink, BranchLinkReg, BranchReg, BranchZero, BranchNotZero, TableByte, TableHalf,
    MovPc, AddPc, IfThen,
    Ldr, Ldrb, Ldrh, Ldrsb, Ldrsh, Str, Strb, Strh,
    LdrR, LdrbR, LdrhR, LdrsbR, LdrshR, StrR, StrbR, StrhR,
    LdrLiteral, LoadIndexed, StoreIndexed, LoadMany, StoreMany, LoadPair, StorePair,
    LoadExclusive, StoreExclusive, ClearExclusive,
    Mul, Mla, Mls, Smull, Umull, Smlal, Umlal, Umaal, Sdiv, Udiv,
    SmulHalf, SmlaHalf, SmulWide, SmlalHalf, SmulDual, SmlalDual, MulHigh, SumDiff,
    Sxtb, Sxth, Uxtb, Uxth, Sxtb16, Uxtb16, Rev, Rev16, Revsh, Rbit, Clz, Sel, Bfi, Sbfx, Ubfx, Ssat, Usat, Ssat16, Usat16,
    PackBt, PackTb, Parallel, Saturating,
    Mrs, Msr, Cps, Svc, Breakpoint, WaitInterrupt, WaitEvent, SendEvent, Barrier,
    Vadd, Vsub, Vmul, Vnmul, Vdiv, Vmla, Vmls, Vnmla, Vnmls, Vfma, Vfms, Vfnma, Vfnms,
    VmovI, Vmov, Vabs, Vneg, Vsqrt, Vcmp, VcmpZero, VtoInt, VfromInt, Vfixed,
    VmovToCore, VmovFromCore, VmovPair, VmovPairDouble, Vmrs, Vmsr, Vldr, Vstr, Vldm, Vstm,
}

/// An instruction. Of 16 bytes, so that it is copied at once: a copy in parts costs a third of the run.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub struct Op {
    /// What the instruction does.
    pub kind: Kind,
    /// Its bytes, 2 or 4.
    pub len: u8,
    /// Whether it sets the flags: 0 no, 1 yes, 2 outside of an IT block. Loads and stores: their width.
    pub s: u8,
    /// Cycles with no wait and no branch taken.
    pub cost: u8,
    /// Destination, or what is stored.
    pub rd: u8,
    /// First operand, or base.
    pub rn: u8,
    /// Second operand, or index.
    pub rm: u8,
    /// A fourth register, kind of shift, or flags of an addressing mode.
    pub ra: u8,
    /// A constant, an amount of shift, or the address that a branch goes to.
    pub imm: u32,
}

impl Op {
    /// Not looked at yet.
    pub const NOT_DECODED: Self = Self::new(Kind::NotDecoded, 2);

    /// Of that kind and length; all else 0, one cycle.
    pub const fn new(kind: Kind, len: u8) -> Self {
        Self {
            kind,
            len,
            s: 0,
            cost: 1,
            rd: 0,
            rn: 0,
            rm: 0,
            ra: 0,
            imm: 0,
        }
    }

    /// With these registers: destination, first and second operand.
    pub const fn regs(mut self, rd: u32, rn: u32, rm: u32) -> Self {
        self.rd = rd as u8;
        self.rn = rn as u8;
        self.rm = rm as u8;
        self
    }

    /// With this constant in `imm`.
    pub const fn imm(mut self, imm: u32) -> Self {
        self.imm = imm;
        self
    }

    /// With this fourth register, shift or mode.
    pub const fn ra(mut self, ra: u32) -> Self {
        self.ra = ra as u8;
        self
    }

    /// With this in `s`.
    pub const fn s(mut self, s: u32) -> Self {
        self.s = s as u8;
        self
    }

    /// With this number of cycles, without waits.
    pub const fn cost(mut self, cost: u32) -> Self {
        self.cost = cost as u8;
        self
    }
}

/// Kinds of shift in [`Op::ra`].
pub mod shift {
    #![allow(missing_docs)]
    pub const LSL: u32 = 0;
    pub const LSR: u32 = 1;
    pub const ASR: u32 = 2;
    pub const ROR: u32 = 3;
    pub const RRX: u32 = 4;
}

/// Widths of an access in [`Op::s`].
pub mod width {
    #![allow(missing_docs)]
    pub const WORD: u32 = 0;
    pub const BYTE: u32 = 1;
    pub const HALF: u32 = 2;
    pub const SIGNED_BYTE: u32 = 3;
    pub const SIGNED_HALF: u32 = 4;
}

/// Addressing modes in [`Op::ra`]: added to before the access, and base written back.
pub mod mode {
    #![allow(missing_docs)]
    pub const BEFORE: u32 = 1;
    pub const WRITE_BACK: u32 = 2;
}
