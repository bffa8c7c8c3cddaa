//! The scalar the model is written in: `f32` on the microcontroller, `f64` for analysis, and whatever
//! else implements [`Real`] (host-sim differentiates the model with dual numbers).

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use crate::model::trig;

/// A real number the model can be computed in.
///
/// Only what the model needs: arithmetic, order, and four functions. Nothing here panics; out-of-range
/// arguments give the NaN or infinity that IEEE 754 prescribes.
pub trait Real:
    Copy
    + Debug
    + Default
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// 0.
    const ZERO: Self;
    /// ½.
    const HALF: Self;
    /// 1.
    const ONE: Self;
    /// 2.
    const TWO: Self;

    /// The nearest representable value.
    fn from_f64(x: f64) -> Self;
    /// The value as `f64` (for a dual number, its real part).
    fn to_f64(self) -> f64;
    /// Square root.
    fn sqrt(self) -> Self;
    /// `self` to the power `exponent`, for `self ≥ 0`.
    fn powf(self, exponent: Self) -> Self;
    /// Inverse tangent, rad.
    fn atan(self) -> Self;
    /// `(sin x, 1 − cos x)` for an angle in rad.
    ///
    /// `1 − cos x` is returned in place of `cos x` because it keeps its relative accuracy near zero,
    /// where the model lives. Error bounds: see [`crate::model::trig`].
    fn sin_versin(self) -> (Self, Self);

    /// Absolute value.
    #[inline]
    fn abs(self) -> Self {
        if self < Self::ZERO { -self } else { self }
    }

    /// The smaller of two; `other` if `self` is NaN.
    #[inline]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }

    /// The larger of two; `other` if `self` is NaN.
    #[inline]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
}

macro_rules! real {
    ($float:ident, $sqrt:ident, $pow:ident, $atan:ident, $sin_versin:ident) => {
        impl Real for $float {
            const ZERO: Self = 0.0;
            const HALF: Self = 0.5;
            const ONE: Self = 1.0;
            const TWO: Self = 2.0;

            #[inline]
            fn from_f64(x: f64) -> Self {
                x as Self
            }
            #[inline]
            fn to_f64(self) -> f64 {
                self.into()
            }
            #[inline]
            fn sqrt(self) -> Self {
                libm::$sqrt(self)
            }
            #[inline]
            fn powf(self, exponent: Self) -> Self {
                libm::$pow(self, exponent)
            }
            #[inline]
            fn atan(self) -> Self {
                libm::$atan(self)
            }
            #[inline]
            fn sin_versin(self) -> (Self, Self) {
                trig::$sin_versin(self)
            }
        }
    };
}

real!(f32, sqrtf, powf, atanf, sin_versin_f32);
real!(f64, sqrt, pow, atan, sin_versin_f64);

/// A sum kept in two parts, so that adding many small increments to a large value loses nothing that
/// matters: the value is `hi`, and `lo` carries what rounding dropped (Kahan's compensation with Knuth's two-sum).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Compensated<R> {
    /// The rounded sum: read this.
    pub hi: R,
    /// What `hi` has lost to rounding so far.
    pub lo: R,
}

impl<R: Real> Compensated<R> {
    /// A sum that starts at `value`, nothing lost yet.
    #[inline]
    pub fn new(value: R) -> Self {
        Self {
            hi: value,
            lo: R::ZERO,
        }
    }

    /// This sum with `increment` added.
    #[inline]
    #[must_use]
    pub fn plus(self, increment: R) -> Self {
        let step = increment + self.lo;
        let hi = self.hi + step;
        // Knuth's two-sum: exact whichever of the two is the larger.
        let step_seen = hi - self.hi;
        let lo = (self.hi - (hi - step_seen)) + (step - step_seen);
        Self { hi, lo }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn compensated_sum_keeps_what_a_plain_sum_loses() {
        let mut plain = 1.0_f32;
        let mut kept = Compensated::new(1.0_f32);
        for _ in 0..1_000_000 {
            plain += 1e-8;
            kept = kept.plus(1e-8);
        }
        assert_eq!(plain, 1.0, "the plain sum never moves");
        assert!((kept.hi - 1.01).abs() < 2e-7, "{}", kept.hi);
    }

    #[test]
    fn min_and_max_prefer_the_number_over_nan_on_the_left() {
        assert_eq!(Real::min(f32::NAN, 1.0), 1.0);
        assert_eq!(Real::max(f32::NAN, 1.0), 1.0);
        assert_eq!(Real::min(2.0, 1.0), 1.0);
        assert_eq!(Real::max(2.0, 1.0), 2.0);
    }
}
