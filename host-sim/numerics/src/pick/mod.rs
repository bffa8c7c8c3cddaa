//! Which frequency to run the hammer at.
//!
//! 1. Find the nominal rig's stable 1/1 orbits and follow their branch to both ends by the monodromy
//!    multipliers ([`crate::branch`]).
//! 2. For every corner and sample of the stated uncertainty, find where *it* has a stable 1/1; keep the
//!    frequencies at which all of them have ([`search`]).
//! 3. On what is left, and within the limits asked for, take the largest nominal force.

pub(crate) mod amplitude;
pub mod answer;
pub mod bending;
pub mod choose;
pub mod follow;
mod found;
pub mod gaps;
pub mod outline;
mod robust;
mod runs;
pub mod search;
pub mod sensitivity;

use shared::model::params::RigParams;
use shared::model::rig::Rig;

use crate::branch::{Branch, one_one_branches};
use crate::error::{Error, PickError};
use crate::limits::PickLimits;
use crate::orbit::Orbit;
use crate::parallel;
use crate::progress::{Progress, WithinStep, check, step};
use crate::root::halved;
use crate::row::{NamedRig, RunRow};
use crate::sweep::spread;
use crate::uncertainty::Uncertainty;
use amplitude::{lowered, strongest};
pub use answer::{PickAnswer, StrongestPoint};
use answer::{impact_power, shaker_force};
pub use bending::Springs;
use choose::PickField;
use found::{PickParts, SafeBand};
pub(crate) use robust::largest_share;
use robust::robust_range;
pub(crate) use robust::with_reserve;
pub(crate) use runs::{JUMP_POINTS, JUMP_SHARE};
use runs::{Jumps, Runs};
use search::{interval_where, maximise};

/// Force, as a share of the best, down to which the band reaches.
pub const BAND_SHARE: f64 = 0.9;
/// Points of the curve that is drawn, beside those the branch was followed by.
const CURVE_POINTS: usize = 200;

/// Parameters whose force is computed over all that they may be.
const RANGES_COMPUTED: usize = 3;
/// Ratios Ω/ω searched for 1/1.
pub(crate) const SEARCH_RATIOS: (f64, f64) = (0.4, 5.0);

/// The answer and what its picture is drawn from.
#[derive(Clone, Debug)]
pub struct Pick {
    /// The answer.
    pub answer: PickAnswer,
    /// The nominal stable 1/1: (Hz, force ratio).
    pub curve: Vec<(f64, f64)>,
    /// Where 1/1 is stable over the whole uncertainty: (Hz, smallest and largest force ratio over it). Empty without one.
    pub force_range: Vec<[f64; 3]>,
    /// The sweep up across it.
    pub up: Vec<RunRow>,
    /// The sweep down.
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
    let limits = limits.with_shaker_of(&rig.params);
    let found = pick_at_amplitude(rig, springs, uncertainty, limits, progress);
    let Err(Error::Pick {
        what: PickError::Limits { .. },
        ..
    }) = &found
    else {
        return found;
    };
    let Some(lower) = lowered(rig, limits, progress) else {
        return found;
    };
    let at_own = strongest(rig, limits.without_the_shaker(), progress);
    let mut found = pick_at_amplitude(&lower, springs, uncertainty, limits, progress)?;
    found.answer.amplitude_lowered = true;
    found.answer.shaker_force_at_optimum_n = at_own.map(|orbit| shaker_force(&rig.params, &orbit));
    Ok(found)
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
        let orbit = strongest(&there, limits, progress);
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
        let found = pick_at_amplitude(&there, springs, uncertainty, limits, progress)?;
        Ok::<_, Error>(Some((found.answer.force_n, found)))
    };
    let found = amplitude::for_force(from_m.ok_or_else(none)?, (wanted_n, 1e-4), whole)?;
    let mut found = found.ok_or_else(none)?;
    found.answer.wanted_force_n = Some(wanted_n);
    let shaker = PickLimits {
        max_force_n: None,
        max_frequency_hz: None,
        ..shaker
    };
    found.answer.limits.extend(shaker.which_decide(|_| false));
    Ok(found)
}

