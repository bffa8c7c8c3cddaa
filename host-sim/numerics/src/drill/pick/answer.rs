//! What a pick for the best rate of penetration says beside what every pick says.

use serde::Serialize;
use shared::model::cart::CartDrive;

use super::super::orbit::DrillOrbit;
use super::super::search::GroundUncertainty;
use super::branch::DrillCase;
use crate::parallel;
use crate::uncertainty::Uncertainty;

/// The answer about the ground. Units are in the names.
#[derive(Clone, Debug, Serialize)]
pub struct OnGround {
    /// What was made largest: "rop", the rate of penetration.
    pub objective: &'static str,
    /// Threshold force Pf at which the ground gives way, N.
    pub threshold_n: f64,
    /// Stiffness k of the ground, N/m.
    pub ground_stiffness_n_per_m: f64,
    /// Damping c of the ground, N·s/m.
    pub ground_damping_n_s_per_m: f64,
    /// Mass m_b of the bit, kg; none without a bit.
    pub bit_mass_kg: Option<f64>,
    /// Static feed force W on the bit, N; none without a bit.
    pub bit_feed_force_n: Option<f64>,
    /// How far the ground is unknown; none if it was taken as exact.
    #[serde(flatten)]
    pub uncertain: Option<GroundUncertainty>,
    /// Rate of penetration at the operating frequency, µm/s.
    pub rate_of_penetration_um_per_s: f64,
    /// Smallest rate of penetration over the uncertainty of rig and ground, µm/s.
    pub rate_worst_um_per_s: f64,
    /// Largest rate of penetration over the uncertainty of rig and ground, µm/s.
    pub rate_largest_um_per_s: f64,
    /// Smallest rate of penetration at either end of the safe band, µm/s; none where a member has no stable 1/1.
    pub safe_band_rate_worst_um_per_s: [Option<f64>; 2],
    /// Progress per blow, µm.
    pub progress_per_blow_um: f64,
    /// Energy that a blow takes from the hammer, mJ.
    pub energy_per_blow_mj: f64,
    /// Share of it that goes into progress.
    pub share_into_progress: f64,
    /// The feed that keeps the gap, mm/s.
    pub feed_needed_mm_per_s: f64,
    /// The largest rate of the nominal stable 1/1, no uncertainty and no limits, µm/s.
    pub nominal_optimum_rate_um_per_s: f64,
    /// The frequency at which a surface that stays is struck hardest (nominal, same cart), Hz. None where it has no stable
    /// 1/1.
    pub force_optimum_hz: Option<f64>,
    /// Rate of penetration there, µm/s; none where it is no stable 1/1 on this ground.
    pub force_optimum_rate_um_per_s: Option<f64>,
    /// Largest rate with a cart that recoils, nominal and without a limit of the shaker, µm/s; its frequency is
    /// `recoil_frequency_hz`.
    pub recoil_rate_um_per_s: Option<f64>,
    /// Largest nominal rate with the cart as prescribed, µm/s; its frequency is `prescribed_frequency_hz`.
    pub prescribed_rate_um_per_s: Option<f64>,
    /// Change of the rate at the operating frequency per 1 % of each parameter (gap: per 0.01 mm), most open first.
    pub rate_sensitivity: Vec<RateSensitivity>,
}

/// Change of the rate of penetration with one parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RateSensitivity {
    /// Name of the parameter that is changed.
    pub parameter: &'static str,
    /// The change it is per: "1 %" of the parameter, or "0.01 mm" of gap.
    pub per: &'static str,
    /// Change of the rate, %.
    pub rate_percent: f64,
    /// How well it is known, in the unit of `per`; none where no uncertainty is stated.
    pub known_to: Option<f64>,
    /// How far the rate is uncertain because of it, % either way, as far as it is linear.
    pub rate_over_uncertainty_percent: Option<f64>,
}

/// A parameter, what it is changed by, and how.
type Change = (&'static str, &'static str, fn(&mut DrillCase, f64));

/// By so many percent (or 0.01 mm) either way differences are taken.
const BY: f64 = 0.1;

