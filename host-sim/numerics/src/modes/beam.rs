//! Bending modes of a clamped Euler–Bernoulli beam with a mass at its tip.
//!
//! With λ = βL, ω = λ² √(EI/μL⁴) and α = hammer mass over beam mass μL, the roots λ are those of
//!
//! - tip free to turn: 1 + cosh λ cos λ = α λ (cosh λ sin λ − sinh λ cos λ)
//!   (Laura, Pombo and Susemihl, *Journal of Sound and Vibration* 37 (1974) 161–168);
//! - tip guided, as two parallel springs guide it: cosh λ sin λ + sinh λ cos λ = α λ (1 − cosh λ cos λ).
//!
//! Both follow from w = A (cosh βx − cos βx) + B (sinh βx − sin βx), which is clamped at x = 0, with
//! EI w‴(L) = −ω² M w(L) and either w″(L) = 0 or w′(L) = 0. All is scaled by e^−λ, so that no large exponentials cancel.

use std::f64::consts::TAU;

use serde::Serialize;

use crate::error::{Error, ModesError};
use crate::root::halved;

/// How the hammer holds the beam's end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum TipJoint {
    /// It cannot turn: two parallel springs hold the hammer upright.
    #[default]
    Guided,
    /// It turns with the beam's end: one spring, a small hammer.
    Free,
}

/// The beam springs, all together, in proportion to the hammer. Their length, width and thickness matter in no other
/// way: the first mode's frequency is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// How the hammer holds their end.
    pub tip: TipJoint,
    /// Mass of the beam springs over the hammer's.
    pub mass_ratio: f64,
}

/// A mode, its shape scaled to 1 at the hammer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BendingMode {
    /// λ = βL, dimensionless: a root of the frequency equation.
    pub root: f64,
    /// Natural frequency ω_i, undamped, rad/s.
    pub omega: f64,
    /// m_i = ∫μφ² dx + M, kg.
    pub mass_kg: f64,
    /// Γ_i = ∫μφ dx + M, kg: what the cart's acceleration acts on.
    pub participation_kg: f64,
}

/// Beam masses that make sense, over the hammer's.
const MASS_RATIOS: std::ops::RangeInclusive<f64> = 0.001..=10.0;

/// Roots are this far apart at least.
const SCAN: f64 = 0.05;

/// Intervals of Simpson's rule along the beam, for the modal mass.
const INTERVALS: usize = 2000;

impl Beam {
    /// The `count` lowest modes for a hammer of `hammer_kg`, the first at `first_hz`.
    ///
    /// # Errors
    /// If the mass of the beam is out of range.
    pub fn modes(
        &self,
        hammer_kg: f64,
        first_hz: f64,
        count: usize,
    ) -> Result<Vec<BendingMode>, Error> {
        if !MASS_RATIOS.contains(&self.mass_ratio) {
            return Err(ModesError::MassRatio {
                ratio: self.mass_ratio,
                allowed: (*MASS_RATIOS.start(), *MASS_RATIOS.end()),
            }
            .into());
        }
        let roots = self.roots(count);
        let beam_kg = self.mass_ratio * hammer_kg;
        let mode = |root: &f64| {
            let shape = Shape::new(self.tip, *root);
            let tip = shape.at(1.0);
            BendingMode {
                root: *root,
                omega: TAU * first_hz * (root / roots[0]).powi(2),
                mass_kg: beam_kg * shape.mean_square() / (tip * tip) + hammer_kg,
                // ∫μφ + Mφ(L) = −EI φ‴(0)/ω², from the beam's own equation.
                participation_kg: -2.0 * shape.b * beam_kg / (root * tip),
            }
        };
        Ok(roots.iter().map(mode).collect())
    }

    /// λ of the `count` lowest modes.
    pub fn roots(&self, count: usize) -> Vec<f64> {
        let mut roots = Vec::with_capacity(count);
        let mut low = 1e-3;
        while roots.len() < count {
            let high = low + SCAN;
            if self.equation(low) * self.equation(high) <= 0.0 {
                roots.push(self.root_between(low, high));
            }
            low = high;
        }
        roots
    }

    /// The frequency equation over cosh λ; 0 at a root.
    fn equation(&self, root: f64) -> f64 {
        let (sin, cos) = root.sin_cos();
        let (tanh, sech) = (root.tanh(), 1.0 / root.cosh());
        let loaded = root / self.mass_ratio;
        match self.tip {
            TipJoint::Guided => sin + tanh * cos - loaded * (sech - cos),
            TipJoint::Free => sech + cos - loaded * (sin - tanh * cos),
        }
    }

    fn root_between(&self, low: f64, high: f64) -> f64 {
        let sign = self.equation(low);
        let passed = |root| self.equation(root) * sign <= 0.0;
        let (low, high) = halved((low, high), 60, passed);
        0.5 * (low + high)
    }
}

/// A mode's shape over ξ = x/L, times e^−λ.
#[derive(Clone, Copy, Debug)]
struct Shape {
    root: f64,
    a: f64,
    b: f64,
    /// a + b and a − b, without the cancellation.
    sum: f64,
    difference: f64,
}

impl Shape {
    fn new(tip: TipJoint, root: f64) -> Self {
        let (sin, cos) = root.sin_cos();
        let e = (-root).exp();
        let (cosh, sinh) = (0.5 * (1.0 + e * e), 0.5 * (1.0 - e * e));
        match tip {
            TipJoint::Guided => Self {
                root,
                a: cosh - e * cos,
                b: -(sinh + e * sin),
                sum: e * (e - cos - sin),
                difference: 1.0 + e * (sin - cos),
            },
            TipJoint::Free => Self {
                root,
                a: sinh + e * sin,
                b: -(cosh + e * cos),
                sum: e * (sin - cos - e),
                difference: 1.0 + e * (sin + cos),
            },
        }
    }

    fn at(&self, xi: f64) -> f64 {
        let angle = self.root * xi;
        let (sin, cos) = angle.sin_cos();
        let growing = 0.5 * self.sum * angle.exp();
        let fading = 0.5 * self.difference * (-angle).exp();
        growing + fading - self.a * cos - self.b * sin
    }

    /// ∫φ² dξ by Simpson's rule.
    fn mean_square(&self) -> f64 {
        let weight = |k: usize| match k {
            0 | INTERVALS => 1.0,
            _ if k % 2 == 1 => 4.0,
            _ => 2.0,
        };
        let value = |k: usize| self.at(k as f64 / INTERVALS as f64).powi(2);
        let sum: f64 = (0..=INTERVALS).map(|k| weight(k) * value(k)).sum();
        sum / (3.0 * INTERVALS as f64)
    }
}

#[cfg(test)]
mod tests;
