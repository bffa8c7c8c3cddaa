//! Which frequency to run the hammer at.
//!
//! 1. Find the nominal rig's stable 1/1 orbits and follow their branch to both ends by the monodromy
//!    multipliers ([`crate::branch`]).
//! 2. For every corner and sample of the stated uncertainty, find where *it* has a stable 1/1; keep the
//!    frequencies at which all of them have ([`search`]).
//! 3. On what is left, and within the limits asked for, take the largest nominal force.

pub mod picture;
pub mod search;
pub mod sensitivity;
pub mod uncertainty;

use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::TAU;

use crate::branch::{Branch, End, one_one_branches};
use crate::engine::{Engine, Plan, Start};
use crate::error::UserError;
use crate::orbit::Orbit;
use crate::rigfile::NamedRig;
use crate::sweep::{Direction, jumps, single, spread, sweep};
use crate::table::{Row, tidy};
use crate::terminal::Progress;
use search::{Spread, interval_where, maximise, spread_of_members, stable_interval};
use sensitivity::Sensitivity;
use uncertainty::{Member, Uncertainty};

/// Force, as a share of the best, down to which the band reaches.
pub const BAND_SHARE: f64 = 0.9;
/// Up and down sweeps that differ by less than this share of force do not jump.
const JUMP_SHARE: f64 = 0.02;
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

/// What the operating point must respect.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// Largest contact force allowed, N, for every member of the uncertainty.
    pub max_force_n: Option<f64>,
    /// Largest drive frequency allowed, Hz.
    pub max_frequency_hz: Option<f64>,
    /// Largest force the shaker can give to move M + m, N.
    pub max_drive_force_n: Option<f64>,
}

/// A limit, and whether it decided the choice.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LimitUse {
    /// Its name, with its unit.
    pub name: &'static str,
    /// The limit; for the uncertainty, the band it leaves is `robust_band_hz`.
    pub limit: Option<f64>,
    /// Whether a larger force lies beyond it.
    pub binds: bool,
}

/// What the shaker must give at the operating point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Shaker {
    /// Stroke, peak to peak, mm.
    pub stroke_mm: f64,
    /// Peak velocity A0 Ω, m/s.
    pub velocity_m_per_s: f64,
    /// Peak acceleration A0 Ω², m/s².
    pub acceleration_m_per_s2: f64,
    /// Peak force to move cart and hammer, (M + m) A0 Ω², N.
    pub force_n: f64,
    /// Mean power the blows and the support's damping take, W.
    pub mean_power_w: f64,
    /// Peak of the power that swings back and forth, ½ (M + m) A0² Ω³, W.
    pub reactive_power_w: f64,
    /// Energy a blow takes from the hammer, J.
    pub energy_per_blow_j: f64,
    /// Blows per second.
    pub blows_per_second: f64,
}

/// The answer.
#[derive(Clone, Debug, Serialize)]
pub struct Answer {
    /// Name of the rig.
    pub rig: String,
    /// Clearance at rest, mm.
    pub gap_mm: f64,
    /// The frequency to run at, Hz.
    pub operating_frequency_hz: f64,
    /// The same over the natural frequency.
    pub frequency_ratio: f64,
    /// The regime of the orbit picked, as a run that starts on it shows.
    pub regime: String,
    /// The regime a run from rest settles on there.
    pub regime_from_rest: String,
    /// Contact force over m g there.
    pub force_ratio: f64,
    /// The same, N.
    pub force_n: f64,
    /// Smallest force ratio over the uncertainty.
    pub force_ratio_worst: f64,
    /// Largest force ratio over the uncertainty.
    pub force_ratio_largest: f64,
    /// Approach speed, m/s.
    pub approach_speed_m_per_s: f64,
    /// Contact time, ms.
    pub contact_time_ms: f64,
    /// Where the nominal 1/1 is stable and its force above 90 % of that at the operating frequency, Hz.
    pub band_hz: [f64; 2],
    /// The part of it where 1/1 is stable over the whole uncertainty, Hz.
    pub safe_band_hz: [f64; 2],
    /// Where the nominal 1/1 is stable, Hz.
    pub stable_one_one_hz: [f64; 2],
    /// How the stable 1/1 ends, below and above.
    pub stable_one_one_ends: [End; 2],
    /// Where 1/1 is stable over the whole uncertainty, Hz.
    pub robust_band_hz: [f64; 2],
    /// Where the nominal 1/1 doubles its period, Hz; none if it ends otherwise.
    pub period_doubling_hz: Option<f64>,
    /// Largest modulus of the monodromy matrix's eigenvalues at the operating point.
    pub multipliers: f64,
    /// The same, largest over the uncertainty.
    pub multipliers_worst: f64,
    /// Whether up and down sweeps across the stable 1/1 give the same forces.
    pub jump_free: bool,
    /// Whether they do so inside the safe band.
    pub jump_free_in_safe_band: bool,
    /// The lowest and the highest frequency at which they differ, Hz; none when they do not.
    pub jump_range_hz: Option<[f64; 2]>,
    /// Best nominal frequency, no uncertainty and no limits, Hz.
    pub nominal_optimum_hz: f64,
    /// Its force ratio.
    pub nominal_optimum_force_ratio: f64,
    /// Force ratio when driven at the natural frequency (Ω = ω).
    pub force_ratio_at_natural_frequency: f64,
    /// What the shaker must give.
    pub shaker: Shaker,
    /// Limits, and which decide.
    pub limits: Vec<LimitUse>,
    /// Change of the nominal optimum per 1 % of each parameter (gap: per 0.01 mm), largest force first.
    pub sensitivity: Vec<Sensitivity>,
    /// The uncertainty taken into account; none with `--nominal`.
    pub uncertainty: Option<Uncertainty>,
    /// Why this frequency, in one sentence.
    pub why: String,
}

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
}

