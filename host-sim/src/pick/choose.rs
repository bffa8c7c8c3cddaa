//! The choice on the robust range, within the limits asked for.

use std::f64::consts::TAU;

use super::answer::LimitUse;
use super::search::{Spread, maximise, spread_of_members};
use super::uncertainty::Member;
use crate::branch::Branch;
use crate::error::UserError;
use crate::orbit::Orbit;
use crate::rigfile::NamedRig;

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

/// The orbit chosen.
pub struct Choice {
    /// The nominal orbit.
    pub orbit: Orbit,
    /// Forces over the uncertainty.
    pub spread: Spread,
    /// Limits, and which decide.
    pub limits: Vec<LimitUse>,
}

/// The best orbit that uncertainty and limits allow, and which of them decide.
pub fn choose(
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
