//! Which frequency to run the hammer at.
//!
//! 1. Find the nominal rig's stable 1/1 orbits and follow their branch to both ends by the monodromy
//!    multipliers ([`crate::branch`]).
//! 2. For every corner and sample of the stated uncertainty, find where *it* has a stable 1/1; keep the
//!    frequencies at which all of them have ([`search`]).
//! 3. On what is left, and within the limits asked for, take the largest nominal force.

pub mod answer;
pub mod choose;
pub mod gaps;
pub mod search;
pub mod sensitivity;
pub mod uncertainty;

use rayon::prelude::*;
use shared::model::rig::Rig;

use crate::branch::{Branch, End, one_one_branches};
use crate::engine::{Engine, Plan, Start};
use crate::error::{Error, PickError};
use crate::orbit::Orbit;
use crate::progress::{Progress, check, step};
use crate::row::NamedRig;
use crate::row::{Row, tidy};
use crate::sweep::{Direction, jumps, single, spread, sweep};
pub use answer::Answer;
use answer::shaker;
use choose::Field;
pub use choose::Limits;
use search::{interval_where, maximise, stable_interval};
use uncertainty::Member;
pub use uncertainty::Uncertainty;

/// Force, as a share of the best, down to which the band reaches.
pub const BAND_SHARE: f64 = 0.9;
/// Up and down sweeps that differ by less than this share of force do not jump.
const JUMP_SHARE: f64 = 0.02;
/// Points of the curve that is drawn, beside those the branch was followed by.
const CURVE_POINTS: usize = 200;
/// Frequencies in the jump test.
const JUMP_POINTS: usize = 48;
/// Ratios Ω/ω searched for 1/1.
const SEARCH_RATIOS: (f64, f64) = (0.4, 5.0);
/// How long a run settles at a point that is told.
const SETTLED: Plan = Plan {
    cycles: 600,
    transient: 480,
};
/// How long each step of the jump sweeps settles.
const JUMP_PLAN: Plan = Plan {
    cycles: 140,
    transient: 124,
};

/// The answer and what its picture is drawn from.
#[derive(Clone, Debug)]
pub struct Pick {
    /// The answer.
    pub answer: Answer,
    /// The nominal stable 1/1: (Hz, force ratio).
    pub curve: Vec<(f64, f64)>,
    /// The sweep up across it.
    pub up: Vec<Row>,
    /// The sweep down.
    pub down: Vec<Row>,
    /// Section of the orbit picked, in A0 and A0 Ω of the rig's coordinate.
    pub section: [f64; 2],
}