fn pick_at_amplitude(
    rig: &NamedRig,
    springs: Springs,
    uncertainty: Option<Uncertainty>,
    limits: PickLimits,
    progress: &dyn Progress,
) -> Result<Pick, Error> {
    let params = &rig.params;
    params.check()?;
    let own = || best_branch(rig);
    let (branch, other) = rayon::join(own, || other_cart(rig, limits, progress));
    let branch = branch?;
    check(progress)?;
    let force_at = |hz: f64| branch.at(hz).map(|orbit| (orbit.force_n, orbit));
    let (_, nominal) =
        maximise(&branch, range(&branch), force_at).ok_or_else(|| no_one_one(rig))?;
    let power_at = |hz: f64| branch.at(hz).map(|o| (impact_power(&o), o));
    let (_, strongest_power) =
        maximise(&branch, range(&branch), power_at).ok_or_else(|| no_one_one(rig))?;

    let certain = PickField {
        rig,
        branch: &branch,
        members: &[],
        progress,
    };
    if certain.best(range(&branch), limits).is_none() {
        check(progress)?;
        return Err(certain.nothing(range(&branch), limits));
    }
    let members = uncertainty.map_or(Vec::new(), |u| u.members());
    let robust = robust_range(rig, &members, &branch, &nominal, progress)?;
    let field = PickField {
        rig,
        branch: &branch,
        members: &robust.members,
        progress,
    };
    let mut choice = field.choose(robust.hz, limits)?;
    let allowed = |chosen: &Orbit, limits_hz: (f64, f64)| {
        let band = force_band(&branch, chosen);
        (band.0.max(limits_hz.0), band.1.min(limits_hz.1))
    };
    let bent = bending::BendingRequest {
        params,
        springs,
        members: &members,
        corners: uncertainty.map_or(0, |u| u.corners().len()),
        chosen_hz: choice.orbit.frequency_hz,
        kept_hz: with_reserve(robust.hz, !members.is_empty()),
        band_hz: allowed(&choice.orbit, choice.allowed),
        max_force_n: limits.max_force_n,
    }
    .run(progress)?;
    if let Some(bent) = &bent {
        if bent.chosen_hz != choice.orbit.frequency_hz {
            let moved = branch.at(bent.chosen_hz);
            choice.orbit = moved.ok_or_else(|| no_one_one(rig))?;
            choice.spread = field.spread(&choice.orbit)?;
        }
        let (low, high) = bent.band_hz;
        choice.allowed = (choice.allowed.0.max(low), choice.allowed.1.min(high));
    }
    let jumps = Jumps::find(rig, &branch, progress)?;
    let runs = Runs::of(params, uncertainty, &choice.orbit)?;
    let sensitivity = sensitivity::table(params, &nominal);
    let sensitivity = match &uncertainty {
        None => sensitivity,
        Some(u) => {
            let known = sensitivity.into_iter();
            let known = known.map(|row| row.known_to(u, &params.contact));
            let mut rows: Vec<_> = known.collect();
            sensitivity::compute_ranges(&mut rows, RANGES_COMPUTED, params, &nominal);
            rows
        }
    };
    let own = comparable(rig, &branch, limits, progress);
    let chosen = StrongestPoint::of(&choice.orbit, params);
    // The very orbit chosen, unless uncertainty, shaker or bending modes leave less than the nominal rig could do.
    let own = own.filter(|own| own.force_ratio > chosen.force_ratio * (1.0 + 1e-6));
    let own = own.unwrap_or(chosen);
    let band = force_band(&branch, &choice.orbit);
    let (low, high) = allowed(&choice.orbit, choice.allowed);
    let worst = |hz: f64| Some(field.weakest_at(hz)? / params.weight_n());
    let safe_band = SafeBand {
        hz: (low, high),
        force_ratio_worst: [low, high].map(worst),
    };
    step(progress, 1)?;

    let curve = curve(params, &branch);
    let weight = params.weight_n();
    let in_newtons: Vec<_> = curve
        .iter()
        .map(|(hz, ratio)| (*hz, ratio * weight))
        .collect();
    let force_range = if members.is_empty() {
        Vec::new()
    } else {
        let forces = robust.force_range(&in_newtons).into_iter();
        forces
            .map(|[hz, low, high]| [hz, low / weight, high / weight])
            .collect()
    };
    let section = dimensionless_section(params, &choice.orbit)?;
    let found = PickParts {
        rig,
        branch: &branch,
        nominal: &nominal,
        power: &strongest_power,
        robust: robust.hz,
        band,
        safe_band,
        own,
        other,
        choice,
        jumps: &jumps.at_hz,
        runs,
        sensitivity,
        uncertainty,
        bending: bent.map(|bent| bent.bending),
    };
    Ok(Pick {
        answer: found.answer(),
        curve,
        force_range,
        up: jumps.up,
        down: jumps.down,
        section,
    })
}

