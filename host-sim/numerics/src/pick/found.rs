//! What was found, as the answer for tables and text.

use super::answer::{BestPoint, PickAnswer};
use super::bending::{Bending, on_beams};
use super::case::PickCase;
use super::choose::ChosenOrbit;
use super::robust::Robust;
use super::runs::{Jumps, Runs};
use super::search::Spread;
use super::sensitivity::Sensitivity;
use crate::branch::{Branch, BranchEnd};
use crate::row::CartModel;
use crate::row::{NamedRig, tidy};
use crate::uncertainty::Uncertainty;

/// Everything the answer is made of.
pub(crate) struct PickParts<C: PickCase> {
    pub(crate) rig: NamedRig,
    pub(crate) branch: Branch<C>,
    /// The best nominal orbit, without uncertainty and limits.
    pub(crate) nominal: C::Orbit,
    /// The nominal orbit with the most impact power, without uncertainty and limits.
    pub(crate) power: C::Orbit,
    /// What it is worth over frequency: (Hz, worth).
    pub(crate) curve: Vec<(f64, f64)>,
    pub(crate) robust: Robust<C>,
    /// [`super::worth_band`] of the orbit chosen.
    pub(crate) band: (f64, f64),
    /// The part of that band that uncertainty and limits allow.
    pub(crate) safe_band: (f64, f64),
    /// What is spread over the uncertainty at its ends.
    pub(crate) safe_spread: [Option<Spread>; 2],
    /// The best of the nominal rig with its cart and with the other one: [`super::comparable`].
    pub(crate) own: BestPoint,
    pub(crate) other: Option<BestPoint>,
    pub(crate) choice: ChosenOrbit<C>,
    pub(crate) jumps: Jumps,
    pub(crate) runs: Runs,
    pub(crate) sensitivity: Vec<Sensitivity>,
    pub(crate) uncertainty: Option<Uncertainty>,
    pub(crate) bending: Option<Bending>,
}

impl<C: PickCase> PickParts<C> {
    /// The best with a cart that recoils, and with one that moves as prescribed.
    pub(crate) fn by_cart(&self) -> [Option<BestPoint>; 2] {
        CartModel::of(&self.rig.params).sorted(Some(self.own), self.other)
    }

    /// The answer for tables and text.
    pub(crate) fn answer(&self) -> PickAnswer {
        let params = &self.rig.params;
        let weight = params.weight_n();
        let [chosen, nominal, power] =
            [&self.choice.orbit, &self.nominal, &self.power].map(C::numbers_of);
        let spread = &self.choice.spread;
        let (band, safe_band) = (self.band, self.safe_band);
        let cart = CartModel::of(params);
        let [recoil, prescribed] = self.by_cart();
        let jumps = &self.jumps.at_hz;
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
            approach_speed_m_per_s: self.runs.approach_speed_m_per_s,
            contact_time_ms: self.runs.contact_s * 1e3,
            band_hz: band.into(),
            safe_band_hz: safe_band.into(),
            margin_below_percent: 100.0 * (1.0 - safe_band.0 / chosen.frequency_hz),
            margin_above_percent: 100.0 * (safe_band.1 / chosen.frequency_hz - 1.0),
            safe_band_force_ratio_worst: self.safe_spread.map(|s| Some(s?.weakest_n / weight)),
            stable_one_one_hz: self.branch.range().into(),
            stable_one_one_ends: [self.branch.low.end, self.branch.high.end],
            robust_band_hz: self.robust.hz.into(),
            period_doubling_hz: doubles.then_some(self.branch.high.frequency_hz),
            multipliers: chosen.multiplier,
            multipliers_worst: spread.multiplier,
            jump_free: jumps.is_empty(),
            jump_free_in_safe_band: !jumps.iter().any(in_band),
            jump_range_hz: jumps
                .first()
                .zip(jumps.last())
                .map(|(low, high)| [*low, *high]),
            nominal_optimum_hz: nominal.frequency_hz,
            nominal_optimum_force_ratio: nominal.force_n / weight,
            impact_power_w: chosen.impact_power_w,
            power_optimum_hz: power.frequency_hz,
            power_optimum_w: power.impact_power_w,
            force_ratio_at_natural_frequency: self.runs.force_ratio_at_natural,
            shaker: self.runs.shaker,
            shaker_force_at_optimum_n: Some(self.branch.case.shaker_force_n(&self.nominal)),
            limits: self.choice.limits.clone(),
            sensitivity: self.sensitivity.clone(),
            uncertainty: self.uncertainty,
            amplitude_mm: tidy(params.amplitude_m * 1e3),
            amplitude_lowered: false,
            wanted_force_n: None,
            bending: self.bending.clone().unwrap_or_else(|| Bending {
                on_beams: on_beams(params),
                ..Bending::default()
            }),
        }
    }
}
