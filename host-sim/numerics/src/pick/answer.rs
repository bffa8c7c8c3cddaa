//! The answer of a pick.

use std::f64::consts::TAU;

use serde::Serialize;
use shared::model::cart::LoopParams;
use shared::model::params::RigParams;
use shared::model::regime::Regime;

use super::bending::Bending;
use super::case::OrbitNumbers;
use super::sensitivity::Sensitivity;
use crate::branch::BranchEnd;
use crate::limits::LimitUse;
use crate::orbit::{Orbit, loop_force_n};
use crate::row::{CartModel, regime_as_text, tidy};
use crate::uncertainty::Uncertainty;

/// What the shaker must give at the operating point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ShakerNeed {
    /// Stroke, peak to peak, mm.
    pub stroke_mm: f64,
    /// Peak velocity A0 Ω, m/s.
    pub velocity_m_per_s: f64,
    /// Peak acceleration A0 Ω², m/s².
    pub acceleration_m_per_s2: f64,
    /// Peak force to move cart and hammer, (M + m) A0 Ω², N.
    pub force_n: f64,
    /// Mean power that contacts and the support's damping take, W.
    pub mean_power_w: f64,
    /// Peak of the reactive power, ½ (M + m) A0² Ω³, W.
    pub reactive_power_w: f64,
    /// Energy that a contact takes from the hammer, J.
    pub energy_per_blow_j: f64,
    /// Contacts per second.
    pub blows_per_second: f64,
    /// Largest force of the shaker's position loop over a period, N, the recoil from the contacts included. None with a
    /// prescribed cart.
    pub loop_force_n: Option<f64>,
}

impl ShakerNeed {
    /// What moves cart and hammer at `hz`, without what contacts and damping take.
    pub fn to_move(params: &RigParams, hz: f64) -> Self {
        let (amplitude, omega) = (params.amplitude_m, TAU * hz);
        let moved_kg = params.cart_mass_kg + params.mass_kg;
        Self {
            stroke_mm: tidy(2e3 * amplitude),
            velocity_m_per_s: amplitude * omega,
            acceleration_m_per_s2: amplitude * omega.powi(2),
            force_n: drive_force(params, hz),
            mean_power_w: 0.0,
            reactive_power_w: 0.5 * moved_kg * amplitude.powi(2) * omega.powi(3),
            energy_per_blow_j: 0.0,
            blows_per_second: hz,
            loop_force_n: None,
        }
    }
}

/// Where the hammer is worth most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BestPoint {
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// What is made largest: contact force, N, or rate of penetration, m/s.
    pub worth: f64,
    /// Contact force over m g.
    pub force_ratio: f64,
}

impl BestPoint {
    /// Of an orbit of a rig.
    pub fn of(orbit: &OrbitNumbers, params: &RigParams) -> Self {
        Self {
            frequency_hz: orbit.frequency_hz,
            worth: orbit.worth,
            force_ratio: orbit.force_n / params.weight_n(),
        }
    }
}