/// Picks the operating frequency of `rig` (its gap included).
///
/// # Errors
/// One line: there is no stable 1/1, or none that uncertainty and limits allow.
pub fn pick(
    rig: &NamedRig,
    uncertainty: Option<Uncertainty>,
    limits: Limits,
    progress: &Progress,
) -> Result<Pick, UserError> {
    let params = &rig.params;
    params.check()?;
    let branch = best_branch(rig)?;
    let nominal_range = (branch.low.frequency_hz, branch.high.frequency_hz);
    let force_at = |hz: f64| branch.at(params, hz).map(|orbit| (orbit.force_n, orbit));
    let (_, nominal) = maximise(&branch, nominal_range, force_at).ok_or_else(|| no_one_one(rig))?;

    let members = uncertainty.map_or(Vec::new(), |u| u.members());
    let robust = robust_range(rig, &members, &branch, &nominal, progress)?;
    let choice = choose(rig, &members, &branch, robust, limits)?;
    let chosen = &choice.orbit;

    let band = interval_where(&branch, chosen.frequency_hz, nominal_range, |hz| {
        branch
            .at(params, hz)
            .is_some_and(|o| o.is_stable_one_one() && o.force_n >= BAND_SHARE * chosen.force_n)
    });
    let safe_band = (band.0.max(robust.0), band.1.min(robust.1));

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
    let jumps = jumps(&up, &down, params.weight_n(), JUMP_SHARE);
    let in_band = |hz: &f64| (safe_band.0..=safe_band.1).contains(hz);

    let natural_hz = params.natural_frequency_hz();
    let at_natural = single(params, natural_hz, Start::Rest, SETTLED)?;
    let settled = |start| single(params, chosen.frequency_hz, start, SETTLED);
    let from_rest = settled(Start::Rest)?;
    let on_orbit = settled(Start::Section(chosen.section))?;
    let sensitivity = sensitivity::table(params, &branch, &nominal);
    progress.inc(1);

    let weight = params.weight_n();
    let doubles = branch.high.end == End::PeriodDoubling;
    let mut answer = Answer {
        rig: rig.name.clone(),
        gap_mm: tidy(params.gap_m * 1e3),
        operating_frequency_hz: chosen.frequency_hz,
        frequency_ratio: chosen.frequency_hz / params.natural_frequency_hz(),
        regime: on_orbit.regime,
        regime_from_rest: from_rest.regime,
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
        why: String::new(),
    };
    answer.why = why(&answer);
    let curve = branch
        .orbits
        .iter()
        .map(|o| (o.frequency_hz, o.force_n / weight))
        .collect();
    Ok(Pick {
        answer,
        curve,
        up,
        down,
    })
}

/// Steps of progress that [`pick`] reports with this uncertainty.
pub fn steps(uncertainty: Option<Uncertainty>) -> u64 {
    let members = uncertainty.map_or(0, |u| u.members().len());
    (members + 2 * JUMP_POINTS + 1) as u64
}

