//! The numbers a flow is integrated in: plain, or dual, so that an instant of switching carries derivatives.

use shared::Real;

use crate::dual::Dual;

/// A scalar a flow is integrated in.
pub trait Scalar: Real {
    /// sin x for any angle, rad.
    fn sin(self) -> Self;

    /// The exponential eˣ.
    fn exp(self) -> Self;

    /// `factor` times this: what a product with a constant is, without the products of derivatives that are 0.
    #[must_use]
    fn scaled(self, factor: f64) -> Self;

    /// The derivatives it carries.
    fn derivatives(&self) -> &[f64];

    /// A time found as the root of `g`, given dg/dt there: for a dual number, the root's derivatives.
    #[must_use]
    fn as_root_of(self, g: Self, slope: f64) -> Self;
}

impl Scalar for f64 {
    #[inline]
    fn sin(self) -> Self {
        self.sin()
    }
    #[inline]
    fn exp(self) -> Self {
        self.exp()
    }
    #[inline]
    fn scaled(self, factor: f64) -> Self {
        self * factor
    }
    #[inline]
    fn derivatives(&self) -> &[f64] {
        &[]
    }
    #[inline]
    fn as_root_of(self, _: Self, _: f64) -> Self {
        self
    }
}

impl<const N: usize> Scalar for Dual<N> {
    #[inline]
    fn sin(self) -> Self {
        let (sin, cos) = self.re.sin_cos();
        self.chain(sin, cos)
    }
    #[inline]
    fn exp(self) -> Self {
        let exp = self.re.exp();
        self.chain(exp, exp)
    }
    #[inline]
    fn scaled(self, factor: f64) -> Self {
        self.chain(self.re * factor, factor)
    }
    #[inline]
    fn derivatives(&self) -> &[f64] {
        &self.eps
    }
    fn as_root_of(self, g: Self, slope: f64) -> Self {
        // g(t, x) = 0 along the family: dt/dx = −(∂g/∂x)/(dg/dt).
        Self {
            re: self.re,
            eps: g.eps.map(|e| -e / slope),
        }
    }
}
