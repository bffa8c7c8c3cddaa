//! Which frequency to run the hammer at for the largest rate of penetration: [`crate::pick`] with another objective, on
//! ground that gives way instead of the surface that stays.
//!
//! The stable 1/1 on the ground is followed over frequency by its multipliers ([`branch`]). What is left of it for every
//! member of the uncertainty of rig and ground ([`members`]) and within the limits is searched for the largest nominal
//! rate. [`crate::pick::PickAnswer`] carries what every pick says, its forces and bands being those on the ground (the band is
//! where the rate is above 90 % of that chosen); [`answer::OnGround`] carries the rest.

pub mod answer;
pub mod branch;
mod field;
pub mod members;
mod observe;

use std::f64::consts::TAU;

use shared::model::bit::Bit;
use shared::model::slider::Slider;

use self::answer::{OnGround, rate_sensitivity};
use self::branch::{DrillCase, GroundBranch};
use self::field::DrillField;
use self::members::{Crowd, with_ground};
use self::observe::{Observed, jumps, seed};
use super::orbit::DrillOrbit;
use super::search::GroundUncertainty;
use crate::branch::BranchEnd;
use crate::error::{Error, PickError};
use crate::limits::PickLimits;
use crate::pick::amplitude::lower_until;
use crate::pick::bending::{Bending, on_beams};
use crate::pick::with_reserve;
use crate::pick::{BAND_SHARE, PickAnswer, SEARCH_RATIOS, largest_share, pick};
use crate::progress::{Progress, WithinStep, check, step};
use crate::row::CartModel;
use crate::row::{NamedRig, tidy};
use crate::sweep::spread;
use crate::uncertainty::Uncertainty;

/// Points of the curve that is drawn, beside those the branch was followed by.
const CURVE_POINTS: usize = 100;

/// Steps of progress.
pub const STEPS: u64 = 6;

/// What is asked for.
#[derive(Clone, Copy, Debug)]
pub struct DrillPickRequest {
    /// The ground.
    pub ground: Slider<f64>,
    /// A bit between hammer and ground.
    pub bit: Option<Bit<f64>>,
    /// How far it is unknown; counts where `uncertainty` is given.
    pub ground_uncertainty: GroundUncertainty,
    /// How far the rig is unknown. None: rig and ground are exact.
    pub uncertainty: Option<Uncertainty>,
    /// What must be kept.
    pub limits: PickLimits,
}

/// The answer and what its picture is drawn from.
#[derive(Clone, Debug)]
pub struct RopPick {
    /// What every pick says.
    pub answer: PickAnswer,
    /// What this one says beside it.
    pub ground: OnGround,
    /// The nominal stable 1/1: (Hz, µm/s).
    pub curve: Vec<(f64, f64)>,
}

/// Picks the frequency with the largest rate of penetration of `rig` on the ground of `request`, at its own gap and with
/// its own cart. Where no frequency keeps the limits of the shaker, the amplitude is lowered until one does.
///
/// # Errors
/// As [`pick`]; [`Error::NoProgress`] if nothing gives way anywhere.
pub fn pick_rop(
    rig: &NamedRig,
    request: &DrillPickRequest,
    progress: &dyn Progress,
) -> Result<RopPick, Error> {
    let found = pick_at_amplitude(rig, request, progress);
    let Err(Error::Pick {
        what: PickError::Limits { .. },
        ..
    }) = &found
    else {
        return found;
    };
    let Some(lower) = lowered(rig, request, progress) else {
        return found;
    };
    let mut found = pick_at_amplitude(&lower, request, progress)?;
    found.answer.amplitude_lowered = true;
    Ok(found)
}

