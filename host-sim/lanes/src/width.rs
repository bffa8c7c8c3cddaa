//! Vectors: one register of f32 or f64, or two, whatever the instruction set.
//!
//! Every operation used is correctly rounded by IEEE 754 (sum, product, fused multiply-add, quotient, square root) or
//! exact (comparison, choice), so that a lane's result has the same bits on AVX-512, AVX2, NEON and without vectors.
//!
//! WebAssembly has no fused multiply-add: there a product is rounded before the sum, and results differ in the last digits.
//! (Computed in software the fused one gives the same bits, and takes some twenty times as long: docs/page.md.)

use pulp::Simd;

/// Most lanes in one vector.
pub const MAX_LANES: usize = 32;

/// One number per lane, in memory.
pub type LaneNumbers<E> = [E; MAX_LANES];

/// A lane's number.
pub trait Element: Copy + Default + PartialOrd + Send + Sync + 'static {
    /// Half the distance from 1 to the next number.
    const GRAIN: f64;
    /// Rounds.
    fn from_f64(x: f64) -> Self;
    /// Exact.
    fn to_f64(self) -> f64;
}

impl Element for f32 {
    const GRAIN: f64 = f32::EPSILON as f64 / 2.0;
    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        x as f32
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
}

impl Element for f64 {
    const GRAIN: f64 = f64::EPSILON / 2.0;
    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
}

/// An instruction set and a precision.
pub trait LaneWidth: Copy {
    /// A lane's number.
    type E: Element;
    /// A vector.
    type V: Copy;
    /// A truth per lane.
    type M: Copy;
    /// Lanes of a vector.
    const LANES: usize;

