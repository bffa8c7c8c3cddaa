//! Where 1/1 is stable over the whole uncertainty, and how much less uncertainty would do where it is nowhere.

use rayon::prelude::*;

use super::range;
use super::search::own_branch;
use crate::branch::Branch;
use crate::error::{Error, PickError};
use crate::orbit::Orbit;
use crate::progress::{Progress, WithinStep, check, step};
use crate::row::NamedRig;
use crate::uncertainty::Member;

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

/// The frequency to run at keeps this share of itself away from where a rig of the uncertainty loses its 1/1: the corners are
/// a fraction of all, and a drive drifts.
pub(crate) const RESERVE: f64 = 0.01;

/// What of `robust`, Hz, keeps the [`RESERVE`]; its middle where it is too narrow for that. All of it without uncertainty.
pub(crate) fn with_reserve(robust: (f64, f64), uncertain: bool) -> (f64, f64) {
    if !uncertain {
        return robust;
    }
    let (low, high) = (robust.0 * (1.0 + RESERVE), robust.1 * (1.0 - RESERVE));
    if low < high {
        return (low, high);
    }
    let middle = 0.5 * (robust.0 + robust.1);
    (middle, middle)
}

/// Where every member has a stable 1/1.
pub(super) struct Robust {
    /// Hz.
    pub(super) hz: (f64, f64),
    /// For each member (Hz, N) along its own branch.
    forces: Vec<Vec<(f64, f64)>>,
}

impl Robust {
    /// Smallest and largest force over the nominal rig and the members at points of the nominal `curve` (Hz, N), within the
    /// range: (Hz, N, N).
    pub(super) fn force_range(&self, curve: &[(f64, f64)]) -> Vec<[f64; 3]> {
        let inside = curve
            .iter()
            .filter(|(hz, _)| (self.hz.0..=self.hz.1).contains(hz));
        let at = inside.map(|&(hz, nominal)| {
            let forces = self.forces.iter().filter_map(|own| between(own, hz));
            forces.fold([hz, nominal, nominal], |[hz, low, high], n| {
                [hz, low.min(n), high.max(n)]
            })
        });
        at.collect()
    }
}

/// The force at `hz` on the line through the points of rising frequency on either side. None beyond them.
fn between(points: &[(f64, f64)], hz: f64) -> Option<f64> {
    let above = points.partition_point(|(x, _)| *x < hz);
    let b = points.get(above)?;
    let a = points.get(above.checked_sub(1)?)?;
    Some(a.1 + (b.1 - a.1) * (hz - a.0) / (b.0 - a.0))
}

/// The frequencies at which every member has a stable 1/1.
pub(super) fn robust_range(
    rig: &NamedRig,
    members: &[Member],
    branch: &Branch,
    nominal: &Orbit,
    progress: &dyn Progress,
) -> Result<Robust, Error> {
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
) -> Option<Robust> {
    let mut common = range(branch);
    let mut forces = Vec::with_capacity(members.len());
    for block in members.chunks(BLOCK) {
        let left = common;
        let found: Option<Vec<Branch>> = block
            .par_iter()
            .map(|member| {
                member.apply(&rig.params, 1.0).check().ok()?;
                let start_hz = nominal.frequency_hz;
                let found = own_branch(&rig.params, member, branch, start_hz, left);
                step(progress, 1).ok()?;
                found
            })
            .collect();
        let found = found?;
        common = found
            .iter()
            .map(range)
            .fold(left, |a, b| (a.0.max(b.0), a.1.min(b.1)));
        if common.0 >= common.1 {
            return None;
        }
        let points = |own: &Branch| {
            own.orbits
                .iter()
                .map(|o| (o.frequency_hz, o.force_n))
                .collect()
        };
        forces.extend(found.iter().map(points));
    }
    // The ends of the common range are one member's loss of stability; stay a hair inside.
    let (low, high) = common;
    let hair = if members.is_empty() {
        0.0
    } else {
        1e-6 * (high - low)
    };
    let hz = (low + hair, high - hair);
    (hz.0 < hz.1).then_some(Robust { hz, forces })
}
