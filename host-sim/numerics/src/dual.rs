//! Dual numbers: a value and its exact derivatives, so that the one source of the model also yields its
//! linearisation.
//!
//! The microcontroller has a type of its own, [`shared::model::tangent::Tangent`]: two derivatives in `f32`. It divides by
//! multiplying with the reciprocal, since a division takes as long as a dozen multiplications there, and takes powers from
//! `libm`. One type for both would change the last bits of one of them, or slow the microcontroller down.

use std::cmp::Ordering;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use shared::Real;

/// A value with its partial derivatives in `N` directions.
#[derive(Clone, Copy, Debug)]
pub struct Dual<const N: usize> {
    /// Value without its derivatives.
    pub re: f64,
    /// Partial derivatives of the value, one for each direction.
    pub eps: [f64; N],
}

impl<const N: usize> Dual<N> {
    /// A constant: derivative 0 in every direction.
    pub const fn constant(re: f64) -> Self {
        Self { re, eps: [0.0; N] }
    }

    /// A variable: derivative 1 in direction `direction`.
    pub fn variable(re: f64, direction: usize) -> Self {
        let mut x = Self::constant(re);
        x.eps[direction] = 1.0;
        x
    }

    /// f(self), given the value f and the slope f′ there.
    #[inline]
    pub fn chain(self, value: f64, slope: f64) -> Self {
        Self {
            re: value,
            eps: self.eps.map(|e| e * slope),
        }
    }

    #[inline]
    fn zip(self, other: Self, re: f64, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut eps = self.eps;
        for (a, b) in eps.iter_mut().zip(other.eps) {
            *a = f(*a, b);
        }
        Self { re, eps }
    }
}

impl<const N: usize> Default for Dual<N> {
    fn default() -> Self {
        Self::constant(0.0)
    }
}

/// Order and equality are those of the values: a branch is taken as the undisturbed trajectory takes it.
impl<const N: usize> PartialEq for Dual<N> {
    fn eq(&self, other: &Self) -> bool {
        self.re == other.re
    }
}

impl<const N: usize> PartialOrd for Dual<N> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.re.partial_cmp(&other.re)
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        self.zip(other, self.re + other.re, |a, b| a + b)
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self.zip(other, self.re - other.re, |a, b| a - b)
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    #[inline]
    #[allow(clippy::suspicious_arithmetic_impl)] // the product rule adds
    fn mul(self, other: Self) -> Self {
        let (x, y) = (self.re, other.re);
        self.zip(other, x * y, |a, b| a * y + x * b)
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;
    #[inline]
    #[allow(clippy::suspicious_arithmetic_impl)] // the quotient rule subtracts
    fn div(self, other: Self) -> Self {
        let quotient = self.re / other.re;
        self.zip(other, quotient, |a, b| (a - quotient * b) / other.re)
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        self.chain(-self.re, -1.0)
    }
}

impl<const N: usize> AddAssign for Dual<N> {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const N: usize> SubAssign for Dual<N> {
    #[inline]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<const N: usize> Real for Dual<N> {
    const ZERO: Self = Self::constant(0.0);
    const HALF: Self = Self::constant(0.5);
    const ONE: Self = Self::constant(1.0);
    const TWO: Self = Self::constant(2.0);

    fn from_f64(x: f64) -> Self {
        Self::constant(x)
    }
    fn to_f64(self) -> f64 {
        self.re
    }
    fn sqrt(self) -> Self {
        let root = self.re.sqrt();
        self.chain(root, 0.5 / root)
    }
    fn powf(self, exponent: Self) -> Self {
        // The model's exponents are parameters, never differentiated.
        let n = exponent.re;
        self.chain(self.re.powf(n), n * self.re.powf(n - 1.0))
    }
    fn atan(self) -> Self {
        self.chain(self.re.atan(), 1.0 / (1.0 + self.re * self.re))
    }
    #[inline]
    fn sin_versin(self) -> (Self, Self) {
        let (sin, versin) = self.re.sin_versin();
        (self.chain(sin, 1.0 - versin), self.chain(versin, sin))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_match_differences() {
        let f = |x: Dual<1>| {
            let (s, v) = x.sin_versin();
            (s / (x + Dual::TWO) - v * x).sqrt() * x.atan() + x.powf(Dual::constant(1.6))
        };
        let x = 0.4;
        let slope = f(Dual::variable(x, 0)).eps[0];
        let at = |x: f64| f(Dual::constant(x)).re;
        let h = 1e-6;
        let difference = (at(x + h) - at(x - h)) / (2.0 * h);
        assert!((slope - difference).abs() < 1e-8, "{slope} {difference}");
    }
}
