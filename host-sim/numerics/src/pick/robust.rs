//! Where 1/1 is stable over the whole uncertainty, and how much less uncertainty would do where it is nowhere.

use shared::model::params::RigParams;

use super::case::PickCase;
use super::follow::{across, along, nodes};
use crate::branch::Branch;
use crate::error::{Error, PickError};
use crate::orbit::Orbit;
use crate::parallel;
use crate::progress::{Progress, WithinStep, check, step};
use crate::row::NamedRig;
use crate::uncertainty::Member;

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
pub struct Robust<C: PickCase = RigParams> {
    /// Lowest and highest frequency at which every member has a stable 1/1, Hz.
    pub hz: (f64, f64),
    /// The members, and what is known of their orbits there.
    pub members: Vec<C::Followed>,
}

impl Robust {
    /// Smallest and largest force over the nominal rig and the members at points of the nominal `curve` (Hz, N), within the
    /// range: (Hz, N, N).
    pub(super) fn force_range(&self, curve: &[(f64, f64)]) -> Vec<[f64; 3]> {
        let inside = curve
            .iter()
            .filter(|(hz, _)| (self.hz.0..=self.hz.1).contains(hz));
        let at = inside.map(|&(hz, nominal)| {
            let known = self.members.iter().filter_map(|own| own.known_at(hz));
            known.fold([hz, nominal, nominal], |[hz, low, high], known| {
                [hz, low.min(known.force_n), high.max(known.force_n)]
            })
        });
        at.collect()
    }
}

/// The frequencies at which every member has a stable 1/1.
pub(super) fn robust_range<C: PickCase>(
    rig: &NamedRig,
    members: &[Member],
    branch: &Branch<C>,
    nominal: &C::Orbit,
    progress: &dyn Progress,
) -> Result<Robust<C>, Error> {
    let common = C::common_range(branch, members, nominal, progress);
    check(progress)?;
    common.ok_or_else(|| {
        let within = WithinStep(progress);
        let robust = |smaller: &[_]| C::common_range(branch, smaller, nominal, &within).is_some();
        let share = largest_share(members, robust);
        rig.no_pick(PickError::NoneRobust { share })
    })
}

/// Members that are followed side by side, at first and later.
const FIRST_BLOCK: usize = 8;
const BLOCK: usize = 32;

/// [`PickCase::common_range`].
///
/// Each block of members is followed within what the blocks before it have left: few rigs bound the range (mostly corners,
/// which come first), and the ends of the others' branches beyond it need not be found.
pub(super) fn common_range(
    members: &[Member],
    branch: &Branch,
    nominal: &Orbit,
    progress: &dyn Progress,
) -> Option<Robust> {
    let params = &branch.case;
    let mut common = branch.range();
    let mut known = Vec::with_capacity(members.len());
    let (first, others) = members.split_at(members.len().min(FIRST_BLOCK));
    for members in std::iter::once(first).chain(others.chunks(BLOCK)) {
        let nodes = nodes(params, branch, common)?;
        let found = parallel::map_all(members, |member| {
            member.apply(params, 1.0).check().ok()?;
            let found = across(params, member, branch, &nodes)
                .or_else(|| along(params, member, branch, nominal, common));
            step(progress, 1).ok()?;
            found
        })?;
        for ((low, high), followed) in found {
            common = (common.0.max(low), common.1.min(high));
            known.push(followed);
        }
        if common.0 >= common.1 {
            return None;
        }
    }
    // The ends of the common range are one member's loss of stability; stay a hair inside.
    let (low, high) = common;
    let hair = if members.is_empty() {
        0.0
    } else {
        1e-6 * (high - low)
    };
    let (low, high) = (low + hair, high - hair);
    (low < high).then_some(Robust {
        hz: (low, high),
        members: known,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::branch::one_one_branches;
    use crate::pick::search::own_branch;
    use crate::uncertainty::Uncertainty;
    use shared::model::cart::{ASSUMED_SHAKER, CartDrive};
    use shared::model::params::{RigParams, WIRES};

    /// What is found beside the nominal orbits is what is found by following each member's whole branch: where the common
    /// range ends, and the force between.
    #[test]
    fn members_beside_the_nominal_orbits_end_where_their_branches_do() {
        let params = RigParams {
            cart: CartDrive::Loop(ASSUMED_SHAKER),
            ..WIRES
        };
        let uncertainty = Uncertainty {
            samples: 6,
            ..Uncertainty::usual(true)
        };
        let members: Vec<_> = uncertainty.members().into_iter().rev().take(20).collect();
        let branch = one_one_branches(&params, (1.0, 3.0)).swap_remove(0);
        let nominal = branch.at(3.4).unwrap();
        let found = common_range(&members, &branch, &nominal, &()).unwrap();
        let whole = members
            .iter()
            .map(|m| own_branch(&params, m, &branch, 3.4, branch.range()).unwrap())
            .collect::<Vec<_>>();
        let ends = whole.iter().map(Branch::range);
        let (low, high) = ends.fold((0.0_f64, f64::MAX), |a, b| (a.0.max(b.0), a.1.min(b.1)));
        let off = (found.hz.0 - low).abs().max((found.hz.1 - high).abs());
        assert!(off < 2e-6 * (high - low), "{:?} {low} {high}", found.hz);
        for (known, own) in found.members.iter().zip(&whole) {
            for hz in [low + 0.1, 3.0, 3.4, high - 0.1] {
                let exact = own.at(hz).unwrap().force_n;
                let drawn = known.known_at(hz).unwrap().force_n;
                assert!((drawn / exact - 1.0).abs() < 1e-3, "{hz}: {drawn} {exact}");
            }
        }
    }
}