/// Picks the operating frequency of `rig` (its gap included).
///
/// # Errors
/// One line: there is no stable 1/1, or none that uncertainty and limits allow.
pub fn pick(
    rig: &NamedRig,
    uncertainty: Option<Uncertainty>,
    limits: Limits,
    progress: &dyn Progress,
) -> Result<Pick, Error> {
    let params = &rig.params;
    params.check()?;
    let branch = best_branch(rig)?;
    check(progress)?;
    let nominal_range = (branch.low.frequency_hz, branch.high.frequency_hz);
    let force_at = |hz: f64| branch.at(params, hz).map(|orbit| (orbit.force_n, orbit));
    let (_, nominal) = maximise(&branch, nominal_range, force_at).ok_or_else(|| no_one_one(rig))?;

    let members = uncertainty.map_or(Vec::new(), |u| u.members());
    let robust = robust_range(rig, &members, &branch, &nominal, progress)?;
    let field = Field {
        rig,
        branch: &branch,
        members: &members,
        progress,
    };
    let choice = field.choose(robust, limits)?;
    let chosen = &choice.orbit;

    let band = interval_where(&branch, chosen.frequency_hz, nominal_range, |hz| {
        branch
            .at(params, hz)
            .is_some_and(|o| o.is_stable_one_one() && o.force_n >= BAND_SHARE * chosen.force_n)
    });
    let allowed = choice.allowed;
    let safe_band = (band.0.max(allowed.0), band.1.min(allowed.1));

    let margin = 0.02 * params.natural_frequency_hz();
    let frequencies = spread(
        nominal_range.0 - margin,
        nominal_range.1 + margin,
        JUMP_POINTS,
    );
    let jump_sweep = |direction| {
        sweep(
            rig,
            Engine::Event,
            &frequencies,
            direction,
            JUMP_PLAN,
            progress,
        )
    };
    let (up, down) = rayon::join(|| jump_sweep(Direction::Up), || jump_sweep(Direction::Down));
    let (up, down) = (up?, down?);
    // Beyond the ends of the stable 1/1 the sweeps are drawn, and not judged.
    let mut jumps = jumps(&up, &down, params.weight_n(), JUMP_SHARE);
    jumps.retain(|hz| (nominal_range.0..=nominal_range.1).contains(hz));
    // Past a fold there is no 1/1 nearby to go over to.
    let ends = [branch.low, branch.high].into_iter();
    let folds = ends.filter(|edge| edge.end == End::Fold);
    jumps.extend(folds.map(|edge| edge.frequency_hz));
    jumps.sort_by(f64::total_cmp);
    let in_band = |hz: &f64| (safe_band.0..=safe_band.1).contains(hz);

    let natural_hz = params.natural_frequency_hz();
    let at_natural = single(params, natural_hz, Start::Rest, SETTLED)?;
    let settled = |start| single(params, chosen.frequency_hz, start, SETTLED);
    let from_rest = settled(Start::Rest)?;
    let on_orbit = settled(Start::Section(chosen.section))?;
    let corners = uncertainty.map_or(Vec::new(), |u| u.corners());
    let reach = |corner: &Member| {
        let rig = corner.apply(params, 1.0);
        let run = single(&rig, chosen.frequency_hz, Start::Rest, SETTLED);
        run.is_ok_and(|row| row.regime.is(1, 1))
    };
    let reaching = corners.par_iter().filter(|corner| reach(corner)).count();
    let sensitivity = sensitivity::table(params, &nominal);
    step(progress, 1)?;

    let weight = params.weight_n();
    let doubles = branch.high.end == End::PeriodDoubling;
    let answer = Answer {
        rig: rig.name.clone(),
        gap_mm: tidy(params.gap_m * 1e3),
        operating_frequency_hz: chosen.frequency_hz,
        frequency_ratio: chosen.frequency_hz / params.natural_frequency_hz(),
        regime: on_orbit.regime,
        regime_from_rest: from_rest.regime,
        corners: corners.len(),
        corners_reaching_one_one_from_rest: reaching,
        force_ratio: chosen.force_n / weight,
        force_n: chosen.force_n,
        force_ratio_worst: choice.spread.weakest_n / weight,
        force_ratio_largest: choice.spread.strongest_n / weight,
        approach_speed_m_per_s: chosen.contact.approach_speed_m_per_s,
        contact_time_ms: chosen.contact.duration_s * 1e3,
        band_hz: band.into(),
        safe_band_hz: safe_band.into(),
        stable_one_one_hz: nominal_range.into(),
        stable_one_one_ends: [branch.low.end, branch.high.end],
        robust_band_hz: robust.into(),
        period_doubling_hz: doubles.then_some(branch.high.frequency_hz),
        multipliers: chosen.multipliers().modulus(),
        multipliers_worst: choice.spread.multiplier,
        jump_free: jumps.is_empty(),
        jump_free_in_safe_band: !jumps.iter().any(in_band),
        jump_range_hz: jumps
            .first()
            .zip(jumps.last())
            .map(|(low, high)| [*low, *high]),
        nominal_optimum_hz: nominal.frequency_hz,
        nominal_optimum_force_ratio: nominal.force_n / weight,
        force_ratio_at_natural_frequency: at_natural.force_ratio,
        shaker: shaker(rig, chosen),
        limits: choice.limits,
        sensitivity,
        uncertainty,
    };
    let mut nodes = spread(nominal_range.0, nominal_range.1, CURVE_POINTS);
    nodes.extend(branch.orbits.iter().map(|o| o.frequency_hz));
    nodes.sort_by(f64::total_cmp);
    let on_curve = |hz: &f64| branch.at(params, *hz).map(|o| (*hz, o.force_n / weight));
    let curve = nodes.par_iter().filter_map(on_curve).collect();
    let scale = Rig::<f64>::new(params)?.coordinate_scale();
    let rate = scale * std::f64::consts::TAU * chosen.frequency_hz;
    Ok(Pick {
        answer,
        curve,
        up,
        down,
        section: [chosen.section[0] / scale, chosen.section[1] / rate],
    })
}

/// Steps of progress that [`pick`] reports with this uncertainty.
pub fn steps(uncertainty: Option<Uncertainty>) -> u64 {
    let members = uncertainty.map_or(0, |u| u.members().len());
    (members + 2 * JUMP_POINTS + 1) as u64
}

/// The branch with the largest force.
fn best_branch(rig: &NamedRig) -> Result<Branch, Error> {
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
    })
}

/// The frequencies at which every member has a stable 1/1.
fn robust_range(
    rig: &NamedRig,
    members: &[Member],
    branch: &Branch,
    nominal: &Orbit,
    progress: &dyn Progress,
) -> Result<(f64, f64), Error> {
    let range = (branch.low.frequency_hz, branch.high.frequency_hz);
    let common = members
        .par_iter()
        .map(|member| {
            member.apply(&rig.params, 1.0).check().ok()?;
            let found = stable_interval(&rig.params, member, branch, nominal.frequency_hz, range);
            step(progress, 1).ok()?;
            found
        })
        .try_reduce(|| range, |a, b| Some((a.0.max(b.0), a.1.min(b.1))));
    check(progress)?;
    // The ends of the common range are one member's loss of stability; stay a hair inside.
    let inside = common.map(|(low, high)| {
        let hair = if members.is_empty() {
            0.0
        } else {
            1e-6 * (high - low)
        };
        (low + hair, high - hair)
    });
    inside
        .filter(|(low, high)| low < high)
        .ok_or_else(|| rig.no_pick(PickError::NoneRobust))
}
