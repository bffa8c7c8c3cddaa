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
pub mod gaps;
pub mod outline;
pub mod search;
pub mod sensitivity;
pub mod uncertainty;

use rayon::prelude::*;
use shared::model::params::RigParams;
use shared::model::regime::Regime;
use shared::model::rig::Rig;

use crate::branch::{Branch, End, one_one_branches};
use crate::engine::{Engine, Plan, Start};
use crate::error::{Error, PickError};
use crate::orbit::Orbit;
use crate::progress::{Progress, WithinStep, check, step};
use crate::row::NamedRig;
use crate::row::{Row, tidy};
use crate::sweep::{Direction, jumps, single, spread, sweep};
use amplitude::lowered;
pub use answer::{Answer, CartModel, Strongest};
use answer::{impact_power, shaker};
pub use bending::Springs;
use bending::{Bending, on_beams};
pub use choose::Limits;
use choose::{Choice, Field};
use search::{interval_where, maximise, stable_interval};
use sensitivity::Sensitivity;
use uncertainty::Member;
pub use uncertainty::Uncertainty;

/// Force, as a share of the best, down to which the band reaches.
pub const BAND_SHARE: f64 = 0.9;
/// Up and down sweeps that differ by less than this share of force do not jump.
pub(crate) const JUMP_SHARE: f64 = 0.02;
/// Points of the curve that is drawn, beside those the branch was followed by.
const CURVE_POINTS: usize = 200;
/// Frequencies in the jump test.
pub(crate) const JUMP_POINTS: usize = 48;
/// Ratios Ω/ω searched for 1/1.
pub(crate) const SEARCH_RATIOS: (f64, f64) = (0.4, 5.0);
/// How long a run settles at a point that is reported.
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

/// Picks the operating frequency of `rig` (its gap included), for its cart as it is in its parameters. Where the rig's
/// shaker is known, the answer has beside it how strong the hammer is with the other cart.
///
/// # Errors
/// If a parameter is out of range; if there is no stable 1/1, or none that uncertainty and limits allow; if a run cannot
/// be followed; or if the work is interrupted.
pub fn pick(
    rig: &NamedRig,
    uncertainty: Option<Uncertainty>,
    limits: Limits,
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
    limits: Limits,
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
    let mut found = pick_at_amplitude(&lower, springs, uncertainty, limits, progress)?;
    found.answer.amplitude_lowered = true;
    Ok(found)
}

