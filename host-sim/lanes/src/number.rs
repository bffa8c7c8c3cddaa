//! Lanes of numbers, one per cell, with which formulas read as formulas.

use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use super::width::{LaneNumbers, LaneWidth, MAX_LANES};

/// A vector with its instruction set.
#[derive(Clone, Copy)]
pub struct Num<W: LaneWidth> {
    w: W,
    v: W::V,
}

/// A truth per lane.
#[derive(Clone, Copy)]
pub struct Mask<W: LaneWidth> {
    w: W,
    m: W::M,
}

impl<W: LaneWidth> Num<W> {
    /// `x` in every lane.
    #[inline(always)]
    pub fn splat(w: W, x: f64) -> Self {
        Self { w, v: w.splat(x) }
    }
    /// Reads a row of memory.
    #[inline(always)]
    pub fn load(w: W, row: &LaneNumbers) -> Self {
        Self {
            w,
            v: w.load(row, 0),
        }
    }
    /// Writes a row of memory.
    #[inline(always)]
    pub fn store(self, row: &mut LaneNumbers) {
        self.w.store(row, 0, self.v);
    }
    /// `x` in every lane, in the instruction set of this vector.
    #[inline(always)]
    pub fn of(self, x: f64) -> Self {
        Self::splat(self.w, x)
    }
    /// self b + c.
    #[inline(always)]
    pub fn mul_add(self, b: Self, c: Self) -> Self {
        let v = self.w.mul_add(self.v, b.v, c.v);
        Self { w: self.w, v }
    }
    /// c − self b.
    #[inline(always)]
    pub fn mul_sub_from(self, b: Self, c: Self) -> Self {
        let v = self.w.mul_sub_from(self.v, b.v, c.v);
        Self { w: self.w, v }
    }
    #[inline(always)]
    pub fn abs(self) -> Self {
        let v = self.w.abs(self.v);
        Self { w: self.w, v }
    }
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        let v = self.w.sqrt(self.v);
        Self { w: self.w, v }
    }
    /// In each lane: whether self < b.
    #[inline(always)]
    pub fn lt(self, b: Self) -> Mask<W> {
        let m = self.w.lt(self.v, b.v);
        Mask { w: self.w, m }
    }
    /// The smaller; `b` if either is no number.
    #[inline(always)]
    pub fn min(self, b: Self) -> Self {
        self.lt(b).choose(self, b)
    }
    /// The larger; `b` if either is no number.
    #[inline(always)]
    pub fn max(self, b: Self) -> Self {
        b.lt(self).choose(self, b)
    }
}

impl<W: LaneWidth> Mask<W> {
    /// a where true, otherwise b.
    #[inline(always)]
    pub fn choose(self, a: Num<W>, b: Num<W>) -> Num<W> {
        let v = self.w.select(self.m, a.v, b.v);
        Num { w: self.w, v }
    }
    /// Whether any lane's truth holds.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.w.any(self.m)
    }
    /// The lanes in which it is true, by bit.
    #[inline(always)]
    pub fn bits(self) -> u32 {
        let mut row = [0.0; MAX_LANES];
        let zero = Num::splat(self.w, 0.0);
        self.choose(Num::splat(self.w, 1.0), zero).store(&mut row);
        let bit = |lane: usize| u32::from(row[lane] != 0.0) << lane;
        (0..W::LANES).map(bit).fold(0, |bits, bit| bits | bit)
    }
}

/// An operator that is an operation of the instruction set, on numbers (`v`) or truths (`m`): alone, or with a second.
macro_rules! operator {
    ($trait:ident::$method:ident = $own:ident, $of:ident { $x:ident } $(and $b:ident)?) => {
        impl<W: LaneWidth> $trait for $of<W> {
            type Output = Self;
            #[inline(always)]
            fn $method(self $(, $b: Self)?) -> Self {
                let $x = self.w.$own(self.$x $(, $b.$x)?);
                Self { w: self.w, $x }
            }
        }
    };
}

operator!(Add::add = add, Num { v } and b);
operator!(Sub::sub = sub, Num { v } and b);
operator!(Mul::mul = mul, Num { v } and b);
operator!(Div::div = div, Num { v } and b);
operator!(Neg::neg = neg, Num { v });
operator!(BitAnd::bitand = and, Mask { m } and b);
operator!(BitOr::bitor = or, Mask { m } and b);
operator!(Not::not = not, Mask { m });

/// The operator with a number that is the same in every lane.
macro_rules! with_the_same {
    ($trait:ident::$method:ident) => {
        impl<W: LaneWidth> $trait<f64> for Num<W> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, b: f64) -> Self {
                $trait::$method(self, self.of(b))
            }
        }
    };
}

with_the_same!(Add::add);
with_the_same!(Sub::sub);
with_the_same!(Mul::mul);
with_the_same!(Div::div);