/// `rig` at the amplitude at which its fastest nominal 1/1 needs no more than the shaker's limits allow. None if it does at
/// the rig's own, so that lowering it is no help, or at no lower one, or the ground then holds.
fn lowered(
    rig: &NamedRig,
    request: &DrillPickRequest,
    progress: &dyn Progress,
) -> Option<NamedRig> {
    let limits = request.limits.with_shaker_of(&rig.params);
    lower_until(rig, |lower| {
        let params = &lower.params;
        let case = DrillCase {
            params: *params,
            ground: request.ground,
            bit: request.bit,
        };
        let branch = nominal_branch(lower, &case, &WithinStep(progress)).ok()?;
        let top = limits.max_frequency_hz.unwrap_or(f64::INFINITY);
        let (low, high) = branch.range();
        let orbit = branch.best((low, high.min(top)), |o| Some(o.rate_m_per_s()))?;
        let most = limits.shaker_force_n(params)?;
        Some(observe::shaker_force_n(&case, &orbit) / most)
    })
}

fn pick_at_amplitude(
    rig: &NamedRig,
    request: &DrillPickRequest,
    progress: &dyn Progress,
) -> Result<RopPick, Error> {
    rig.params.check()?;
    request.ground.check()?;
    if let Some(bit) = &request.bit {
        bit.check(&request.ground)?;
    }
    let limits = request.limits.with_shaker_of(&rig.params);
    let case = DrillCase {
        params: rig.params,
        ground: request.ground,
        bit: request.bit,
    };
    let within = WithinStep(progress);
    let branch = nominal_branch(rig, &case, &within)?;
    step(progress, 1)?;
    let rate = |o: &DrillOrbit| Some(o.rate_m_per_s());
    let power = |o: &DrillOrbit| Some(o.contact_j * o.frequency_hz);
    let lost = || no_one_one(rig);
    let nominal = branch.best(branch.range(), rate).ok_or_else(lost)?;
    let strongest = branch.best(branch.range(), power).ok_or_else(lost)?;

    let uncertainty = request.uncertainty;
    let members = uncertainty.map_or(Vec::new(), |u| {
        with_ground(u, request.ground_uncertainty).members()
    });
    let crowd = Crowd {
        case: &case,
        branch: &branch,
        members: &members,
    };
    let corners = uncertainty.map_or(0, |u| {
        with_ground(u, request.ground_uncertainty).corners().len()
    });
    let robust = crowd.common_range(nominal.frequency_hz);
    let robust = robust.ok_or_else(|| {
        rig.no_pick(PickError::NoneRobust {
            share: robust_share(crowd, nominal.frequency_hz, corners),
        })
    })?;
    step(progress, 1)?;
    let field = DrillField { crowd, limits };
    let kept = with_reserve(robust, !members.is_empty());
    let chosen = field.best(kept).ok_or_else(|| {
        rig.no_pick(PickError::Limits {
            range_hz: kept,
            limits,
            feasible: Box::default(),
        })
    })?;
    check(progress)?;
    let hz = chosen.frequency_hz;
    let spread_at = crowd.spread(hz);
    let spread_at =
        spread_at.ok_or_else(|| rig.no_pick(PickError::MemberLost { frequency_hz: hz }))?;
    let enough = |hz: f64| {
        let there = branch.at(hz);
        there.is_some_and(|o| o.rate_m_per_s() >= BAND_SHARE * chosen.rate_m_per_s())
    };
    let band = branch.interval(hz, branch.range(), enough);
    let open = (band.0.max(robust.0), band.1.min(robust.1));
    let safe = branch.interval(hz, open, |hz| field.allows(hz));
    let safe_worst = [safe.0, safe.1].map(|hz| crowd.spread(hz));
    step(progress, 1)?;
    let jumps = jumps(&case, &branch)?;
    step(progress, 1)?;
    let uncertain = uncertainty.map(|u| (u, request.ground_uncertainty));
    let seen = Observed::of(&case, &chosen, &crowd, uncertain)?;
    let other = other_cart(rig, &case, &within);
    step(progress, 1)?;
    let rigid = pick(rig, None, PickLimits::default(), &within).ok();
    let rigid_hz = rigid.map(|p| p.answer.operating_frequency_hz);
    check(progress)?;

    let um = |m_per_s: f64| 1e6 * m_per_s;
    let cart = CartModel::of(&rig.params);
    let (recoil, prescribed) = match cart {
        CartModel::Recoil => (Some(chosen), other),
        CartModel::Prescribed => (other, Some(chosen)),
    };
    let weight = rig.params.weight_n();
    let params = &rig.params;
    let in_safe = |hz: &f64| (safe.0..=safe.1).contains(hz);
    let answer = PickAnswer {
        rig: rig.name.clone(),
        gap_mm: tidy(params.gap_m * 1e3),
        cart,
        recoil_force_ratio: recoil.map(|o| o.force_n / weight),
        recoil_frequency_hz: recoil.map(|o| o.frequency_hz),
        prescribed_force_ratio: prescribed.map(|o| o.force_n / weight),
        prescribed_frequency_hz: prescribed.map(|o| o.frequency_hz),
        shaker_loop: rig.shaker,
        operating_frequency_hz: hz,
        frequency_ratio: hz / params.natural_frequency_hz(),
        regime: seen.on_orbit.regime,
        regime_from_rest: seen.from_rest,
        // The force is cut off at the threshold: it says nothing of settling.
        force_settling_cycles: None,
        force_settling_s: None,
        corners: seen.corners,
        corners_reaching_one_one_from_rest: seen.corners_reaching,
        force_ratio: chosen.force_n / weight,
        force_n: chosen.force_n,
        force_ratio_worst: spread_at.weakest_n / weight,
        force_ratio_largest: spread_at.strongest_n / weight,
        approach_speed_m_per_s: seen.blow.approach_speed_m_per_s,
        contact_time_ms: 1e3 * seen.blow.duration_s,
        band_hz: band.into(),
        safe_band_hz: safe.into(),
        margin_below_percent: 100.0 * (1.0 - safe.0 / hz),
        margin_above_percent: 100.0 * (safe.1 / hz - 1.0),
        safe_band_force_ratio_worst: safe_worst.map(|s| s.map(|s| s.weakest_n / weight)),
        stable_one_one_hz: branch.range().into(),
        stable_one_one_ends: [branch.low.end, branch.high.end],
        robust_band_hz: robust.into(),
        period_doubling_hz: (branch.high.end == BranchEnd::PeriodDoubling)
            .then_some(branch.high.frequency_hz),
        multipliers: chosen.multipliers().modulus(),
        multipliers_worst: spread_at.multiplier,
        jump_free: jumps.is_empty(),
        jump_free_in_safe_band: !jumps.iter().any(in_safe),
        jump_range_hz: jumps.first().zip(jumps.last()).map(|(a, b)| [*a, *b]),
        nominal_optimum_hz: nominal.frequency_hz,
        nominal_optimum_force_ratio: nominal.force_n / weight,
        impact_power_w: chosen.contact_j * hz,
        power_optimum_hz: strongest.frequency_hz,
        power_optimum_w: strongest.contact_j * strongest.frequency_hz,
        force_ratio_at_natural_frequency: seen.force_at_natural_n / weight,
        shaker: seen.shaker(params, &chosen),
        shaker_force_at_optimum_n: None,
        limits: field.which_decide(&chosen, (robust, kept), !members.is_empty()),
        sensitivity: Vec::new(),
        uncertainty: uncertainty.map(|u| Uncertainty {
            contact_stiffness_percent: 0.0,
            contact_damping_percent: 0.0,
            contact_stiffness_factor: None,
            contact_damping_ratio_percent: None,
            ..u
        }),
        amplitude_mm: tidy(params.amplitude_m * 1e3),
        amplitude_lowered: false,
        wanted_force_n: None,
        bending: Bending {
            on_beams: on_beams(params),
            modes: on_beams(params).then_some(1),
            ..Bending::default()
        },
    };
    let ground = OnGround {
        objective: "rop",
        threshold_n: request.ground.threshold,
        ground_stiffness_n_per_m: request.ground.stiffness,
        ground_damping_n_s_per_m: request.ground.damping,
        bit_mass_kg: request.bit.map(|b| b.mass),
        bit_feed_force_n: request.bit.map(|b| b.feed_force),
        uncertain: uncertainty.map(|_| request.ground_uncertainty),
        rate_of_penetration_um_per_s: um(chosen.rate_m_per_s()),
        rate_worst_um_per_s: um(spread_at.least_m_per_s),
        rate_largest_um_per_s: um(spread_at.most_m_per_s),
        safe_band_rate_worst_um_per_s: safe_worst.map(|s| s.map(|s| um(s.least_m_per_s))),
        progress_per_blow_um: um(chosen.progress_m),
        energy_per_blow_mj: 1e3 * chosen.contact_j,
        share_into_progress: request.ground.threshold * chosen.progress_m / chosen.contact_j,
        feed_needed_mm_per_s: 1e3 * chosen.rate_m_per_s(),
        nominal_optimum_rate_um_per_s: um(nominal.rate_m_per_s()),
        force_optimum_hz: rigid_hz,
        force_optimum_rate_um_per_s: rigid_hz
            .and_then(|hz| branch.at(hz))
            .map(|o| um(o.rate_m_per_s())),
        recoil_rate_um_per_s: recoil.map(|o| um(o.rate_m_per_s())),
        prescribed_rate_um_per_s: prescribed.map(|o| um(o.rate_m_per_s())),
        rate_sensitivity: rate_sensitivity(&case, &chosen, uncertainty, request.ground_uncertainty),
    };
    step(progress, 1)?;
    Ok(RopPick {
        answer,
        ground,
        curve: curve(&branch),
    })
}