    /// The same number in every lane.
    fn splat(self, x: f64) -> Self::V;
    /// Reads the `part`-th [`Self::LANES`] of a row.
    fn load(self, row: &LaneNumbers<Self::E>, part: usize) -> Self::V;
    /// Writes the `part`-th [`Self::LANES`] of a row.
    fn store(self, row: &mut LaneNumbers<Self::E>, part: usize, x: Self::V);
    /// a + b.
    fn add(self, a: Self::V, b: Self::V) -> Self::V;
    /// a − b.
    fn sub(self, a: Self::V, b: Self::V) -> Self::V;
    /// a b.
    fn mul(self, a: Self::V, b: Self::V) -> Self::V;
    /// a / b.
    fn div(self, a: Self::V, b: Self::V) -> Self::V;
    /// a b + c, rounded once.
    fn mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// c − a b, rounded once.
    fn mul_sub_from(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V;
    /// −a.
    fn neg(self, a: Self::V) -> Self::V;
    /// |a|.
    fn abs(self, a: Self::V) -> Self::V;
    /// √a.
    fn sqrt(self, a: Self::V) -> Self::V;
    /// a < b.
    fn lt(self, a: Self::V, b: Self::V) -> Self::M;
    /// a where `m`, otherwise b.
    fn select(self, m: Self::M, a: Self::V, b: Self::V) -> Self::V;
    /// Both.
    fn and(self, a: Self::M, b: Self::M) -> Self::M;
    /// Either.
    fn or(self, a: Self::M, b: Self::M) -> Self::M;
    /// Neither.
    fn not(self, a: Self::M) -> Self::M;
    /// Whether any lane's truth holds.
    fn any(self, m: Self::M) -> bool;
}

/// f32 lanes.
#[derive(Clone, Copy)]
pub struct Single<S>(pub S);

/// f64 lanes.
#[derive(Clone, Copy)]
pub struct Double<S>(pub S);

macro_rules! width {
    ($name:ident, $e:ty, $v:ident, $m:ident, $lanes:ident,
     $splat:ident, $simd:ident, $simd_mut:ident, $add:ident, $sub:ident, $mul:ident, $div:ident,
     $fma:ident, $fnma:ident, $neg:ident, $abs:ident, $sqrt:ident, $lt:ident, $select:ident,
     $and:ident, $or:ident, $not:ident, $first:ident) => {
        impl<S: Simd> LaneWidth for $name<S> {
            type E = $e;
            type V = S::$v;
            type M = S::$m;
            const LANES: usize = S::$lanes;

            #[inline(always)]
            fn splat(self, x: f64) -> Self::V {
                self.0.$splat(x as $e)
            }
            #[inline(always)]
            fn load(self, row: &LaneNumbers<Self::E>, part: usize) -> Self::V {
                S::$simd(row).0[part]
            }
            #[inline(always)]
            fn store(self, row: &mut LaneNumbers<Self::E>, part: usize, x: Self::V) {
                S::$simd_mut(row).0[part] = x;
            }
            #[inline(always)]
            fn add(self, a: Self::V, b: Self::V) -> Self::V {
                self.0.$add(a, b)
            }
            #[inline(always)]
            fn sub(self, a: Self::V, b: Self::V) -> Self::V {
                self.0.$sub(a, b)
            }
            #[inline(always)]
            fn mul(self, a: Self::V, b: Self::V) -> Self::V {
                self.0.$mul(a, b)
            }
            #[inline(always)]
            fn div(self, a: Self::V, b: Self::V) -> Self::V {
                self.0.$div(a, b)
            }
            #[inline(always)]
            fn mul_add(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V {
                if cfg!(target_arch = "wasm32") {
                    return self.0.$add(self.0.$mul(a, b), c);
                }
                self.0.$fma(a, b, c)
            }
            #[inline(always)]
            fn mul_sub_from(self, a: Self::V, b: Self::V, c: Self::V) -> Self::V {
                if cfg!(target_arch = "wasm32") {
                    return self.0.$sub(c, self.0.$mul(a, b));
                }
                self.0.$fnma(a, b, c)
            }
            #[inline(always)]
            fn neg(self, a: Self::V) -> Self::V {
                self.0.$neg(a)
            }
            #[inline(always)]
            fn abs(self, a: Self::V) -> Self::V {
                self.0.$abs(a)
            }
            #[inline(always)]
            fn sqrt(self, a: Self::V) -> Self::V {
                self.0.$sqrt(a)
            }
            #[inline(always)]
            fn lt(self, a: Self::V, b: Self::V) -> Self::M {
                self.0.$lt(a, b)
            }
            #[inline(always)]
            fn select(self, m: Self::M, a: Self::V, b: Self::V) -> Self::V {
                self.0.$select(m, a, b)
            }
            #[inline(always)]
            fn and(self, a: Self::M, b: Self::M) -> Self::M {
                self.0.$and(a, b)
            }
            #[inline(always)]
            fn or(self, a: Self::M, b: Self::M) -> Self::M {
                self.0.$or(a, b)
            }
            #[inline(always)]
            fn not(self, a: Self::M) -> Self::M {
                self.0.$not(a)
            }
            #[inline(always)]
            fn any(self, m: Self::M) -> bool {
                self.0.$first(m) < Self::LANES
            }
        }
    };
}

width!(
    Single,
    f32,
    f32s,
    m32s,
    F32_LANES,
    splat_f32s,
    as_simd_f32s,
    as_mut_simd_f32s,
    add_f32s,
    sub_f32s,
    mul_f32s,
    div_f32s,
    mul_add_f32s,
    negate_mul_add_f32s,
    neg_f32s,
    abs_f32s,
    sqrt_f32s,
    less_than_f32s,
    select_f32s,
    and_m32s,
    or_m32s,
    not_m32s,
    first_true_m32s
);
width!(
    Double,
    f64,
    f64s,
    m64s,
    F64_LANES,
    splat_f64s,
    as_simd_f64s,
    as_mut_simd_f64s,
    add_f64s,
    sub_f64s,
    mul_f64s,
    div_f64s,
    mul_add_f64s,
    negate_mul_add_f64s,
    neg_f64s,
    abs_f64s,
    sqrt_f64s,
    less_than_f64s,
    select_f64s,
    and_m64s,
    or_m64s,
    not_m64s,
    first_true_m64s
);

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
    type E = W::E;
    type V = (W::V, W::V);
    type M = (W::M, W::M);
    const LANES: usize = 2 * W::LANES;

    #[inline(always)]
    fn splat(self, x: f64) -> Self::V {
        (self.0.splat(x), self.0.splat(x))
    }
    #[inline(always)]
    fn load(self, row: &LaneNumbers<Self::E>, part: usize) -> Self::V {
        (self.0.load(row, 2 * part), self.0.load(row, 2 * part + 1))
    }
    #[inline(always)]
    fn store(self, row: &mut LaneNumbers<Self::E>, part: usize, x: Self::V) {
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
