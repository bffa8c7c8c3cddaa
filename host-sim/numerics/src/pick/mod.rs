//! Which frequency to run the hammer at.
//!
//! 1. Find the nominal rig's stable 1/1 orbits and follow their branch to both ends by the monodromy
//!    multipliers ([`crate::branch`]).
//! 2. For every corner and sample of the stated uncertainty, find where *it* has a stable 1/1; keep the
//!    frequencies at which all of them have ([`search`]).
//! 3. On what is left, and within the limits asked for, take the largest nominal force.
//!
//! On ground that gives way the same steps lead to the largest rate of penetration ([`case`], [`crate::drill::pick`]).

mod amplitude;
pub mod answer;
pub mod bending;
pub mod case;
pub mod choose;
pub mod follow;
pub(crate) mod found;
pub mod gaps;
pub mod outline;
pub mod robust;
pub mod runs;
pub mod search;
pub mod sensitivity;

use shared::model::params::RigParams;
use shared::model::rig::Rig;

use crate::branch::{Branch, one_one_branches, strongest_branch};
use crate::error::{Error, PickError};
use crate::limits::PickLimits;
use crate::orbit::Orbit;
use crate::parallel;
use crate::progress::{Progress, WithinStep, check, step};
use crate::root::halved;
use crate::row::{NamedRig, RunRow};
use crate::sweep::spread;
use crate::uncertainty::Uncertainty;
use amplitude::{best_within, lowered};
pub use answer::{BestPoint, PickAnswer};
pub use bending::Springs;
use case::PickCase;
use choose::PickField;
use found::PickParts;
use robust::{robust_range, with_reserve};
use runs::JUMP_POINTS;

/// Force, as a share of the best, down to which the band reaches.
pub const BAND_SHARE: f64 = 0.9;
/// Points of the curve that is drawn, beside those the branch was followed by.
const CURVE_POINTS: usize = 200;

/// Parameters whose force is computed over all that they may be.
const RANGES_COMPUTED: usize = 3;
/// Ratios Ω/ω searched for 1/1.
pub const SEARCH_RATIOS: (f64, f64) = (0.4, 5.0);

/// The answer and what its picture is drawn from.
#[derive(Clone, Debug)]
pub struct Pick {
    /// The operating point, with all that tables and text say of it.
    pub answer: PickAnswer,
    /// The nominal stable 1/1: (Hz, force ratio).
    pub curve: Vec<(f64, f64)>,
    /// Where 1/1 is stable over the whole uncertainty: (Hz, smallest and largest force ratio over it). Empty without one.
    pub force_range: Vec<[f64; 3]>,
    /// The sweep up across the stable 1/1, rows by rising frequency.
    pub up: Vec<RunRow>,
    /// The sweep down across the stable 1/1, rows by rising frequency.
    pub down: Vec<RunRow>,
    /// Section of the orbit picked, in A0 and A0 Ω of the rig's coordinate.
    pub section: [f64; 2],
}

/// Picks the operating frequency of `rig` (its gap included), for its cart as it is in its parameters. Where the rig's
/// shaker is known, the answer has beside it how strong the hammer is with the other cart.
///
/// # Errors
/// If a parameter is out of range; if there is no stable 1/1, or none that uncertainty and limits allow; if a run cannot
/// be followed; or if the work is interrupted.
pub fn pick(
    rig: &NamedRig,
    uncertainty: Option<Uncertainty>,
    limits: PickLimits,
    progress: &dyn Progress,
) -> Result<Pick, Error> {
    pick_on(rig, Springs::default(), uncertainty, limits, progress)
}

/// [`pick`] for a rig on beam springs of another mass than the assumed one.
///
/// Where no frequency keeps the limits of the shaker, the amplitude is lowered until one does.
///
/// # Errors
/// As [`pick`].
pub fn pick_on(
    rig: &NamedRig,
    springs: Springs,
    uncertainty: Option<Uncertainty>,
    limits: PickLimits,
    progress: &dyn Progress,
) -> Result<Pick, Error> {
    let request = PickRequest {
        springs,
        uncertainty,
        limits,
    };
    Pick::of(pick_case(rig, &rig.params, request, progress)?)
}

