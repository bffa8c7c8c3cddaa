//! The answer as lines of a table: one for each pick, and one for each point of its curve.

use numerics::CartModel;
use numerics::pick::{Answer, Pick};
use numerics::row::regime_as_text;
use serde::Serialize;
use shared::model::regime::Regime;

/// A point of the nominal stable 1/1.
#[derive(Serialize)]
pub struct CurveRow<'a> {
    rig: &'a str,
    gap_mm: f64,
    frequency_hz: f64,
    force_ratio: f64,
}

/// The points of the nominal stable 1/1.
pub fn curve_rows(pick: &Pick) -> Vec<CurveRow<'_>> {
    let answer = &pick.answer;
    let rows = pick
        .curve
        .iter()
        .map(|(frequency_hz, force_ratio)| CurveRow {
            rig: &answer.rig,
            gap_mm: answer.gap_mm,
            frequency_hz: *frequency_hz,
            force_ratio: *force_ratio,
        });
    rows.collect()
}

/// The answer as one CSV line.
#[derive(Serialize)]
pub struct Line<'a> {
    rig: &'a str,
    gap_mm: f64,
    operating_frequency_hz: f64,
    frequency_ratio: f64,
    #[serde(serialize_with = "regime_as_text")]
    regime: Regime,
    force_ratio: f64,
    force_n: f64,
    force_ratio_worst: f64,
    band_low_hz: f64,
    band_high_hz: f64,
    safe_band_low_hz: f64,
    safe_band_high_hz: f64,
    period_doubling_hz: Option<f64>,
    multipliers: f64,
    jump_free: bool,
    force_ratio_at_natural_frequency: f64,
    energy_per_blow_j: f64,
    blows_per_second: f64,
    cart: CartModel,
    recoil_force_ratio: Option<f64>,
    recoil_frequency_hz: Option<f64>,
    prescribed_force_ratio: Option<f64>,
    prescribed_frequency_hz: Option<f64>,
    amplitude_mm: f64,
    loop_force_n: Option<f64>,
    modes: Option<usize>,
    modes_force_ratio: Option<f64>,
    modes_force_ratio_worst: Option<f64>,
    one_mode_safe_band_low_hz: Option<f64>,
    one_mode_safe_band_high_hz: Option<f64>,
}

impl<'a> From<&'a Answer> for Line<'a> {
    fn from(a: &'a Answer) -> Self {
        Self {
            rig: &a.rig,
            gap_mm: a.gap_mm,
            operating_frequency_hz: a.operating_frequency_hz,
            frequency_ratio: a.frequency_ratio,
            regime: a.regime,
            force_ratio: a.force_ratio,
            force_n: a.force_n,
            force_ratio_worst: a.force_ratio_worst,
            band_low_hz: a.band_hz[0],
            band_high_hz: a.band_hz[1],
            safe_band_low_hz: a.safe_band_hz[0],
            safe_band_high_hz: a.safe_band_hz[1],
            period_doubling_hz: a.period_doubling_hz,
            multipliers: a.multipliers,
            jump_free: a.jump_free,
            force_ratio_at_natural_frequency: a.force_ratio_at_natural_frequency,
            energy_per_blow_j: a.shaker.energy_per_blow_j,
            blows_per_second: a.shaker.blows_per_second,
            cart: a.cart,
            recoil_force_ratio: a.recoil_force_ratio,
            recoil_frequency_hz: a.recoil_frequency_hz,
            prescribed_force_ratio: a.prescribed_force_ratio,
            prescribed_frequency_hz: a.prescribed_frequency_hz,
            amplitude_mm: a.amplitude_mm,
            loop_force_n: a.shaker.loop_force_n,
            modes: a.bending.modes,
            modes_force_ratio: a.bending.modes_force_ratio,
            modes_force_ratio_worst: a.bending.modes_force_ratio_worst,
            one_mode_safe_band_low_hz: a.bending.one_mode_safe_band_hz.map(|hz| hz[0]),
            one_mode_safe_band_high_hz: a.bending.one_mode_safe_band_hz.map(|hz| hz[1]),
        }
    }
}
