//! `pick --objective rop` as a line of a table.

use numerics::CartModel;
use numerics::drill::pick::RopPick;
use serde::Serialize;

/// The answer as one CSV line. What every pick has, has the name that it has there.
#[derive(Serialize)]
pub struct RopLine<'a> {
    rig: &'a str,
    gap_mm: f64,
    objective: &'a str,
    threshold_n: f64,
    ground_stiffness_n_per_m: f64,
    ground_damping_n_s_per_m: f64,
    operating_frequency_hz: f64,
    frequency_ratio: f64,
    rate_of_penetration_um_per_s: f64,
    rate_worst_um_per_s: f64,
    rate_largest_um_per_s: f64,
    progress_per_blow_um: f64,
    energy_per_blow_mj: f64,
    share_into_progress: f64,
    feed_needed_mm_per_s: f64,
    force_ratio: f64,
    force_n: f64,
    band_low_hz: f64,
    band_high_hz: f64,
    safe_band_low_hz: f64,
    safe_band_high_hz: f64,
    period_doubling_hz: Option<f64>,
    multipliers: f64,
    jump_free: bool,
    cart: CartModel,
    force_optimum_hz: Option<f64>,
    force_optimum_rate_um_per_s: Option<f64>,
    recoil_frequency_hz: Option<f64>,
    recoil_rate_um_per_s: Option<f64>,
    prescribed_frequency_hz: Option<f64>,
    prescribed_rate_um_per_s: Option<f64>,
    amplitude_mm: f64,
    loop_force_n: Option<f64>,
    bit_mass_kg: Option<f64>,
    bit_feed_force_n: Option<f64>,
}

impl<'a> From<&'a RopPick> for RopLine<'a> {
    fn from(pick: &'a RopPick) -> Self {
        let (a, g) = (&pick.answer, &pick.ground);
        Self {
            rig: &a.rig,
            gap_mm: a.gap_mm,
            objective: g.objective,
            threshold_n: g.threshold_n,
            ground_stiffness_n_per_m: g.ground_stiffness_n_per_m,
            ground_damping_n_s_per_m: g.ground_damping_n_s_per_m,
            operating_frequency_hz: a.operating_frequency_hz,
            frequency_ratio: a.frequency_ratio,
            rate_of_penetration_um_per_s: g.rate_of_penetration_um_per_s,
            rate_worst_um_per_s: g.rate_worst_um_per_s,
            rate_largest_um_per_s: g.rate_largest_um_per_s,
            progress_per_blow_um: g.progress_per_blow_um,
            energy_per_blow_mj: g.energy_per_blow_mj,
            share_into_progress: g.share_into_progress,
            feed_needed_mm_per_s: g.feed_needed_mm_per_s,
            force_ratio: a.force_ratio,
            force_n: a.force_n,
            band_low_hz: a.band_hz[0],
            band_high_hz: a.band_hz[1],
            safe_band_low_hz: a.safe_band_hz[0],
            safe_band_high_hz: a.safe_band_hz[1],
            period_doubling_hz: a.period_doubling_hz,
            multipliers: a.multipliers,
            jump_free: a.jump_free,
            cart: a.cart,
            force_optimum_hz: g.force_optimum_hz,
            force_optimum_rate_um_per_s: g.force_optimum_rate_um_per_s,
            recoil_frequency_hz: a.recoil_frequency_hz,
            recoil_rate_um_per_s: g.recoil_rate_um_per_s,
            prescribed_frequency_hz: a.prescribed_frequency_hz,
            prescribed_rate_um_per_s: g.prescribed_rate_um_per_s,
            amplitude_mm: a.amplitude_mm,
            loop_force_n: a.shaker.loop_force_n,
            bit_mass_kg: g.bit_mass_kg,
            bit_feed_force_n: g.bit_feed_force_n,
        }
    }
}