const CHANGES: [Change; 10] = [
    ("threshold_n", "1 %", |c, s| {
        c.setting.ground.threshold *= 1.0 + s
    }),
    (
        "ground_stiffness_n_per_m (with its damping)",
        "1 %",
        |c, s| {
            c.setting.ground.stiffness *= 1.0 + s;
            c.setting.ground.damping *= 1.0 + s;
        },
    ),
    ("ground_damping_n_s_per_m", "1 %", |c, s| {
        c.setting.ground.damping *= 1.0 + s;
    }),
    ("natural_frequency_hz", "1 %", |c, s| {
        c.params = c.params.with_natural_frequency_scaled(1.0 + s);
    }),
    ("amplitude_mm", "1 %", |c, s| {
        c.params.amplitude_m *= 1.0 + s
    }),
    ("mass_kg (same natural frequency)", "1 %", |c, s| {
        c.params.mass_kg *= 1.0 + s;
    }),
    ("cart_mass_kg", "1 %", |c, s| {
        c.params.cart_mass_kg *= 1.0 + s
    }),
    ("shaker_loop_hz", "1 %", |c, s| {
        if let CartDrive::Loop(held) = &mut c.params.cart {
            held.frequency_hz *= 1.0 + s;
        }
    }),
    ("bit_mass_kg", "1 %", |c, s| {
        if let Some(bit) = &mut c.setting.bit {
            bit.mass *= 1.0 + s;
        }
    }),
    // 0.01 mm for each percent.
    ("gap_mm", "0.01 mm", |c, s| c.params.gap_m += 1e-3 * s),
];

/// Change of the rate of `orbit` with each parameter, the one that leaves it most open first.
pub fn rate_sensitivity(
    case: &DrillCase,
    orbit: &DrillOrbit,
    uncertainty: Option<Uncertainty>,
    ground: GroundUncertainty,
) -> Vec<RateSensitivity> {
    let known = |name: &str| {
        let u = uncertainty?;
        Some(match name {
            "threshold_n" => ground.threshold_percent,
            "natural_frequency_hz" => u.natural_frequency_percent,
            "amplitude_mm" => u.amplitude_percent,
            "cart_mass_kg" => u.cart_mass_percent,
            "shaker_loop_hz" => u.shaker_loop_percent,
            "gap_mm" => u.gap_mm / 0.01,
            "ground_damping_n_s_per_m" | "bit_mass_kg" => return None,
            name if name.starts_with("ground_stiffness") => ground.ground_stiffness_percent,
            _ => u.mass_percent,
        })
    };
    let of_recoil = ["cart_mass_kg", "shaker_loop_hz"];
    let rows = parallel::map(&CHANGES, |(parameter, per, change)| {
        if of_recoil.contains(parameter) && !case.params.cart.recoils() {
            return None;
        }
        if *parameter == "bit_mass_kg" && case.setting.bit.is_none() {
            return None;
        }
        let rate = |by: f64| {
            let mut moved = *case;
            change(&mut moved, 0.01 * by);
            let found = moved.orbit(orbit.frequency_hz, orbit.section);
            found.map(|o| o.rate_m_per_s())
        };
        let slope = (rate(BY)? - rate(-BY)?) / (2.0 * BY);
        let rate_percent = 100.0 * slope / orbit.rate_m_per_s();
        let known_to = known(parameter);
        Some(RateSensitivity {
            parameter,
            per,
            rate_percent,
            known_to,
            rate_over_uncertainty_percent: known_to.map(|width| width * rate_percent.abs()),
        })
    });
    let mut rows: Vec<_> = rows.into_iter().flatten().collect();
    let open = |row: &RateSensitivity| {
        let over = row.rate_over_uncertainty_percent;
        (over.unwrap_or(0.0), row.rate_percent.abs())
    };
    rows.sort_by(|a, b| {
        let ((x, s), (y, t)) = (open(a), open(b));
        y.total_cmp(&x).then(t.total_cmp(&s))
    });
    rows
}
