//! Where 1/1 is stable over the whole uncertainty, and how much less uncertainty would do where it is nowhere.

use rayon::prelude::*;

use super::range;
use super::search::stable_interval;
use super::uncertainty::Member;
use crate::branch::Branch;
use crate::error::{Error, PickError};
use crate::orbit::Orbit;
use crate::progress::{Progress, WithinStep, check, step};
use crate::row::NamedRig;

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
pub(super) fn robust_range(
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

/// Members that are followed side by side.
const BLOCK: usize = 32;

/// The same; none if there is no such frequency, or the work is interrupted.
///
/// Each block of members is followed within what the blocks before it have left: few rigs bound the range (mostly corners,
/// which come first), and the ends of the others' branches beyond it need not be found.
fn common_range(
    rig: &NamedRig,
    members: &[Member],
    branch: &Branch,
    nominal: &Orbit,
    progress: &dyn Progress,
) -> Option<(f64, f64)> {
    let mut common = range(branch);
    for block in members.chunks(BLOCK) {
        let left = common;
        common = block
            .par_iter()
            .map(|member| {
                member.apply(&rig.params, 1.0).check().ok()?;
                let start_hz = nominal.frequency_hz;
                let found = stable_interval(&rig.params, member, branch, start_hz, left);
                step(progress, 1).ok()?;
                found
            })
            .try_reduce(|| left, |a, b| Some((a.0.max(b.0), a.1.min(b.1))))
            .filter(|(low, high)| low < high)?;
    }
    // The ends of the common range are one member's loss of stability; stay a hair inside.
    let (low, high) = common;
    let hair = if members.is_empty() {
        0.0
    } else {
        1e-6 * (high - low)
    };
    Some((low + hair, high - hair)).filter(|(low, high)| low < high)
}