/// Where the nominal 1/1 is stable, Hz.
fn range(branch: &Branch) -> (f64, f64) {
    (branch.low.frequency_hz, branch.high.frequency_hz)
}

/// Where the nominal 1/1 is stable and its force at least [`BAND_SHARE`] of that of `chosen`, Hz.
fn force_band(branch: &Branch, chosen: &Orbit) -> (f64, f64) {
    interval_where(branch, chosen.frequency_hz, range(branch), |hz| {
        branch
            .at(hz)
            .is_some_and(|o| o.is_stable_one_one() && o.force_n >= BAND_SHARE * chosen.force_n)
    })
}

/// The nominal stable 1/1: (Hz, force ratio), by rising frequency.
fn curve(params: &RigParams, branch: &Branch) -> Vec<(f64, f64)> {
    let (low, high) = range(branch);
    let mut nodes = spread(low, high, CURVE_POINTS);
    nodes.extend(branch.frequencies());
    nodes.sort_by(f64::total_cmp);
    let weight = params.weight_n();
    let on_curve = |hz: &f64| Some((*hz, branch.force_n_at(*hz)? / weight));
    let found = parallel::map(&nodes, on_curve);
    found.into_iter().flatten().collect()
}

/// The section of `orbit` in A0 and A0 Ω of the rig's coordinate.
fn dimensionless_section(params: &RigParams, orbit: &Orbit) -> Result<[f64; 2], Error> {
    let scale = Rig::<f64>::new(params)?.coordinate_scale();
    let rate = scale * std::f64::consts::TAU * orbit.frequency_hz;
    Ok([orbit.section[0] / scale, orbit.section[1] / rate])
}

/// [`comparable`] with the cart moved the other way. None where its shaker is not known, too.
fn other_cart(
    rig: &NamedRig,
    limits: PickLimits,
    progress: &dyn Progress,
) -> Option<StrongestPoint> {
    let other = if rig.params.cart.recoils() {
        rig.clone().prescribed()
    } else {
        rig.recoiling()?
    };
    let branch = best_branch(&other).ok()?;
    comparable(&other, &branch, limits, progress)
}

/// Where the nominal `rig` is strongest within those of `limits` that both carts have: all but the shaker's force.
/// None if no stable 1/1 is within them.
fn comparable(
    rig: &NamedRig,
    branch: &Branch,
    limits: PickLimits,
    progress: &dyn Progress,
) -> Option<StrongestPoint> {
    let field = PickField {
        rig,
        branch,
        members: &[],
        progress,
    };
    let orbit = field.choose(range(branch), limits.without_the_shaker());
    let orbit = orbit.ok()?.orbit;
    Some(StrongestPoint::of(&orbit, &rig.params))
}

/// Steps of progress that [`pick`] reports with this uncertainty.
pub fn steps(uncertainty: Option<Uncertainty>) -> u64 {
    let members = uncertainty.map_or(0, |u| u.members().len());
    (members + 2 * JUMP_POINTS + 1) as u64
}

/// The branch with the largest force.
pub(crate) fn best_branch(rig: &NamedRig) -> Result<Branch, Error> {
    let largest = |b: &Branch| b.orbits.iter().map(|o| o.force_n).fold(0.0, f64::max);
    let branches = one_one_branches(&rig.params, SEARCH_RATIOS);
    branches
        .into_iter()
        .max_by(|a, b| largest(a).total_cmp(&largest(b)))
        .ok_or_else(|| no_one_one(rig))
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