/// The branch with the largest force.
fn best_branch(rig: &NamedRig) -> Result<Branch, UserError> {
    let largest = |b: &Branch| b.orbits.iter().map(|o| o.force_n).fold(0.0, f64::max);
    let branches = one_one_branches(&rig.params, SEARCH_RATIOS);
    branches
        .into_iter()
        .max_by(|a, b| largest(a).total_cmp(&largest(b)))
        .ok_or_else(|| no_one_one(rig))
}

fn no_one_one(rig: &NamedRig) -> UserError {
    UserError::new(format!(
        "rig {} has no stable 1/1 at a gap of {:?} mm between {} and {} times its natural frequency; try a smaller gap or a larger amplitude",
        rig.name,
        tidy(rig.params.gap_m * 1e3),
        SEARCH_RATIOS.0,
        SEARCH_RATIOS.1
    ))
}

/// The frequencies at which every member has a stable 1/1.
fn robust_range(
    rig: &NamedRig,
    members: &[Member],
    branch: &Branch,
    nominal: &Orbit,
    progress: &Progress,
) -> Result<(f64, f64), UserError> {
    let range = (branch.low.frequency_hz, branch.high.frequency_hz);
    let common = members
        .par_iter()
        .map(|member| {
            member.apply(&rig.params, 1.0).check().ok()?;
            let found = stable_interval(&rig.params, member, branch, nominal.frequency_hz, range);
            progress.inc(1);
            found
        })
        .try_reduce(|| range, |a, b| Some((a.0.max(b.0), a.1.min(b.1))));
    common.filter(|(low, high)| low < high).ok_or_else(|| {
        UserError::new(format!(
            "rig {}: no frequency gives a stable 1/1 for every rig within the uncertainty; narrow it (--amplitude-percent and the like) or use --nominal",
            rig.name
        ))
    })
}

struct Choice {
    orbit: Orbit,
    spread: Spread,
    limits: Vec<LimitUse>,
}

/// The best orbit that uncertainty and limits allow, and which of them decide.
fn choose(
    rig: &NamedRig,
    members: &[Member],
    branch: &Branch,
    robust: (f64, f64),
    limits: Limits,
) -> Result<Choice, UserError> {
    let params = &rig.params;
    let moved_kg = params.cart_mass_kg + params.mass_kg;
    let drive_force = |hz: f64| moved_kg * params.amplitude_m * (TAU * hz).powi(2);
    let below = |value: f64, limit: Option<f64>| limit.is_none_or(|limit| value <= limit);
    // Its members are asked only where a force limit needs them: that is the costly question.
    let allowed = |hz: f64, limits: Limits| {
        if !below(hz, limits.max_frequency_hz) || !below(drive_force(hz), limits.max_drive_force_n)
        {
            return None;
        }
        let orbit = branch.at(params, hz)?;
        if limits.max_force_n.is_some() {
            let spread = spread_of_members(params, members, &orbit)?;
            if !below(spread.strongest_n, limits.max_force_n) {
                return None;
            }
        }
        Some((orbit.force_n, orbit))
    };
    // The ends of the robust range are one member's loss of stability; stay a hair inside.
    let hair = if members.is_empty() {
        0.0
    } else {
        1e-6 * (robust.1 - robust.0)
    };
    let robust = (robust.0 + hair, robust.1 - hair);
    let best = |range: (f64, f64), limits: Limits| {
        // A frequency limit only shortens the range.
        let top = limits
            .max_frequency_hz
            .map_or(range.1, |max| max.min(range.1));
        let by_drive = limits
            .max_drive_force_n
            .map(|max| (max / (moved_kg * params.amplitude_m)).sqrt() / TAU);
        let top = by_drive.map_or(top, |max| max.min(top));
        let only_force = Limits {
            max_force_n: limits.max_force_n,
            ..Limits::default()
        };
        if top < range.0 {
            return None;
        }
        maximise(branch, (range.0, top), |hz| allowed(hz, only_force))
    };
    let free = (branch.low.frequency_hz, branch.high.frequency_hz);
    let (_, orbit) = best(robust, limits).ok_or_else(|| {
        UserError::new(format!(
            "rig {}: no frequency with a stable 1/1 ({:.4} to {:.4} Hz) keeps {}; relax the limits",
            rig.name,
            robust.0,
            robust.1,
            named(limits).join(" and ")
        ))
    })?;
    // A limit binds when dropping it, and it alone, gives more.
    let more = |range: (f64, f64), limits: Limits| {
        best(range, limits).is_some_and(|(_, o)| o.force_n > orbit.force_n * (1.0 + 1e-6))
    };
    let mut uses = Vec::new();
    if !members.is_empty() {
        let binds = more(free, limits);
        uses.push(LimitUse {
            name: "the uncertainty",
            limit: None,
            binds,
        });
    }
    let mut note = |name, limit: Option<f64>, without: Limits| {
        if limit.is_some() {
            uses.push(LimitUse {
                name,
                limit,
                binds: more(robust, without),
            });
        }
    };
    note(
        "max_force_n",
        limits.max_force_n,
        Limits {
            max_force_n: None,
            ..limits
        },
    );
    note(
        "max_frequency_hz",
        limits.max_frequency_hz,
        Limits {
            max_frequency_hz: None,
            ..limits
        },
    );
    note(
        "max_drive_force_n",
        limits.max_drive_force_n,
        Limits {
            max_drive_force_n: None,
            ..limits
        },
    );
    let spread = spread_of_members(params, members, &orbit).ok_or_else(|| {
        UserError::new(format!(
            "rig {}: at {:.4} Hz a rig within the uncertainty has no stable 1/1; narrow the uncertainty",
            rig.name, orbit.frequency_hz
        ))
    })?;
    Ok(Choice {
        orbit,
        spread,
        limits: uses,
    })
}

