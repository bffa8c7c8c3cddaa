//! The answer as lines of a table: one for each pick, and one for each point of its curve.

use numerics::pick::Pick;
use serde::Serialize;

/// A point of the nominal stable 1/1.
#[derive(Serialize)]
pub struct NominalCurveRow<'a> {
    rig: &'a str,
    gap_mm: f64,
    frequency_hz: f64,
    force_ratio: f64,
}

/// The points of the nominal stable 1/1.
pub fn curve_rows(pick: &Pick) -> Vec<NominalCurveRow<'_>> {
    let answer = &pick.answer;
    let rows = pick
        .curve
        .iter()
        .map(|(frequency_hz, force_ratio)| NominalCurveRow {
            rig: &answer.rig,
            gap_mm: answer.gap_mm,
            frequency_hz: *frequency_hz,
            force_ratio: *force_ratio,
        });
    rows.collect()
}

/// The columns of an answer as a line of a table.
pub const COLUMNS: &[&str] = &[
    "rig",
    "gap_mm",
    "operating_frequency_hz",
    "frequency_ratio",
    "regime",
    "force_ratio",
    "force_n",
    "force_ratio_worst",
    "band_low_hz",
    "band_high_hz",
    "safe_band_low_hz",
    "safe_band_high_hz",
    "period_doubling_hz",
    "multipliers",
    "jump_free",
    "force_ratio_at_natural_frequency",
    "energy_per_blow_j",
    "blows_per_second",
    "cart",
    "recoil_force_ratio",
    "recoil_frequency_hz",
    "prescribed_force_ratio",
    "prescribed_frequency_hz",
    "amplitude_mm",
    "loop_force_n",
    "modes",
    "modes_force_ratio",
    "modes_force_ratio_worst",
    "one_mode_safe_band_low_hz",
    "one_mode_safe_band_high_hz",
];
