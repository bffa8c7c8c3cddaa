//! The rigs and grounds that the real ones may be.

use shared::model::contact::Law;
use shared::model::params::RigParams;
use shared::model::slider::Slider;

use super::super::orbit::DrillOrbit;
use super::super::search::GroundUncertainty;
use super::branch::{DrillCase, GroundBranch};
use crate::parallel;
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
    let ground = nominal.ground;
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
        ground: Slider {
            stiffness,
            damping: ground.damping * stiffness / ground.stiffness,
            threshold: damping,
        },
        bit: nominal.bit,
    }
}

/// What is spread over the uncertainty at a frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrillSpread {
    /// Smallest rate of penetration, m/s.
    pub least_m_per_s: f64,
    /// Largest rate of penetration, m/s.
    pub most_m_per_s: f64,
    /// Smallest contact force, N.
    pub weakest_n: f64,
    /// Largest contact force, N.
    pub strongest_n: f64,
    /// Largest modulus of a multiplier.
    pub multiplier: f64,
}

impl DrillSpread {
    fn of(orbit: &DrillOrbit) -> Self {
        let rate = orbit.rate_m_per_s();
        Self {
            least_m_per_s: rate,
            most_m_per_s: rate,
            weakest_n: orbit.force_n,
            strongest_n: orbit.force_n,
            multiplier: orbit.multipliers().modulus(),
        }
    }

    fn with(self, other: Self) -> Self {
        Self {
            least_m_per_s: self.least_m_per_s.min(other.least_m_per_s),
            most_m_per_s: self.most_m_per_s.max(other.most_m_per_s),
            weakest_n: self.weakest_n.min(other.weakest_n),
            strongest_n: self.strongest_n.max(other.strongest_n),
            multiplier: self.multiplier.max(other.multiplier),
        }
    }
}

/// The nominal branch and everything that the real rig and ground may be.
#[derive(Clone, Copy)]
pub struct Crowd<'a> {
    /// Nominal.
    pub case: &'a DrillCase,
    /// Its stable 1/1.
    pub branch: &'a GroundBranch,
    /// The members.
    pub members: &'a [Member],
}

impl Crowd<'_> {
    /// The stable 1/1 of `member` at the frequency of the nominal `orbit`, followed from it while the deviations grow.
    fn follow(&self, member: &Member, orbit: &DrillOrbit) -> Option<DrillOrbit> {
        let hz = orbit.frequency_hz;
        if let Some(found) = apply(self.case, member, 1.0).one_one(hz, orbit.section) {
            return Some(found);
        }
        let mut found = *orbit;
        for step in 1..=STEPS {
            let there = apply(self.case, member, f64::from(step) / f64::from(STEPS));
            found = there.orbit(hz, found.section)?;
        }
        found.is_stable_one_one().then_some(found)
    }

    fn has(&self, member: &Member, hz: f64) -> bool {
        let orbit = self.branch.at(hz);
        orbit.is_some_and(|orbit| self.follow(member, &orbit).is_some())
    }

    /// Rates, forces and multipliers at `hz`. None where a member has no stable 1/1.
    pub fn spread(&self, hz: f64) -> Option<DrillSpread> {
        let orbit = self.branch.at(hz)?;
        let followed = parallel::map_all(self.members, |m| self.follow(m, &orbit))?;
        let own = DrillSpread::of(&orbit);
        Some(
            followed
                .iter()
                .fold(own, |all, o| all.with(DrillSpread::of(o))),
        )
    }

    /// The frequencies about `from_hz` at which every member has a stable 1/1. None where a member has no stable 1/1 at any of a
    /// few frequencies near `from_hz`.
    ///
    /// Each block of members is tried within what the blocks before it have left: few bound the range, mostly corners, which
    /// come first.
    pub fn common_range(&self, from_hz: f64) -> Option<(f64, f64)> {
        const BLOCK: usize = 16;
        let (low, high) = self.branch.range();
        let seeds = [1.0, 0.95, 1.05, 0.9, 0.85].map(|share| (share * from_hz).clamp(low, high));
        let all =
            |hz: f64| parallel::map_all(self.members, |m| self.has(m, hz).then_some(())).is_some();
        let seed = seeds.into_iter().find(|hz| all(*hz))?;
        let blocks = self.members.chunks(BLOCK);
        Some(blocks.fold((low, high), |range, members| {
            self.shared(members, seed, range)
        }))
    }

    /// The part of `range` about `seed` that every one of `members` has.
    fn shared(&self, members: &[Member], seed: f64, range: (f64, f64)) -> (f64, f64) {
        let resolution = END * self.case.params.natural_frequency_hz();
        let to = |member: &Member, end: f64| {
            if self.has(member, end) {
                end
            } else {
                narrowed((seed, end), resolution, |hz| !self.has(member, hz)).0
            }
        };
        let own = |member: &Member| (to(member, range.0), to(member, range.1));
        let inner = |a: (f64, f64), b: (f64, f64)| (a.0.max(b.0), a.1.min(b.1));
        parallel::map(members, own).into_iter().fold(range, inner)
    }
}
