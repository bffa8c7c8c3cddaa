//! The rigs and grounds that the real ones may be.

use shared::model::contact::Law;
use shared::model::params::RigParams;
use shared::model::slider::Slider;

use super::super::orbit::DrillOrbit;
use super::super::run::DrillSetting;
use super::super::search::GroundUncertainty;
use super::branch::DrillCase;
use crate::branch::{Branch, Case};
use crate::parallel;
use crate::progress::{Progress, check, step};
use crate::root::narrowed;
use crate::uncertainty::{Member, Uncertainty};

/// Steps in which the deviations grow where the orbit is not found at once.
const STEPS: u32 = 4;

/// Ends of a member's range are found to this share of the natural frequency.
const END: f64 = 1e-4;

/// The uncertainty of a rig with that of the ground in place of its contact's, which the ground takes the place of.
#[must_use]
pub fn with_ground(rig: Uncertainty, ground: GroundUncertainty) -> Uncertainty {
    Uncertainty {
        contact_stiffness_percent: ground.ground_stiffness_percent,
        contact_damping_percent: ground.threshold_percent,
        contact_stiffness_factor: None,
        contact_damping_ratio_percent: None,
        ..rig
    }
}

/// `member` of an uncertainty from [`with_ground`] at a `share` of its deviations. The dashpot goes with the spring.
pub fn apply(nominal: &DrillCase, member: &Member, share: f64) -> DrillCase {
    let ground = nominal.setting.ground;
    // Pf and k ride where a contact's stiffness and damping are.
    let carrier = RigParams {
        contact: Law::SpringDashpot {
            stiffness: ground.stiffness,
            damping: ground.threshold,
        },
        ..nominal.params
    };
    let moved = member.apply(&carrier, share);
    let Law::SpringDashpot { stiffness, damping } = moved.contact else {
        return *nominal;
    };
    DrillCase {
        params: RigParams {
            contact: nominal.params.contact,
            ..moved
        },
        setting: DrillSetting {
            ground: Slider {
                stiffness,
                damping: ground.damping * stiffness / ground.stiffness,
                threshold: damping,
            },
            ..nominal.setting
        },
    }
}

/// The stable 1/1 of `member` at the frequency of the nominal `orbit`, followed from it while the deviations grow.
pub fn followed(nominal: &DrillCase, member: &Member, orbit: &DrillOrbit) -> Option<DrillOrbit> {
    let hz = orbit.frequency_hz;
    if let Some(found) = apply(nominal, member, 1.0).one_one(hz, orbit.section) {
        return Some(found);
    }
    let mut found = *orbit;
    for step in 1..=STEPS {
        let there = apply(nominal, member, f64::from(step) / f64::from(STEPS));
        found = there.orbit(hz, found.section)?;
    }
    found.is_stable_one_one().then_some(found)
}

fn has(branch: &Branch<DrillCase>, member: &Member, hz: f64) -> bool {
    let orbit = branch.at(hz);
    orbit.is_some_and(|orbit| followed(&branch.case, member, &orbit).is_some())
}

/// The frequencies about `from_hz` at which every member has a stable 1/1. None where a member has no stable 1/1 at any of a
/// few frequencies near `from_hz`, or the work is interrupted. A step of the progress is a member.
///
/// Each block of members is tried within what the blocks before it have left: few bound the range, mostly corners, which
/// come first.
pub fn common_range(
    branch: &Branch<DrillCase>,
    members: &[Member],
    from_hz: f64,
    progress: &dyn Progress,
) -> Option<(f64, f64)> {
    const BLOCK: usize = 16;
    let (low, high) = branch.range();
    let seeds = [1.0, 0.95, 1.05, 0.9, 0.85].map(|share| (share * from_hz).clamp(low, high));
    let has_all = |hz: f64| {
        let has = |member: &Member| {
            check(progress).ok()?;
            has(branch, member, hz).then_some(())
        };
        parallel::map_all(members, has).is_some()
    };
    let seed = seeds.into_iter().find(|hz| has_all(*hz))?;
    let mut range = (low, high);
    for members in members.chunks(BLOCK) {
        range = shared(branch, members, seed, range);
        step(progress, members.len() as u64).ok()?;
    }
    Some(range)
}

/// The part of `range` about `seed` that every one of `members` has.
fn shared(
    branch: &Branch<DrillCase>,
    members: &[Member],
    seed: f64,
    range: (f64, f64),
) -> (f64, f64) {
    let resolution = END * branch.case.params.natural_frequency_hz();
    let to = |member: &Member, end: f64| {
        if has(branch, member, end) {
            end
        } else {
            narrowed((seed, end), resolution, |hz| !has(branch, member, hz)).0
        }
    };
    let own = |member: &Member| (to(member, range.0), to(member, range.1));
    let inner = |a: (f64, f64), b: (f64, f64)| (a.0.max(b.0), a.1.min(b.1));
    parallel::map(members, own).into_iter().fold(range, inner)
}