fn named(limits: Limits) -> Vec<String> {
    let one = |name: &str, limit: Option<f64>| limit.map(|limit| format!("{name} = {limit}"));
    [
        one("max_force_n", limits.max_force_n),
        one("max_frequency_hz", limits.max_frequency_hz),
        one("max_drive_force_n", limits.max_drive_force_n),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn shaker(rig: &NamedRig, orbit: &Orbit) -> Shaker {
    let params = &rig.params;
    let (amplitude, omega) = (params.amplitude_m, TAU * orbit.frequency_hz);
    let moved_kg = params.cart_mass_kg + params.mass_kg;
    Shaker {
        stroke_mm: tidy(2e3 * amplitude),
        velocity_m_per_s: amplitude * omega,
        acceleration_m_per_s2: amplitude * omega.powi(2),
        force_n: moved_kg * amplitude * omega.powi(2),
        mean_power_w: orbit.energy_per_period_j * orbit.frequency_hz,
        reactive_power_w: 0.5 * moved_kg * amplitude.powi(2) * omega.powi(3),
        energy_per_blow_j: orbit.contact.energy_lost_j,
        blows_per_second: f64::from(orbit.impacts) * orbit.frequency_hz,
    }
}

fn why(answer: &Answer) -> String {
    let binding: Vec<_> = answer
        .limits
        .iter()
        .filter(|l| l.binds)
        .map(|l| l.name)
        .collect();
    let among = match (binding.as_slice(), &answer.uncertainty) {
        ([], None) => "It is the strongest stable 1/1 of the nominal rig".to_owned(),
        ([], Some(_)) => {
            "It is the strongest stable 1/1, and 1/1 stays stable over the whole uncertainty"
                .to_owned()
        }
        (names, _) => format!(
            "It is the strongest stable 1/1 that {} allows ({:.1} times the weight at {:.3} Hz without)",
            names.join(" and "),
            answer.nominal_optimum_force_ratio,
            answer.nominal_optimum_hz
        ),
    };
    let end = match answer.period_doubling_hz {
        Some(hz) => format!(
            "the period doubles only at {hz:.3} Hz, {:.0} % higher",
            100.0 * (hz / answer.operating_frequency_hz - 1.0)
        ),
        None => format!(
            "the stable 1/1 ends at {:.3} Hz",
            answer.stable_one_one_hz[1]
        ),
    };
    let jumps = match answer.jump_range_hz {
        None => "and nothing jumps between up and down sweeps".to_owned(),
        Some([low, high]) => {
            let place = if answer.jump_free_in_safe_band {
                "but not"
            } else {
                "also"
            };
            format!(
                "but up and down sweeps differ between {low:.3} and {high:.3} Hz, {place} inside the safe band"
            )
        }
    };
    let alone = if answer.regime_from_rest == answer.regime {
        String::new()
    } else {
        format!(
            "; from rest the hammer does not get there by itself (it ends in {}): it needs a push",
            answer.regime_from_rest
        )
    };
    format!(
        "{among}: {:.1} times the hammer's weight, {:.1} times the force at the natural frequency; {end}, {jumps}{alone}.",
        answer.force_ratio,
        answer.force_ratio / answer.force_ratio_at_natural_frequency
    )
}
