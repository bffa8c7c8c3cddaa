//! Period doublings, folds and grazes over two parameters, each as one continuation.
//!
//! A special point is an orbit with a condition: a multiplier of −1, a multiplier of +1, or a contact that just touches.
//! With both parameters free the orbits that keep the condition are a curve again. It is followed by pseudo-arclength in
//! everything at once (the orbit's section point and both parameters), so it may turn back in either parameter.
//!
//! - [`plane`]: the two parameters.
//! - `conditions`: the equations of an orbit with its condition.
//! - `graze`: those of an orbit that touches once without a blow.
//! - `newton`: the next point of a curve.
//! - `follow`: steps from point to point, and what ends a curve.
//! - `marks`: points of codimension two on a curve.
//! - [`starts`]: special points of one-parameter curves, from which the curves begin.
//! - [`request`]: what is asked for, and the way to the answer.
//! - [`table`]: the results as tables.

mod conditions;
mod follow;
mod graze;
mod marks;
mod newton;
pub mod plane;
pub mod request;
pub mod starts;
pub mod table;
#[cfg(test)]
mod tests;

use nalgebra::DVector;
use serde::Serialize;
use shared::model::params::RigParams;

use super::CurveEnd;
use super::march::ContactMargins;
use crate::reference::LocatedContact;
use conditions::System;

pub use follow::{follow, followed};
pub use plane::{Dimension, Plane, Scale, Varied};
pub use request::CurvesRequest;
pub use starts::{Seed, seeds};

/// What holds along a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Condition {
    /// A multiplier is −1.
    PeriodDoubling,
    /// A multiplier is +1.
    Fold,
    /// The hammer touches once per orbit without a blow.
    Grazing,
}

impl Condition {
    /// Every kind, in the order of tables.
    pub const ALL: [Self; 3] = [Self::PeriodDoubling, Self::Fold, Self::Grazing];

    /// As tables write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::PeriodDoubling => "period_doubling",
            Self::Fold => "fold",
            Self::Grazing => "grazing",
        }
    }

    /// As a person reads it.
    pub fn label(self) -> &'static str {
        match self {
            Self::PeriodDoubling => "period doubling",
            Self::Fold => "fold",
            Self::Grazing => "grazing",
        }
    }
}

/// A point at which a curve has a second condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Codimension {
    /// Two folds meet and end, in a point of the plane.
    Cusp,
    /// One multiplier is +1 and another −1.
    FoldDoubling,
    /// Two multipliers are +1 (with a cart that recoils).
    Resonance,
    /// A fold and a graze.
    FoldGraze,
    /// A period doubling and a graze.
    DoublingGraze,
    /// A second contact grazes, too.
    DoubleGraze,
    /// Where the hammer touches, nothing draws it away any more.
    PressedGraze,
}

impl Codimension {
    /// As a person reads it.
    pub fn label(self) -> &'static str {
        match self {
            Self::Cusp => "cusp of two folds",
            Self::FoldDoubling => "fold and doubling",
            Self::Resonance => "1:1 resonance",
            Self::FoldGraze => "fold and graze",
            Self::DoublingGraze => "doubling and graze",
            Self::DoubleGraze => "second graze",
            Self::PressedGraze => "graze without rebound",
        }
    }
}

/// A point of a curve.
#[derive(Clone, Debug, PartialEq)]
pub struct TwoParameterPoint {
    /// The rig with the point's values of the parameters.
    pub params: RigParams,
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// The values of the two parameters, in their own units.
    pub values: [f64; 2],
    /// Coordinate and rate of the hammer at drive phase 0.
    pub section: [f64; 2],
    /// Contacts of the orbit; on a graze without the touch.
    pub impacts: u16,
    /// Largest contact force, N: 0 without contact.
    pub force_n: f64,
    /// The two leading multipliers; on a graze those of the side without the touch.
    pub multipliers: [(f64, f64); 2],
    /// What second condition it has.
    pub mark: Option<Codimension>,
    /// The unknowns: those of the orbit, then the places of both parameters.
    x: DVector<f64>,
    /// The curve's direction, of length 1.
    tangent: DVector<f64>,
    /// det(I + M), det(I − M), and the slope of det(λI − M) at λ = 1.
    tests: [f64; 3],
    /// Of a graze: how the surface is left, −δ̈ over A0 Ω².
    leaving: Option<f64>,
    /// Onsets of the contacts, drive periods after drive phase 0.
    onsets: Vec<f64>,
    /// Of a graze: the contacts from the touch on.
    flights: Option<Vec<LocatedContact>>,
    margins: ContactMargins,
}

impl TwoParameterPoint {
    /// The two parameters as unknowns.
    fn parameters(&self) -> [f64; 2] {
        let n = self.x.len();
        [self.x[n - 2], self.x[n - 1]]
    }

    fn turned(mut self) -> Self {
        self.tangent.neg_mut();
        self
    }
}

/// A curve over two parameters, along which one condition holds.
#[derive(Clone, Debug)]
pub struct TwoParameterCurve {
    /// What holds along it.
    pub condition: Condition,
    /// Drive periods of its orbits.
    pub periods: u8,
    /// Its points, in order along it.
    pub points: Vec<TwoParameterPoint>,
    /// How it ends, at the first and at the last point.
    pub ends: [CurveEnd; 2],
    system: System,
}

impl TwoParameterCurve {
    /// Contacts of its orbits; on a graze without the touch.
    pub fn impacts(&self) -> u16 {
        self.points.first().map_or(0, |p| p.impacts)
    }

    /// The points with a second condition.
    pub fn marks(&self) -> impl Iterator<Item = (&TwoParameterPoint, Codimension)> {
        self.points.iter().filter_map(|p| Some((p, p.mark?)))
    }
}