/// What is asked of a pick.
#[derive(Clone, Copy)]
pub(crate) struct PickRequest {
    /// Beam springs; of no account on wires and on ground.
    pub(crate) springs: Springs,
    /// How far the rig is unknown.
    pub(crate) uncertainty: Option<Uncertainty>,
    /// What must be kept.
    pub(crate) limits: PickLimits,
}

/// The best frequency of a case. Where none keeps the limits of the shaker, the amplitude is lowered until one does.
pub(crate) fn pick_case<C: PickCase>(
    rig: &NamedRig,
    case: &C,
    request: PickRequest,
    progress: &dyn Progress,
) -> Result<(PickAnswer, PickParts<C>), Error> {
    let limits = request.limits.with_shaker_of(&rig.params);
    let request = PickRequest { limits, ..request };
    let found = pick_at_amplitude(rig, case, request, progress);
    let Err(Error::Pick {
        what: PickError::Limits { .. },
        ..
    }) = &found
    else {
        return found;
    };
    let Some(lower) = lowered(rig, case, limits, progress) else {
        return found;
    };
    let at_own = best_within(rig, case, limits.without_the_shaker(), progress);
    let there = case.with(&lower.params);
    let (mut answer, parts) = pick_at_amplitude(&lower, &there, request, progress)?;
    answer.amplitude_lowered = true;
    answer.shaker_force_at_optimum_n = at_own.map(|orbit| case.shaker_force_n(&orbit));
    Ok((answer, parts))
}

impl Pick {
    fn of((answer, parts): (PickAnswer, PickParts<RigParams>)) -> Result<Self, Error> {
        let params = &parts.rig.params;
        let weight = params.weight_n();
        let forces = if answer.uncertainty.is_some() {
            parts.robust.force_range(&parts.curve)
        } else {
            Vec::new()
        };
        let over_weight = |[hz, low, high]: [f64; 3]| [hz, low / weight, high / weight];
        let section = dimensionless_section(params, &parts.choice.orbit)?;
        let curve = parts.curve.into_iter();
        Ok(Self {
            answer,
            curve: curve.map(|(hz, force_n)| (hz, force_n / weight)).collect(),
            force_range: forces.into_iter().map(over_weight).collect(),
            up: parts.jumps.up,
            down: parts.jumps.down,
            section,
        })
    }
}

/// [`pick_on`] at the amplitude at which the nominal force at the operating point is `wanted_n`. What the shaker can give
/// bounds nothing; the answer has it beside what is needed.
///
/// # Errors
/// As [`pick`], and if no amplitude gives that force.
pub fn pick_for_force(
    rig: &NamedRig,
    springs: Springs,
    uncertainty: Option<Uncertainty>,
    (limits, wanted_n): (PickLimits, f64),
    progress: &dyn Progress,
) -> Result<Pick, Error> {
    let shaker = limits.with_shaker_of(&rig.params);
    let limits = limits.without_the_shaker();
    let request = PickRequest {
        springs,
        uncertainty,
        limits,
    };
    let at = |amplitude_m: f64| {
        let mut there = rig.clone();
        there.params.amplitude_m = amplitude_m;
        there
    };
    let none = || rig.no_pick(PickError::NoAmplitude { wanted_n });
    let nominal = |amplitude_m: f64| {
        check(progress)?;
        let there = at(amplitude_m);
        there.params.check().map_err(|_| none())?;
        let orbit = best_within(&there, &there.params, limits, progress);
        Ok::<_, Error>(orbit.map(|orbit| (orbit.force_n, amplitude_m)))
    };
    let from_m = amplitude::for_force(rig.params.amplitude_m, (wanted_n, 1e-6), nominal)?;
    // The uncertainty may keep the choice from the strongest nominal orbit.
    let within = WithinStep(progress);
    let mut first = true;
    let whole = |amplitude_m: f64| {
        let progress: &dyn Progress = if first { progress } else { &within };
        first = false;
        let there = at(amplitude_m);
        there.params.check().map_err(|_| none())?;
        let found = pick_at_amplitude(&there, &there.params, request, progress)?;
        Ok::<_, Error>(Some((found.0.force_n, found)))
    };
    let found = amplitude::for_force(from_m.ok_or_else(none)?, (wanted_n, 1e-4), whole)?;
    let (mut answer, parts) = found.ok_or_else(none)?;
    answer.wanted_force_n = Some(wanted_n);
    let shaker = PickLimits {
        max_force_n: None,
        max_frequency_hz: None,
        ..shaker
    };
    answer.limits.extend(shaker.which_decide(|_| false));
    Pick::of((answer, parts))
}