fn pick_at_amplitude(
    rig: &NamedRig,
    springs: Springs,
    uncertainty: Option<Uncertainty>,
    limits: Limits,
    progress: &dyn Progress,
) -> Result<Pick, Error> {
    let params = &rig.params;
    params.check()?;
    let branch = best_branch(rig)?;
    check(progress)?;
    let force_at = |hz: f64| branch.at(params, hz).map(|orbit| (orbit.force_n, orbit));
    let (_, nominal) =
        maximise(&branch, range(&branch), force_at).ok_or_else(|| no_one_one(rig))?;
    let power_at = |hz: f64| branch.at(params, hz).map(|o| (impact_power(&o), o));
    let (_, strongest_power) =
        maximise(&branch, range(&branch), power_at).ok_or_else(|| no_one_one(rig))?;

    let certain = Field {
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
    let field = Field {
        rig,
        branch: &branch,
        members: &members,
        progress,
    };
    let mut choice = field.choose(robust, limits)?;
    let allowed = |chosen: &Orbit, limits_hz: (f64, f64)| {
        let band = force_band(params, &branch, chosen);
        (band.0.max(limits_hz.0), band.1.min(limits_hz.1))
    };
    let bent = bending::Request {
        params,
        springs,
        members: &members,
        corners: uncertainty.map_or(0, |u| u.corners().len()),
        chosen_hz: choice.orbit.frequency_hz,
        band_hz: allowed(&choice.orbit, choice.allowed),
        max_force_n: limits.max_force_n,
    }
    .run(progress)?;
    if let Some(bent) = &bent {
        if bent.chosen_hz != choice.orbit.frequency_hz {
            let moved = branch.at(params, bent.chosen_hz);
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
        Some(u) => sensitivity.into_iter().map(|row| row.known_to(u)).collect(),
    };
    let other = other_cart(rig, limits, progress);
    let band = force_band(params, &branch, &choice.orbit);
    let (low, high) = allowed(&choice.orbit, choice.allowed);
    let worst = |hz: f64| Some(field.weakest_at(hz)? / params.weight_n());
    let safe_band = SafeBand {
        hz: (low, high),
        force_ratio_worst: [low, high].map(worst),
    };
    step(progress, 1)?;

    let curve = curve(params, &branch);
    let section = dimensionless_section(params, &choice.orbit)?;
    let found = Found {
        rig,
        branch: &branch,
        nominal: &nominal,
        power: &strongest_power,
        robust,
        band,
        safe_band,
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
fn force_band(params: &RigParams, branch: &Branch, chosen: &Orbit) -> (f64, f64) {
    interval_where(branch, chosen.frequency_hz, range(branch), |hz| {
        branch
            .at(params, hz)
            .is_some_and(|o| o.is_stable_one_one() && o.force_n >= BAND_SHARE * chosen.force_n)
    })
}

/// The nominal stable 1/1: (Hz, force ratio), by rising frequency.
fn curve(params: &RigParams, branch: &Branch) -> Vec<(f64, f64)> {
    let (low, high) = range(branch);
    let mut nodes = spread(low, high, CURVE_POINTS);
    nodes.extend(branch.orbits.iter().map(|o| o.frequency_hz));
    nodes.sort_by(f64::total_cmp);
    let weight = params.weight_n();
    let on_curve = |hz: &f64| branch.at(params, *hz).map(|o| (*hz, o.force_n / weight));
    nodes.par_iter().filter_map(on_curve).collect()
}

/// The section of `orbit` in A0 and A0 Ω of the rig's coordinate.
fn dimensionless_section(params: &RigParams, orbit: &Orbit) -> Result<[f64; 2], Error> {
    let scale = Rig::<f64>::new(params)?.coordinate_scale();
    let rate = scale * std::f64::consts::TAU * orbit.frequency_hz;
    Ok([orbit.section[0] / scale, orbit.section[1] / rate])
}

/// Where the hammer jumps.
struct Jumps {
    /// The sweep up across the nominal stable 1/1.
    up: Vec<Row>,
    /// The sweep down.
    down: Vec<Row>,
    /// Frequencies within the stable 1/1 at which the sweeps differ, and those at which it folds: Hz, rising.
    at_hz: Vec<f64>,
}

impl Jumps {
    fn find(rig: &NamedRig, branch: &Branch, progress: &dyn Progress) -> Result<Self, Error> {
        let (low, high) = range(branch);
        let margin = 0.02 * rig.params.natural_frequency_hz();
        let frequencies = spread(low - margin, high + margin, JUMP_POINTS);
        let one_way = |direction| {
            let (engine, plan) = (Engine::Event, JUMP_PLAN);
            sweep(rig, engine, &frequencies, direction, plan, progress)
        };
        let (up, down) = rayon::join(|| one_way(Direction::Up), || one_way(Direction::Down));
        let (up, down) = (up?, down?);
        // Beyond the ends of the stable 1/1 the sweeps are drawn, and not judged.
        let mut at_hz = jumps(&up, &down, rig.params.weight_n(), JUMP_SHARE);
        at_hz.retain(|hz| (low..=high).contains(hz));
        // Past a fold there is no 1/1 nearby to go over to.
        let ends = [branch.low, branch.high].into_iter();
        let folds = ends.filter(|edge| edge.end == End::Fold);
        at_hz.extend(folds.map(|edge| edge.frequency_hz));
        at_hz.sort_by(f64::total_cmp);
        Ok(Self { up, down, at_hz })
    }
}

/// What settled runs show.
struct Runs {
    /// Force ratio from rest at the natural frequency.
    force_ratio_at_natural: f64,
    /// Regime from rest at the operating frequency.
    from_rest: Regime,
    /// Regime of a run that starts on the orbit picked.
    on_orbit: Regime,
    /// Corners of the uncertainty.
    corners: usize,
    /// How many of them settle on 1/1 from rest.
    corners_reaching: usize,
}

impl Runs {
    fn of(
        params: &RigParams,
        uncertainty: Option<Uncertainty>,
        chosen: &Orbit,
    ) -> Result<Self, Error> {
        let natural_hz = params.natural_frequency_hz();
        let at_natural = single(params, natural_hz, Start::Rest, SETTLED)?;
        let settled = |start| single(params, chosen.frequency_hz, start, SETTLED);
        let from_rest = settled(Start::Rest)?;
        let on_orbit = settled(Start::Section(chosen.section))?;
        let corners = uncertainty.map_or(Vec::new(), |u| u.corners());
        let reaches = |corner: &&Member| {
            let rig = corner.apply(params, 1.0);
            let run = single(&rig, chosen.frequency_hz, Start::Rest, SETTLED);
            run.is_ok_and(|row| row.regime.is(1, 1))
        };
        Ok(Self {
            force_ratio_at_natural: at_natural.force_ratio,
            from_rest: from_rest.regime,
            on_orbit: on_orbit.regime,
            corners: corners.len(),
            corners_reaching: corners.par_iter().filter(reaches).count(),
        })
    }
}

/// The part of the band that uncertainty and limits allow.
struct SafeBand {
    hz: (f64, f64),
    /// Smallest force ratio over the uncertainty at its ends.
    force_ratio_worst: [Option<f64>; 2],
}

/// Where the nominal rig is strongest within the limits with its cart moved the other way. None where its shaker is not
/// known, or no stable 1/1 is within the limits.
fn other_cart(rig: &NamedRig, limits: Limits, progress: &dyn Progress) -> Option<Strongest> {
    let other = if rig.params.cart.recoils() {
        rig.clone().prescribed()
    } else {
        rig.recoiling()?
    };
    let branch = best_branch(&other).ok()?;
    let field = Field {
        rig: &other,
        branch: &branch,
        members: &[],
        progress,
    };
    let orbit = field.choose(range(&branch), limits).ok()?.orbit;
    Some(Strongest {
        frequency_hz: orbit.frequency_hz,
        force_ratio: orbit.force_n / other.params.weight_n(),
    })
}

/// Everything the answer is made of.
struct Found<'a> {
    rig: &'a NamedRig,
    branch: &'a Branch,
    /// The strongest nominal orbit, without uncertainty and limits.
    nominal: &'a Orbit,
    /// The nominal orbit with the most impact power, without uncertainty and limits.
    power: &'a Orbit,
    /// Where 1/1 is stable over the whole uncertainty, Hz.
    robust: (f64, f64),
    /// [`force_band`] of the orbit chosen.
    band: (f64, f64),
    safe_band: SafeBand,
    /// With the other cart.
    other: Option<Strongest>,
    choice: Choice,
    /// [`Jumps::at_hz`].
    jumps: &'a [f64],
    runs: Runs,
    sensitivity: Vec<Sensitivity>,
    uncertainty: Option<Uncertainty>,
    bending: Option<Bending>,
}

impl Found<'_> {
    /// The answer for tables and text.
    fn answer(self) -> Answer {
        let params = &self.rig.params;
        let weight = params.weight_n();
        let chosen = &self.choice.orbit;
        let spread = &self.choice.spread;
        let (band, safe_band) = (self.band, self.safe_band.hz);
        let cart = CartModel::of(params);
        let own = Some(Strongest {
            frequency_hz: chosen.frequency_hz,
            force_ratio: chosen.force_n / weight,
        });
        let (recoil, prescribed) = match cart {
            CartModel::Recoil => (own, self.other),
            CartModel::Prescribed => (self.other, own),
        };
        let in_band = |hz: &f64| (safe_band.0..=safe_band.1).contains(hz);
        let doubles = self.branch.high.end == End::PeriodDoubling;
        Answer {
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
            limits: self.choice.limits,
            sensitivity: self.sensitivity,
            uncertainty: self.uncertainty,
            amplitude_mm: tidy(params.amplitude_m * 1e3),
            amplitude_lowered: false,
            bending: self.bending.unwrap_or_else(|| Bending {
                on_beams: on_beams(params),
                ..Bending::default()
            }),
        }
    }
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
        nearest_gap_m: nearest_gap_m(&rig.params),
    })
}