/// The operating point picked for a rig: how strong, how safe, and what it asks of the shaker.
#[derive(Clone, Debug, Serialize)]
pub struct PickAnswer {
    /// Name of the rig.
    pub rig: String,
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// How the cart is moved in this answer.
    pub cart: CartModel,
    /// Force ratio with a cart that recoils, where the nominal rig is strongest: within the limits asked for, without the
    /// uncertainty and without `shaker_max_force_n`, which a prescribed cart does not have. None where no shaker is known,
    /// or no stable 1/1 is within the limits.
    pub recoil_force_ratio: Option<f64>,
    /// The frequency of that, Hz.
    pub recoil_frequency_hz: Option<f64>,
    /// Force ratio with a prescribed cart, found likewise; none where no stable 1/1 is within the limits.
    pub prescribed_force_ratio: Option<f64>,
    /// The frequency of that, Hz.
    pub prescribed_frequency_hz: Option<f64>,
    /// The shaker whose cart recoils; none where none is known.
    #[serde(skip)]
    pub shaker_loop: Option<LoopParams>,
    /// The frequency to run at, Hz.
    pub operating_frequency_hz: f64,
    /// Operating frequency over the natural frequency.
    pub frequency_ratio: f64,
    /// The regime of the orbit picked, as a run that starts on it shows.
    #[serde(serialize_with = "regime_as_text")]
    pub regime: Regime,
    /// The regime a run from rest settles on there.
    #[serde(serialize_with = "regime_as_text")]
    pub regime_from_rest: Regime,
    /// Drive periods from rest after which the peak force stays within 1 % of `force_n`; none if a run from rest settles on
    /// another motion, or not within 480 periods.
    pub force_settling_cycles: Option<u32>,
    /// Time from rest after which the peak force stays within 1 % of `force_n`, s; none if it does not.
    pub force_settling_s: Option<f64>,
    /// Corners of the uncertainty.
    pub corners: usize,
    /// How many of them settle on 1/1 from rest there; the others need a push to get onto their orbit.
    pub corners_reaching_one_one_from_rest: usize,
    /// Contact force over m g there.
    pub force_ratio: f64,
    /// Largest contact force at the operating frequency, N.
    pub force_n: f64,
    /// Smallest force ratio over the uncertainty.
    pub force_ratio_worst: f64,
    /// Largest force ratio over the uncertainty.
    pub force_ratio_largest: f64,
    /// Speed at which the hammer meets the surface on the orbit picked, m/s.
    pub approach_speed_m_per_s: f64,
    /// How long the contact with the largest force lasts on the orbit picked, ms.
    pub contact_time_ms: f64,
    /// Where the nominal 1/1 is stable and its force above 90 % of that at the operating frequency, Hz.
    pub band_hz: [f64; 2],
    /// The part of it where 1/1 is stable over the whole uncertainty and every limit is kept, Hz.
    pub safe_band_hz: [f64; 2],
    /// How far the operating frequency lies above the lower end of the safe band, % of it.
    pub margin_below_percent: f64,
    /// How far it lies below the upper end, % of it.
    pub margin_above_percent: f64,
    /// Smallest force ratio over the uncertainty at either end of the safe band; none where a member has no stable 1/1.
    pub safe_band_force_ratio_worst: [Option<f64>; 2],
    /// Where the nominal 1/1 is stable, Hz.
    pub stable_one_one_hz: [f64; 2],
    /// How the stable 1/1 ends, below and above.
    pub stable_one_one_ends: [BranchEnd; 2],
    /// Where 1/1 is stable over the whole uncertainty, Hz.
    pub robust_band_hz: [f64; 2],
    /// Where the nominal 1/1 doubles its period, Hz; none if it ends otherwise.
    pub period_doubling_hz: Option<f64>,
    /// Largest modulus of the monodromy matrix's eigenvalues at the operating point.
    pub multipliers: f64,
    /// Largest modulus of the monodromy matrix's eigenvalues over the uncertainty, at the operating point.
    pub multipliers_worst: f64,
    /// Whether the hammer never jumps: up and down sweeps across the stable 1/1 give the same forces, and it does not end
    /// in a fold.
    pub jump_free: bool,
    /// Whether it does not inside the safe band.
    pub jump_free_in_safe_band: bool,
    /// The lowest and the highest frequency at which it jumps (sweeps differ, or the 1/1 folds), Hz; none where it never
    /// does.
    pub jump_range_hz: Option<[f64; 2]>,
    /// Best nominal frequency, no uncertainty and no limits, Hz.
    pub nominal_optimum_hz: f64,
    /// Contact force over m g at `nominal_optimum_hz`.
    pub nominal_optimum_force_ratio: f64,
    /// Impact power at the operating frequency: energy per contact times contacts per second, W.
    pub impact_power_w: f64,
    /// The frequency of the most impact power of the nominal stable 1/1, no uncertainty and no limits, Hz.
    pub power_optimum_hz: f64,
    /// The impact power there, W.
    pub power_optimum_w: f64,
    /// Force ratio when driven at the natural frequency (Ω = ω).
    pub force_ratio_at_natural_frequency: f64,
    /// What the shaker must give.
    pub shaker: ShakerNeed,
    /// Largest force of the shaker at the best nominal frequency with the rig's own amplitude, no limits, N.
    pub shaker_force_at_optimum_n: Option<f64>,
    /// Limits, and which decide.
    pub limits: Vec<LimitUse>,
    /// Change of the nominal optimum per 1 % of each parameter (gap: per 0.01 mm), largest force first.
    pub sensitivity: Vec<Sensitivity>,
    /// The uncertainty taken into account; `None` if none was given.
    pub uncertainty: Option<Uncertainty>,
    /// Cart amplitude A0 of the answer, mm.
    pub amplitude_mm: f64,
    /// The force for which it was chosen, N; none where it is the rig's.
    pub wanted_force_n: Option<f64>,
    /// Whether it is less than the rig's because no frequency keeps the limits of the shaker with the rig's.
    pub amplitude_lowered: bool,
    /// What the higher bending modes of beam springs change.
    #[serde(flatten)]
    pub bending: Bending,
}

/// Peak force to move cart and hammer at `hz`, (M + m) A0 Ω², N.
pub fn drive_force(params: &RigParams, hz: f64) -> f64 {
    (params.cart_mass_kg + params.mass_kg) * params.amplitude_m * (TAU * hz).powi(2)
}

/// Largest force of the shaker for `orbit`, N: of its position loop, the recoil included, or of a prescribed cart what moves
/// M + m.
pub fn shaker_force(params: &RigParams, orbit: &Orbit) -> f64 {
    loop_force_n(params, orbit).unwrap_or_else(|| drive_force(params, orbit.frequency_hz))
}

/// Energy that the contacts of `orbit` take from the hammer per second, W.
pub fn impact_power(orbit: &Orbit) -> f64 {
    orbit.contact.energy_lost_j * f64::from(orbit.impacts) * orbit.frequency_hz
}

/// What the shaker must give for `orbit`.
pub fn shaker(params: &RigParams, orbit: &Orbit) -> ShakerNeed {
    let need = ShakerNeed::to_move(params, orbit.frequency_hz);
    ShakerNeed {
        mean_power_w: orbit.energy_per_period_j * orbit.frequency_hz,
        energy_per_blow_j: orbit.contact.energy_lost_j,
        blows_per_second: f64::from(orbit.impacts) * orbit.frequency_hz,
        loop_force_n: loop_force_n(params, orbit),
        ..need
    }
}
