//! A number with its derivatives in two directions, in `f32`: what turns the model into its own
//! linearisation on the microcontroller.
//!
//! Branches are taken by the value, and every operation computes the value as `f32` does, bit for bit: a
//! [`Tangent`] run follows the very trajectory of the plain one. At a switch the field jumps, and the
//! derivative with it; a stepper that crosses one adds that jump ([`crate::forecast::variation`]).

use core::cmp::Ordering;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use crate::model::scalar::Real;

/// A value and its partial derivatives.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tangent {
    /// The number itself.
    pub value: f32,
    /// Its derivatives in the two directions.
    pub partial: [f32; 2],
}

impl Tangent {
    /// A constant: both derivatives are 0.
    pub const fn constant(value: f32) -> Self {
        Self {
            value,
            partial: [0.0; 2],
        }
    }

    /// A value with its derivatives.
    pub const fn new(value: f32, partial: [f32; 2]) -> Self {
        Self { value, partial }
    }

    /// f(self), given the value f and the slope f′ there.
    #[inline]
    fn chain(self, value: f32, slope: f32) -> Self {
        let [a, b] = self.partial;
        Self::new(value, [a * slope, b * slope])
    }
}

/// Order and equality are those of the values.
impl PartialEq for Tangent {
    #[inline]
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

impl PartialOrd for Tangent {
    #[inline]
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.value.partial_cmp(&other.value)
    }
}

impl Add for Tangent {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        let ([a, b], [c, d]) = (self.partial, other.partial);
        Self::new(self.value + other.value, [a + c, b + d])
    }
}

impl Sub for Tangent {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        let ([a, b], [c, d]) = (self.partial, other.partial);
        Self::new(self.value - other.value, [a - c, b - d])
    }
}

impl Mul for Tangent {
    type Output = Self;
    #[inline]
    #[allow(clippy::suspicious_arithmetic_impl)] // the product rule adds
    fn mul(self, other: Self) -> Self {
        let (x, y) = (self.value, other.value);
        let ([a, b], [c, d]) = (self.partial, other.partial);
        Self::new(x * y, [a * y + x * c, b * y + x * d])
    }
}

impl Div for Tangent {
    type Output = Self;
    #[inline]
    #[allow(clippy::suspicious_arithmetic_impl)] // the quotient rule subtracts
    fn div(self, other: Self) -> Self {
        let quotient = self.value / other.value;
        let inverse = 1.0 / other.value;
        let ([a, b], [c, d]) = (self.partial, other.partial);
        Self::new(
            quotient,
            [(a - quotient * c) * inverse, (b - quotient * d) * inverse],
        )
    }
}

impl Neg for Tangent {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        let [a, b] = self.partial;
        Self::new(-self.value, [-a, -b])
    }
}

impl AddAssign for Tangent {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Tangent {
    #[inline]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Real for Tangent {
    const ZERO: Self = Self::constant(0.0);
    const HALF: Self = Self::constant(0.5);
    const ONE: Self = Self::constant(1.0);
    const TWO: Self = Self::constant(2.0);

    #[inline]
    fn from_f64(x: f64) -> Self {
        Self::constant(x as f32)
    }
    #[inline]
    fn to_f64(self) -> f64 {
        self.value.into()
    }
    #[inline]
    fn sqrt(self) -> Self {
        let root = Real::sqrt(self.value);
        self.chain(root, 0.5 / root)
    }
    #[inline]
    fn powf(self, exponent: Self) -> Self {
        // The model's exponents are parameters, never differentiated.
        let n = exponent.value;
        self.chain(
            Real::powf(self.value, n),
            n * Real::powf(self.value, n - 1.0),
        )
    }
    #[inline]
    fn atan(self) -> Self {
        self.chain(
            Real::atan(self.value),
            1.0 / (1.0 + self.value * self.value),
        )
    }
    #[inline]
    fn sin_versin(self) -> (Self, Self) {
        let (sin, versin) = self.value.sin_versin();
        (self.chain(sin, 1.0 - versin), self.chain(versin, sin))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model<R: Real>(x: R, y: R) -> R {
        let (s, v) = x.sin_versin();
        (s / (y + R::TWO) - v * x).sqrt() * y.atan() + x.powf(R::from_f64(1.6)) - -(x * y).abs()
    }

    #[test]
    fn derivatives_match_differences_in_f64() {
        let (x, y) = (0.4_f64, 0.7_f64);
        let got = model(
            Tangent::new(x as f32, [1.0, 0.0]),
            Tangent::new(y as f32, [0.0, 1.0]),
        );
        let h = 1e-6;
        let slopes = [
            (model(x + h, y) - model(x - h, y)) / (2.0 * h),
            (model(x, y + h) - model(x, y - h)) / (2.0 * h),
        ];
        for (got, want) in got.partial.into_iter().zip(slopes) {
            assert!((f64::from(got) - want).abs() < 1e-6, "{got} {want}");
        }
    }

    #[test]
    fn the_value_is_what_f32_computes_bit_for_bit() {
        for i in 1..200_u16 {
            let (x, y) = (f32::from(i) * 0.004, f32::from(i % 7) * 0.3);
            let plain = model(x, y);
            let got = model(Tangent::new(x, [1.0, 2.0]), Tangent::new(y, [3.0, -1.0]));
            assert_eq!(plain.to_bits(), got.value.to_bits(), "{x} {y}");
        }
    }
}