/// A gap with a stable 1/1 between 0 and that of `params`, near the largest such. None if there is none at 0.
fn nearest_gap_m(params: &RigParams) -> Option<f64> {
    const HALVINGS: usize = 6;
    let has = |gap_m: f64| {
        let rig = RigParams { gap_m, ..*params };
        !one_one_branches(&rig, SEARCH_RATIOS).is_empty()
    };
    if params.gap_m == 0.0 || !has(0.0) {
        return None;
    }
    let (mut with, mut without) = (0.0, params.gap_m);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (with + without);
        if has(middle) {
            with = middle;
        } else {
            without = middle;
        }
    }
    Some(with)
}

/// The largest share of `members` with which every one of them has a stable 1/1 at a common frequency, in hundredths.
fn robust_share(
    rig: &NamedRig,
    members: &[Member],
    branch: &Branch,
    nominal: &Orbit,
    progress: &dyn Progress,
) -> Option<f64> {
    largest_share(members, |smaller| {
        common_range(rig, smaller, branch, nominal, &WithinStep(progress)).is_some()
    })
}

/// The largest share of the deviations of `members` at which they are `robust`, in hundredths. None if there is none.
pub(crate) fn largest_share(members: &[Member], robust: impl Fn(&[Member]) -> bool) -> Option<f64> {
    let robust = |hundredths: u32| {
        let share = f64::from(hundredths) / 100.0;
        let smaller: Vec<_> = members.iter().map(|m| m.scaled(share)).collect();
        robust(&smaller)
    };
    let (mut with, mut without) = (0, 100);
    while without - with > 1 {
        let middle = (with + without) / 2;
        if robust(middle) {
            with = middle;
        } else {
            without = middle;
        }
    }
    (with > 0).then_some(f64::from(with) / 100.0)
}

