//! Families of periodic orbits followed by pseudo-arclength (H. B. Keller, "Numerical solution of bifurcation and
//! nonlinear eigenvalue problems", in: P. H. Rabinowitz (ed.), Applications of Bifurcation Theory, Academic Press,
//! 1977, 359–384), stable and unstable, round folds, to where a contact is gained or lost.
//!
//! - [`family`]: the equations: a fixed point of the return map, a frequency or gap, and a step along the curve.
//! - [`mod@march`]: steps from orbit to orbit, and what ends a curve.
//! - [`locate`]: period doublings, folds and grazes between two steps.
//! - [`switching`]: from a doubling onto the doubled orbits, and across a graze.
//! - [`mod@diagram`]: every curve that simulation at some frequencies finds, and what they lead to.
//! - [`curves`]: the special points of the 1/1 over gap and frequency.
//! - [`table`]: the results as tables.
//! - [`two`]: doublings, folds and grazes over two parameters, each as one continuation.
//!
//! # Why stable orbits lose stability in two ways only
//! Every contact and every damper takes area: det M = exp(−∫ damping) < 1. A complex pair of multipliers has
//! |μ|² = det M < 1, so it never leaves the unit circle; an orbit loses stability at μ = −1, at μ = +1, or where a
//! contact is gained or lost and M itself jumps.

pub mod curves;
pub mod diagram;
pub mod family;
pub mod locate;
pub mod march;
pub mod switching;
pub mod table;
pub mod two;

pub use diagram::{CurveOrigin, OrbitCurve, OrbitDiagram, OrbitsRequest, SettledRegime, diagram};
pub use family::{Along, Family, FamilyDrive, Node};
pub use march::{CurveEnd, Until, march};

/// What is special about an orbit on a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Special {
    /// A multiplier passes −1.
    PeriodDoubling,
    /// A multiplier passes +1: the curve turns back.
    Fold,
    /// The hammer just touches once more per orbit.
    GrazingGained,
    /// One of the contacts is about to be missed: its approach speed is 0.
    GrazingLost,
}

impl Special {
    /// Every kind, in the order of tables.
    pub const ALL: [Self; 4] = [
        Self::PeriodDoubling,
        Self::Fold,
        Self::GrazingGained,
        Self::GrazingLost,
    ];

    /// As tables write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::PeriodDoubling => "period_doubling",
            Self::Fold => "fold",
            Self::GrazingGained => "grazing_gained",
            Self::GrazingLost => "grazing_lost",
        }
    }

    /// As a person reads it.
    pub fn label(self) -> &'static str {
        match self {
            Self::PeriodDoubling => "period doubling",
            Self::Fold => "fold",
            Self::GrazingGained => "grazing, contact gained",
            Self::GrazingLost => "grazing, contact lost",
        }
    }
}
