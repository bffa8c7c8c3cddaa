//! A section as one answer.

use serde::Serialize;

use super::{Portrait, SectionRequest};
use crate::lyapunov::Exponents;
use crate::row::CartModel;
use crate::row::{Outcome, tidy};

/// What a section showed. Units are in the names.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SectionAnswer {
    /// Name of the rig.
    pub rig: String,
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// How the cart is moved.
    pub cart: CartModel,
    /// Drive frequency Ω/2π, Hz.
    pub frequency_hz: f64,
    /// Drive frequency over the natural frequency, Ω/ω.
    pub frequency_ratio: f64,
    /// Regime over all recorded periods, or that nothing repeats and the motion still changes.
    pub regime: Outcome,
    /// Largest contact force, N.
    pub force_n: f64,
    /// Largest contact force over m g.
    pub force_ratio: f64,
    /// Points of each section.
    pub points: u32,
    /// Drive periods before the first point.
    pub transient: u32,
    /// Drive phases of the sections, turns.
    pub phases_turns: Vec<f64>,
    /// Steps of the integrator per drive period.
    pub steps_per_period: f64,
    /// The Lyapunov exponents, if they were asked for.
    pub lyapunov: Option<Exponents>,
    /// What their sign says.
    pub meaning: Option<&'static str>,
}

impl SectionAnswer {
    /// Of the `portrait` made for `request` of the rig called `rig`.
    pub fn new(
        rig: &str,
        request: &SectionRequest,
        portrait: &Portrait,
        exponents: Option<Exponents>,
    ) -> Self {
        let params = &request.params;
        Self {
            rig: rig.to_owned(),
            gap_mm: tidy(params.gap_m * 1e3),
            cart: CartModel::of(params),
            frequency_hz: tidy(request.frequency_hz),
            frequency_ratio: tidy(request.frequency_hz / params.natural_frequency_hz()),
            regime: portrait.outcome(),
            force_n: portrait.force_n,
            force_ratio: portrait.force_n / params.weight_n(),
            points: request.points,
            transient: request.transient,
            phases_turns: request.phases.clone(),
            steps_per_period: portrait.steps_per_period,
            meaning: exponents.as_ref().map(Exponents::meaning),
            lyapunov: exponents,
        }
    }
}