/// The frequencies at which every member has a stable 1/1.
fn robust_range(
    rig: &NamedRig,
    members: &[Member],
    branch: &Branch,
    nominal: &Orbit,
    progress: &dyn Progress,
) -> Result<(f64, f64), Error> {
    let common = common_range(rig, members, branch, nominal, progress);
    check(progress)?;
    common.ok_or_else(|| {
        rig.no_pick(PickError::NoneRobust {
            share: robust_share(rig, members, branch, nominal, progress),
        })
    })
}

/// The same; none if there is no such frequency, or the work is interrupted.
fn common_range(
    rig: &NamedRig,
    members: &[Member],
    branch: &Branch,
    nominal: &Orbit,
    progress: &dyn Progress,
) -> Option<(f64, f64)> {
    let range = range(branch);
    let common = members
        .par_iter()
        .map(|member| {
            member.apply(&rig.params, 1.0).check().ok()?;
            let found = stable_interval(&rig.params, member, branch, nominal.frequency_hz, range);
            step(progress, 1).ok()?;
            found
        })
        .try_reduce(|| range, |a, b| Some((a.0.max(b.0), a.1.min(b.1))));
    // The ends of the common range are one member's loss of stability; stay a hair inside.
    let inside = common.map(|(low, high)| {
        let hair = if members.is_empty() {
            0.0
        } else {
            1e-6 * (high - low)
        };
        (low + hair, high - hair)
    });
    inside.filter(|(low, high)| low < high)
}