fn pick_at_amplitude<C: PickCase>(
    rig: &NamedRig,
    case: &C,
    request: PickRequest,
    progress: &dyn Progress,
) -> Result<(PickAnswer, PickParts<C>), Error> {
    let PickRequest {
        springs,
        uncertainty,
        limits,
    } = request;
    let params = &rig.params;
    case.check()?;
    let within = WithinStep(progress);
    let own = || case.best_branch(rig, &within);
    let (branch, other) = rayon::join(own, || other_cart(rig, case, limits, &within));
    let branch = branch?;
    check(progress)?;
    let range = branch.range();
    let nominal = branch.best(range, |orbit| C::numbers_of(orbit).worth);
    let nominal = nominal.ok_or_else(|| no_one_one(rig))?;
    let power = branch.best(range, |orbit| C::numbers_of(orbit).impact_power_w);
    let power = power.ok_or_else(|| no_one_one(rig))?;

    let certain = PickField::nominal(rig, &branch, progress);
    if certain.best(range, limits).is_none() {
        check(progress)?;
        return Err(certain.nothing(range, limits));
    }
    let members = uncertainty.map_or(Vec::new(), |u| u.members());
    let robust = robust_range(rig, &members, &branch, &nominal, progress)?;
    let field = certain.asking(&robust.members);
    let mut choice = field.choose(robust.hz, limits)?;
    let allowed = |chosen: &C::Orbit, limits_hz: (f64, f64)| {
        let band = worth_band(&branch, chosen);
        (band.0.max(limits_hz.0), band.1.min(limits_hz.1))
    };
    let chosen_hz = C::numbers_of(&choice.orbit).frequency_hz;
    let bent = bending::BendingRequest {
        params,
        springs,
        members: &members,
        corners: uncertainty.map_or(0, |u| u.corners().len()),
        chosen_hz,
        kept_hz: with_reserve(robust.hz, !members.is_empty()),
        band_hz: allowed(&choice.orbit, choice.allowed),
        max_force_n: limits.max_force_n,
    };
    let bent = case.bent(bent, progress)?;
    if let Some(bent) = &bent {
        if bent.chosen_hz != chosen_hz {
            let moved = branch.at(bent.chosen_hz);
            choice.orbit = moved.ok_or_else(|| no_one_one(rig))?;
            choice.spread = field.spread(&choice.orbit)?;
        }
        let (low, high) = bent.band_hz;
        choice.allowed = (choice.allowed.0.max(low), choice.allowed.1.min(high));
    }
    let jumps = C::jumps(rig, &branch, progress)?;
    let runs = case.runs(&choice.orbit, uncertainty)?;
    let sensitivity = case.sensitivity(&nominal, uncertainty);
    let chosen = BestPoint::of(&C::numbers_of(&choice.orbit), params);
    // The very orbit chosen, unless uncertainty, shaker or bending modes leave less than the nominal rig could do.
    let own = comparable(rig, &branch, limits, progress);
    let own = own.filter(|own| own.worth > chosen.worth * (1.0 + 1e-6));
    let own = own.unwrap_or(chosen);
    let band = worth_band(&branch, &choice.orbit);
    let safe_band = allowed(&choice.orbit, choice.allowed);
    let safe_spread = [safe_band.0, safe_band.1].map(|hz| field.spread_at(hz));
    step(progress, 1)?;
    let parts = PickParts {
        rig: rig.clone(),
        curve: curve(&branch, CURVE_POINTS),
        nominal,
        power,
        band,
        safe_band,
        safe_spread,
        own,
        other,
        choice,
        jumps,
        runs,
        sensitivity,
        uncertainty,
        bending: bent.map(|bent| bent.bending),
        robust,
        branch,
    };
    Ok((parts.answer(), parts))
}