/// The largest share of the uncertainty's corners with which every one of them has a stable 1/1 at a common frequency, in
/// hundredths.
fn robust_share(crowd: Crowd, from_hz: f64, corners: usize) -> Option<f64> {
    largest_share(&crowd.members[..corners], |members| {
        let crowd = Crowd { members, ..crowd };
        crowd.common_range(from_hz).is_some()
    })
}

fn no_one_one(rig: &NamedRig) -> Error {
    rig.no_pick(PickError::NoOneOne {
        gap_m: rig.params.gap_m,
        ratios: SEARCH_RATIOS,
        nearest_gap_m: None,
    })
}

/// The stable 1/1 about the one that drills fastest from rest.
fn nominal_branch(
    rig: &NamedRig,
    case: &DrillCase,
    progress: &dyn Progress,
) -> Result<GroundBranch, Error> {
    let seed = seed(rig, case, progress)?.ok_or_else(|| no_one_one(rig))?;
    let natural_hz = rig.params.natural_frequency_hz();
    let limits = (SEARCH_RATIOS.0 * natural_hz, SEARCH_RATIOS.1 * natural_hz);
    Ok(GroundBranch::follow(*case, seed, limits))
}

/// The nominal orbit with the largest rate with the cart moved the other way. None where its shaker is not known, or it has
/// no such orbit.
fn other_cart(rig: &NamedRig, case: &DrillCase, progress: &dyn Progress) -> Option<DrillOrbit> {
    let other = if rig.params.cart.recoils() {
        rig.clone().prescribed()
    } else {
        rig.recoiling()?
    };
    let case = DrillCase {
        params: other.params,
        ..*case
    };
    let branch = nominal_branch(&other, &case, progress).ok()?;
    branch.best(branch.range(), |o| Some(o.rate_m_per_s()))
}

fn curve(branch: &GroundBranch) -> Vec<(f64, f64)> {
    let (low, high) = branch.range();
    let mut nodes = spread(low, high, CURVE_POINTS);
    nodes.extend(branch.frequencies());
    nodes.sort_by(f64::total_cmp);
    let point = |hz: &f64| Some((*hz, 1e6 * branch.at(*hz)?.rate_m_per_s()));
    nodes.iter().filter_map(point).collect()
}

/// A0 Ω at `hz`, m/s.
fn peak_speed(amplitude_m: f64, hz: f64) -> f64 {
    amplitude_m * TAU * hz
}
