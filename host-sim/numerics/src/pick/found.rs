//! What was found, as the answer for tables and text.

use super::answer::{PickAnswer, StrongestPoint, impact_power, shaker, shaker_force};
use super::bending::{Bending, on_beams};
use super::choose::ChosenOrbit;
use super::range;
use super::runs::Runs;
use super::sensitivity::Sensitivity;
use crate::branch::{Branch, BranchEnd};
use crate::orbit::Orbit;
use crate::row::CartModel;
use crate::row::{NamedRig, tidy};
use crate::uncertainty::Uncertainty;

/// The part of the band that uncertainty and limits allow.
pub(super) struct SafeBand {
    pub(super) hz: (f64, f64),
    /// Smallest force ratio over the uncertainty at its ends.
    pub(super) force_ratio_worst: [Option<f64>; 2],
}

/// Everything the answer is made of.
pub(super) struct PickParts<'a> {
    pub(super) rig: &'a NamedRig,
    pub(super) branch: &'a Branch,
    /// The strongest nominal orbit, without uncertainty and limits.
    pub(super) nominal: &'a Orbit,
    /// The nominal orbit with the most impact power, without uncertainty and limits.
    pub(super) power: &'a Orbit,
    /// Where 1/1 is stable over the whole uncertainty, Hz.
    pub(super) robust: (f64, f64),
    /// [`force_band`] of the orbit chosen.
    pub(super) band: (f64, f64),
    pub(super) safe_band: SafeBand,
    /// How strong the nominal rig is with its cart and with the other one: [`super::comparable`].
    pub(super) own: StrongestPoint,
    pub(super) other: Option<StrongestPoint>,
    pub(super) choice: ChosenOrbit,
    /// [`Jumps::at_hz`].
    pub(super) jumps: &'a [f64],
    pub(super) runs: Runs,
    pub(super) sensitivity: Vec<Sensitivity>,
    pub(super) uncertainty: Option<Uncertainty>,
    pub(super) bending: Option<Bending>,
}

impl PickParts<'_> {
    /// The answer for tables and text.
    pub(super) fn answer(self) -> PickAnswer {
        let params = &self.rig.params;
        let weight = params.weight_n();
        let chosen = &self.choice.orbit;
        let spread = &self.choice.spread;
        let (band, safe_band) = (self.band, self.safe_band.hz);
        let cart = CartModel::of(params);
        let (recoil, prescribed) = match cart {
            CartModel::Recoil => (Some(self.own), self.other),
            CartModel::Prescribed => (self.other, Some(self.own)),
        };
        let in_band = |hz: &f64| (safe_band.0..=safe_band.1).contains(hz);
        let doubles = self.branch.high.end == BranchEnd::PeriodDoubling;
        PickAnswer {
            rig: self.rig.name.clone(),
            gap_mm: tidy(params.gap_m * 1e3),
            cart,
            recoil_force_ratio: recoil.map(|s| s.force_ratio),
            recoil_frequency_hz: recoil.map(|s| s.frequency_hz),
            prescribed_force_ratio: prescribed.map(|s| s.force_ratio),
            prescribed_frequency_hz: prescribed.map(|s| s.frequency_hz),
            shaker_loop: self.rig.shaker,
            operating_frequency_hz: chosen.frequency_hz,
            frequency_ratio: chosen.frequency_hz / params.natural_frequency_hz(),
            regime: self.runs.on_orbit,
            regime_from_rest: self.runs.from_rest,
            force_settling_cycles: self.runs.settling_cycles,
            force_settling_s: self
                .runs
                .settling_cycles
                .map(|n| f64::from(n) / chosen.frequency_hz),
            corners: self.runs.corners,
            corners_reaching_one_one_from_rest: self.runs.corners_reaching,
            force_ratio: chosen.force_n / weight,
            force_n: chosen.force_n,
            force_ratio_worst: spread.weakest_n / weight,
            force_ratio_largest: spread.strongest_n / weight,
            approach_speed_m_per_s: chosen.contact.approach_speed_m_per_s,
            contact_time_ms: chosen.contact.duration_s * 1e3,
            band_hz: band.into(),
            safe_band_hz: safe_band.into(),
            margin_below_percent: 100.0 * (1.0 - safe_band.0 / chosen.frequency_hz),
            margin_above_percent: 100.0 * (safe_band.1 / chosen.frequency_hz - 1.0),
            safe_band_force_ratio_worst: self.safe_band.force_ratio_worst,
            stable_one_one_hz: range(self.branch).into(),
            stable_one_one_ends: [self.branch.low.end, self.branch.high.end],
            robust_band_hz: self.robust.into(),
            period_doubling_hz: doubles.then_some(self.branch.high.frequency_hz),
            multipliers: chosen.multipliers().modulus(),
            multipliers_worst: spread.multiplier,
            jump_free: self.jumps.is_empty(),
            jump_free_in_safe_band: !self.jumps.iter().any(in_band),
            jump_range_hz: self
                .jumps
                .first()
                .zip(self.jumps.last())
                .map(|(low, high)| [*low, *high]),
            nominal_optimum_hz: self.nominal.frequency_hz,
            nominal_optimum_force_ratio: self.nominal.force_n / weight,
            impact_power_w: impact_power(chosen),
            power_optimum_hz: self.power.frequency_hz,
            power_optimum_w: impact_power(self.power),
            force_ratio_at_natural_frequency: self.runs.force_ratio_at_natural,
            shaker: shaker(self.rig, chosen),
            shaker_force_at_optimum_n: Some(shaker_force(params, self.nominal)),
            limits: self.choice.limits,
            sensitivity: self.sensitivity,
            uncertainty: self.uncertainty,
            amplitude_mm: tidy(params.amplitude_m * 1e3),
            amplitude_lowered: false,
            wanted_force_n: None,
            bending: self.bending.unwrap_or_else(|| Bending {
                on_beams: on_beams(params),
                ..Bending::default()
            }),
        }
    }
}
