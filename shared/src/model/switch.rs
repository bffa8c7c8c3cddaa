//! The Filippov switch model: two indicators, four vector fields, two band widths (equations 3-19 to
//! 3-29).

use crate::model::contact::Law;
use crate::model::scalar::Real;

/// Widths of the band around the switching surface.
///
/// The chapter writes one η for both; they measure different things, so they are two here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band<R> {
    /// η_α, m: |h_α| = |δ| below this is "on Σα".
    pub eta_alpha: R,
    /// η_β, N: |h_β| = |F| below this is "on Σβ".
    pub eta_beta: R,
}

impl<R: Real> Band<R> {
    /// A band of `eta_alpha_m` (m) and `eta_beta_n` (N).
    pub fn new(eta_alpha_m: f64, eta_beta_n: f64) -> Self {
        Self {
            eta_alpha: R::from_f64(eta_alpha_m),
            eta_beta: R::from_f64(eta_beta_n),
        }
    }
}

/// Which of the four fields acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subspace {
    /// Γ−: flight (3-21, 3-26).
    Flight,
    /// Γ+: contact (3-22, 3-27).
    Contact,
    /// Σα: entering; the damper alone acts (3-23, 3-28).
    Entering,
    /// Σβ: leaving; nothing acts (3-24, 3-29).
    Leaving,
}

/// Where a state lies, from h_α = δ (m) and h_β = F (N).
///
/// Σα needs h_β ≥ 0: without that guard the damper pulls on the way out, and the restitution at 0.08 m/s
/// comes out as 0.20 instead of 0.317 (η_α = 1e-6 m).
#[inline]
pub fn classify<R: Real>(h_alpha: R, h_beta: R, band: &Band<R>) -> Subspace {
    if h_alpha.abs() < band.eta_alpha && h_beta >= R::ZERO {
        Subspace::Entering
    } else if h_beta.abs() < band.eta_beta && h_alpha >= R::ZERO {
        Subspace::Leaving
    } else if h_alpha > R::ZERO && h_beta > R::ZERO {
        Subspace::Contact
    } else {
        Subspace::Flight
    }
}

/// The contact force of the field that acts in the band's model, N.
#[inline]
pub fn banded_force<R: Real>(law: &Law<R>, delta: R, rate: R, approach: R, band: &Band<R>) -> R {
    let h_beta = law.force(delta, rate, approach);
    match classify(delta, h_beta, band) {
        Subspace::Contact => h_beta,
        Subspace::Entering => law.onset_force(rate),
        Subspace::Flight | Subspace::Leaving => R::ZERO,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::contact::TABLE_3_1;

    #[test]
    fn the_four_subspaces() {
        let band = Band::<f64>::new(1e-6, 0.1);
        assert_eq!(classify(-1e-3, 0.0, &band), Subspace::Flight);
        assert_eq!(classify(1e-3, -5.0, &band), Subspace::Flight);
        assert_eq!(classify(1e-5, 60.0, &band), Subspace::Contact);
        assert_eq!(classify(-5e-7, 30.0, &band), Subspace::Entering);
        assert_eq!(classify(1e-5, 0.05, &band), Subspace::Leaving);
    }

    #[test]
    fn the_guard_keeps_the_damper_from_pulling() {
        let band = Band::new(1e-6, 0.0);
        // On the way out, inside the band: F = ki δ + ci δ̇ < 0, so nothing acts.
        assert_eq!(banded_force(&TABLE_3_1, 5e-7, -0.02, 0.08, &band), 0.0);
        // On the way in: the damper alone.
        assert_eq!(banded_force(&TABLE_3_1, 0.0, 0.08, 0.08, &band), 96.0);
    }
}