/// Where the nominal 1/1 is worth at least [`BAND_SHARE`] of `chosen`, Hz.
fn worth_band<C: PickCase>(branch: &Branch<C>, chosen: &C::Orbit) -> (f64, f64) {
    let chosen = C::numbers_of(chosen);
    branch.stretch(chosen.frequency_hz, branch.range(), |hz| {
        let there = branch.at(hz).map(|orbit| C::numbers_of(&orbit));
        there.is_some_and(|o| o.is_stable_one_one && o.worth >= BAND_SHARE * chosen.worth)
    })
}

/// What the nominal stable 1/1 is worth: (Hz, worth), by rising frequency, at so many `points` and those it was followed by.
fn curve<C: PickCase>(branch: &Branch<C>, points: usize) -> Vec<(f64, f64)> {
    let (low, high) = branch.range();
    let mut nodes = spread(low, high, points);
    nodes.extend(branch.frequencies());
    nodes.sort_by(f64::total_cmp);
    let found = parallel::map(&nodes, |hz| Some((*hz, C::drawn_at(branch, *hz)?)));
    found.into_iter().flatten().collect()
}

/// The section of `orbit` in A0 and A0 Ω of the rig's coordinate.
fn dimensionless_section(params: &RigParams, orbit: &Orbit) -> Result<[f64; 2], Error> {
    let scale = Rig::<f64>::new(params)?.coordinate_scale();
    let rate = scale * std::f64::consts::TAU * orbit.frequency_hz;
    Ok([orbit.section[0] / scale, orbit.section[1] / rate])
}

/// [`comparable`] with the cart moved the other way. None where its shaker is not known, too.
fn other_cart<C: PickCase>(
    rig: &NamedRig,
    case: &C,
    limits: PickLimits,
    progress: &dyn Progress,
) -> Option<BestPoint> {
    let other = rig.with_the_other_cart()?;
    let branch = case.with(&other.params).best_branch(&other, progress);
    comparable(&other, &branch.ok()?, limits, progress)
}

/// Where the nominal `rig` is best within those of `limits` that both carts have: all but the shaker's force.
/// None if no stable 1/1 is within them.
fn comparable<C: PickCase>(
    rig: &NamedRig,
    branch: &Branch<C>,
    limits: PickLimits,
    progress: &dyn Progress,
) -> Option<BestPoint> {
    let field = PickField::nominal(rig, branch, progress);
    let chosen = field.choose(branch.range(), limits.without_the_shaker());
    let orbit = C::numbers_of(&chosen.ok()?.orbit);
    Some(BestPoint::of(&orbit, &rig.params))
}

/// Steps of progress that [`pick`] reports with this uncertainty.
pub fn steps(uncertainty: Option<Uncertainty>) -> u64 {
    let members = uncertainty.map_or(0, |u| u.members().len());
    (members + 2 * JUMP_POINTS + 1) as u64
}

/// The branch with the largest force.
pub(crate) fn best_branch(rig: &NamedRig) -> Result<Branch, Error> {
    strongest_branch(&rig.params, SEARCH_RATIOS).ok_or_else(|| no_one_one(rig))
}

fn no_one_one(rig: &NamedRig) -> Error {
    rig.no_pick(PickError::NoOneOne {
        gap_m: rig.params.gap_m,
        ratios: SEARCH_RATIOS,
        nearest_gap_m: nearest_gap_m(&rig.params),
    })
}

/// A gap with a stable 1/1 between 0 and that of `params`, near the largest such. None if there is none at 0.
fn nearest_gap_m(params: &RigParams) -> Option<f64> {
    const HALVINGS: u32 = 6;
    let has = |gap_m: f64| {
        let rig = RigParams { gap_m, ..*params };
        !one_one_branches(&rig, SEARCH_RATIOS).is_empty()
    };
    if params.gap_m == 0.0 || !has(0.0) {
        return None;
    }
    Some(halved((0.0, params.gap_m), HALVINGS, |gap_m| !has(gap_m)).0)
}
