//! Vectors of f64: one register, or two, whatever the instruction set.
//!
//! Every operation used is correctly rounded by IEEE 754 (sum, product, fused multiply-add, quotient, square root) or
//! exact (comparison, choice), so that a lane's result has the same bits on AVX-512, AVX2, NEON and without vectors.
//!
//! WebAssembly has no fused multiply-add: there a product is rounded before the sum, and results differ in the last digits.
//! (Computed in software the fused one gives the same bits, and takes some twenty times as long.)

use pulp::Simd;

/// Most lanes in one vector.
pub const MAX_LANES: usize = 16;

/// One number per lane, in memory.
pub type LaneNumbers = [f64; MAX_LANES];

/// An instruction set: its vectors of f64, and what it does with them.
pub trait LaneWidth: Copy {
    /// A vector: a number per lane.
    type V: Copy;
    /// A truth per lane.
    type M: Copy;
    /// Lanes of a vector.
    const LANES: usize;

    /// `x` in every lane.
    fn splat(self, x: f64) -> Self::V;
    /// Reads the `part`-th [`Self::LANES`] of a row.
    fn load(self, row: &LaneNumbers, part: usize) -> Self::V;
    /// Writes the `part`-th [`Self::LANES`] of a row.
    fn store(self, row: &mut LaneNumbers, part: usize, x: Self::V);
    fn add(self, a: Self::V, b: Self::V) -> Self::V;
    fn sub(self, a: Self::V, b: Self::V) -> Self::V;
    fn mul(self, a: Self::V, b: Self::V) -> Self::V;
    fn div(self, a: Self::V, b: Self::V) -> Self::V;
    /// a b + c, rounded once.
    fn mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// c − a b, rounded once.
    fn mul_sub_from(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    fn neg(self, a: Self::V) -> Self::V;
    fn abs(self, a: Self::V) -> Self::V;
    fn sqrt(self, a: Self::V) -> Self::V;
    fn lt(self, a: Self::V, b: Self::V) -> Self::M;
    /// a where `m`, otherwise b.
    fn select(self, m: Self::M, a: Self::V, b: Self::V) -> Self::V;
    fn and(self, a: Self::M, b: Self::M) -> Self::M;
    fn or(self, a: Self::M, b: Self::M) -> Self::M;
    fn not(self, a: Self::M) -> Self::M;
    /// Whether any lane's truth holds.
    fn any(self, m: Self::M) -> bool;
}

/// Operations that are one of the instruction set's.
macro_rules! instruction {
    ($($name:ident($($x:ident: $in:ident),*) -> $out:ident = $own:ident;)*) => { $(
        #[inline(always)]
        fn $name(self, $($x: Self::$in),*) -> Self::$out {
            self.0.$own($($x),*)
        }
    )* };
}

/// Vectors of f64 as wide as one register.
#[derive(Clone, Copy)]
pub struct Double<S>(pub S);

impl<S: Simd> LaneWidth for Double<S> {
    type V = S::f64s;
    type M = S::m64s;
    const LANES: usize = S::F64_LANES;

    #[inline(always)]
    fn splat(self, x: f64) -> Self::V {
        self.0.splat_f64s(x)
    }
    #[inline(always)]
    fn load(self, row: &LaneNumbers, part: usize) -> Self::V {
        S::as_simd_f64s(row).0[part]
    }
    #[inline(always)]
    fn store(self, row: &mut LaneNumbers, part: usize, x: Self::V) {
        S::as_mut_simd_f64s(row).0[part] = x;
    }
    #[inline(always)]
    fn mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V {
        if cfg!(target_arch = "wasm32") {
            return self.0.add_f64s(self.0.mul_f64s(a, b), c);
        }
        self.0.mul_add_f64s(a, b, c)
    }
    #[inline(always)]
    fn mul_sub_from(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V {
        if cfg!(target_arch = "wasm32") {
            return self.0.sub_f64s(c, self.0.mul_f64s(a, b));
        }
        self.0.negate_mul_add_f64s(a, b, c)
    }
    instruction! {
        add(a: V, b: V) -> V = add_f64s;
        sub(a: V, b: V) -> V = sub_f64s;
        mul(a: V, b: V) -> V = mul_f64s;
        div(a: V, b: V) -> V = div_f64s;
        neg(a: V) -> V = neg_f64s;
        abs(a: V) -> V = abs_f64s;
        sqrt(a: V) -> V = sqrt_f64s;
        lt(a: V, b: V) -> M = less_than_f64s;
        select(m: M, a: V, b: V) -> V = select_f64s;
        and(a: M, b: M) -> M = and_m64s;
        or(a: M, b: M) -> M = or_m64s;
        not(a: M) -> M = not_m64s;
    }
    #[inline(always)]
    fn any(self, m: Self::M) -> bool {
        self.0.first_true_m64s(m) < Self::LANES
    }
}

/// Two vectors side by side: while one waits for a result, the other is computed.
#[derive(Clone, Copy)]
pub struct VectorPair<W>(pub W);

macro_rules! both {
    ($($name:ident($($x:ident: $in:ident),*) -> $out:ident;)*) => { $(
        #[inline(always)]
        fn $name(self, $($x: Self::$in),*) -> Self::$out {
            (self.0.$name($($x.0),*), self.0.$name($($x.1),*))
        }
    )* };
}

impl<W: LaneWidth> LaneWidth for VectorPair<W> {
    type V = (W::V, W::V);
    type M = (W::M, W::M);
    const LANES: usize = 2 * W::LANES;

    #[inline(always)]
    fn splat(self, x: f64) -> Self::V {
        (self.0.splat(x), self.0.splat(x))
    }
    #[inline(always)]
    fn load(self, row: &LaneNumbers, part: usize) -> Self::V {
        (self.0.load(row, 2 * part), self.0.load(row, 2 * part + 1))
    }
    #[inline(always)]
    fn store(self, row: &mut LaneNumbers, part: usize, x: Self::V) {
        self.0.store(row, 2 * part, x.0);
        self.0.store(row, 2 * part + 1, x.1);
    }
    both! {
        add(a: V, b: V) -> V;
        sub(a: V, b: V) -> V;
        mul(a: V, b: V) -> V;
        div(a: V, b: V) -> V;
        mul_add(a: V, b: V, c: V) -> V;
        mul_sub_from(a: V, b: V, c: V) -> V;
        neg(a: V) -> V;
        abs(a: V) -> V;
        sqrt(a: V) -> V;
        lt(a: V, b: V) -> M;
        select(m: M, a: V, b: V) -> V;
        and(a: M, b: M) -> M;
        or(a: M, b: M) -> M;
        not(a: M) -> M;
    }
    #[inline(always)]
    fn any(self, m: Self::M) -> bool {
        self.0.any(m.0) | self.0.any(m.1)
    }
}
