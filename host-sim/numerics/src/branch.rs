//! The branch of 1/1 orbits over drive frequency: where it is stable, and how each end comes about.

use shared::model::params::RigParams;

use crate::continuation::{self, Along, Family, Special, Until, march};
use crate::engine::{Arrival, CycleRecorder, Engine, Plan, Start, machine, observe, within_reach};
use crate::found_once::FoundOnce;
use crate::interpolation::{around, polynomial};
use crate::lanes;
use crate::orbit::{Exactness, Orbit, Section, shoot, shoot_at, shoot_to};
use crate::parallel;
use crate::root::{largest, stretch};

/// How a stable 1/1 ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum BranchEnd {
    /// A multiplier passes −1: the orbit doubles its period.
    PeriodDoubling,
    /// Another contact appears in the period (a graze).
    ExtraContact,
    /// A multiplier passes +1, or the orbit is no longer found: a fold, where the hammer jumps.
    Fold,
    /// The search stopped here; the branch goes on.
    SearchLimit,
    /// The contact lasts over drive phase 0, where the section is taken: the branch goes on, and is not followed.
    ContactAtSection,
}

/// An end of the branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BranchEdge {
    /// Where, Hz: the last frequency at which the orbit is a stable 1/1.
    pub frequency_hz: f64,
    /// How the stable 1/1 ends there.
    pub end: BranchEnd,
}

/// What has a 1/1 that is followed over frequency: a rig on a surface that stays, or on ground that gives way.
pub trait Case: Clone + Send + Sync {
    /// Its 1/1 orbit at one drive frequency.
    type Orbit: Clone + Send + Sync;

    /// The rig's parameters.
    fn params(&self) -> &RigParams;

    /// The 1/1 near `guess` at `hz`, as it is told.
    fn one_one(&self, hz: f64, guess: Section) -> Option<Self::Orbit>;

    /// The frequency and section point of an orbit.
    fn place(orbit: &Self::Orbit) -> (f64, Section);

    /// To what ends and best frequencies are found near `hz`, Hz.
    fn resolution_hz(&self, hz: f64) -> f64;
}

impl Case for RigParams {
    type Orbit = Orbit;

    fn params(&self) -> &RigParams {
        self
    }

    fn one_one(&self, hz: f64, guess: Section) -> Option<Orbit> {
        shoot_at(self, hz, guess, 1)
    }

    fn place(orbit: &Orbit) -> (f64, Section) {
        (orbit.frequency_hz, orbit.at())
    }

    fn resolution_hz(&self, hz: f64) -> f64 {
        1e-7 * hz
    }
}

/// A stretch of stable 1/1 orbits.
#[derive(Clone, Debug)]
pub struct Branch<C: Case = RigParams> {
    /// What it is of.
    pub case: C,
    /// Orbits along it, by rising frequency, the ends included.
    pub orbits: Vec<C::Orbit>,
    /// End at the lowest frequency.
    pub low: BranchEdge,
    /// End at the highest frequency.
    pub high: BranchEdge,
    /// What was found at the frequencies asked for, each sought once.
    between: FoundOnce<C::Orbit>,
}

impl<C: Case> Branch<C> {
    /// Of orbits on either side of `seed`, each list from it outwards and without it, and how they end.
    pub fn new(
        case: C,
        (mut down, low): (Vec<C::Orbit>, BranchEdge),
        seed: C::Orbit,
        (up, high): (Vec<C::Orbit>, BranchEdge),
    ) -> Self {
        down.reverse();
        down.push(seed);
        down.extend(up);
        Self {
            case,
            orbits: down,
            low,
            high,
            between: FoundOnce::default(),
        }
    }

    /// Where it is stable, Hz.
    pub fn range(&self) -> (f64, f64) {
        (self.low.frequency_hz, self.high.frequency_hz)
    }

    /// The frequencies of its orbits, Hz, rising.
    pub fn frequencies(&self) -> impl Iterator<Item = f64> {
        self.orbits.iter().map(|o| C::place(o).0)
    }

    /// The 1/1 orbit at `hz`, found from its nearest neighbours on the branch. `None` outside the branch.
    pub fn at(&self, hz: f64) -> Option<C::Orbit> {
        // From the branch's orbits alone, so that it is the same whoever asks first.
        let find = || self.near(hz, |guess| self.case.one_one(hz, guess));
        self.between.at(hz, find)
    }

    /// The orbit at `hz` if it is one of the branch's, else what `find` makes of where it is to be sought.
    fn near(&self, hz: f64, find: impl FnOnce(Section) -> Option<C::Orbit>) -> Option<C::Orbit> {
        let frequency = |o: &C::Orbit| C::place(o).0;
        let (first, last) = (self.orbits.first()?, self.orbits.last()?);
        if !(frequency(first)..=frequency(last)).contains(&hz) {
            return None;
        }
        let near = around(&self.orbits, hz, 2, frequency);
        if let Some(known) = near.iter().find(|o| frequency(o) == hz) {
            return Some(known.clone());
        }
        let near: Vec<_> = near.iter().map(C::place).collect();
        find(beside(&near, hz))
    }

    /// The frequency in `within_hz` at which `value` is largest, and what comes with it ([`largest`]).
    pub fn largest<T>(
        &self,
        within_hz: (f64, f64),
        value: impl Fn(f64) -> Option<(f64, T)>,
    ) -> Option<(f64, T)> {
        let tolerance = self.case.resolution_hz(within_hz.1);
        largest(self.frequencies(), within_hz, tolerance, value)
    }

    /// The orbit in `within_hz` of which `value` is largest.
    pub fn best(
        &self,
        within_hz: (f64, f64),
        value: impl Fn(&C::Orbit) -> f64,
    ) -> Option<C::Orbit> {
        let worth = |hz: f64| self.at(hz).map(|orbit| (value(&orbit), orbit));
        Some(self.largest(within_hz, worth)?.1)
    }

    /// The interval about `from_hz`, inside `within_hz`, on which `holds` is true ([`stretch`]).
    pub fn stretch(
        &self,
        from_hz: f64,
        within_hz: (f64, f64),
        holds: impl Fn(f64) -> bool,
    ) -> (f64, f64) {
        let width = self.case.resolution_hz(from_hz);
        stretch(self.frequencies(), from_hz, within_hz, width, holds)
    }
}

/// Ends are reported this far inside the branch, as a share of the natural frequency: there the orbit is still what the
/// branch is of.
const EDGE_TOLERANCE: f64 = 1e-7;

impl Branch {
    /// Follows the stable 1/1 from `seed` both ways, within `limits_hz`, by pseudo-arclength.
    pub fn follow(params: &RigParams, seed: Orbit, limits_hz: (f64, f64)) -> Self {
        let down = march_to(params, &seed, limits_hz, -1.0);
        let up = march_to(params, &seed, limits_hz, 1.0);
        Self::new(*params, down, seed, up)
    }

    /// The contact force of the 1/1 at `hz`, N, to some 1e-7. `None` outside the branch.
    pub fn force_n_at(&self, hz: f64) -> Option<f64> {
        let find = |guess| shoot_to(Exactness::OF_MANY, &self.case, hz, guess, 1);
        Some(self.near(hz, find)?.force_n)
    }
}

/// The section point at `frequency_hz` beside a few orbits at the `places`, by rising frequency: on the polynomial through them,
/// but near the line through the two next to it, since a polynomial swings out where the branch folds.
pub(crate) fn beside(places: &[(f64, Section)], frequency_hz: f64) -> Section {
    /// How far from the line, as a share of what the orbits span.
    const NEAR: f64 = 0.25;
    let curve = polynomial(places, frequency_hz);
    if places.len() <= 2 {
        return curve;
    }
    let line = polynomial(around(places, frequency_hz, 1, |k| k.0), frequency_hz);
    [0, 1, 2, 3].map(|i| {
        let all = places.iter().map(|(_, at)| at[i]);
        let span = all.clone().fold(f64::MIN, f64::max) - all.fold(f64::MAX, f64::min);
        let near = NEAR * span;
        curve[i].max(line[i] - near).min(line[i] + near)
    })
}

/// Stable 1/1 orbits from `seed` (not included) up or down (`direction` 1 or −1) in frequency, and how they end.
fn march_to(
    params: &RigParams,
    seed: &Orbit,
    limits_hz: (f64, f64),
    direction: f64,
) -> (Vec<Orbit>, BranchEdge) {
    let unit = params.natural_frequency_hz();
    let limits = (limits_hz.0 / unit, limits_hz.1 / unit);
    let family = Family::new(params, Along::Frequency, 1).ok();
    let started = family.and_then(|family| {
        let node = family.node_at(seed.frequency_hz / unit, seed.at())?;
        let along = node.tangent[2] * direction > 0.0;
        Some((family, if along { node } else { node.turned() }))
    });
    let Some((family, start)) = started else {
        let (frequency_hz, end) = (seed.frequency_hz, BranchEnd::Fold);
        return (Vec::new(), BranchEdge { frequency_hz, end });
    };
    let (nodes, ended) = march(&family, &start, limits, Until::Special);
    let end = match ended {
        continuation::CurveEnd::Limit => BranchEnd::SearchLimit,
        continuation::CurveEnd::Special(Special::PeriodDoubling) => BranchEnd::PeriodDoubling,
        continuation::CurveEnd::Special(Special::GrazingGained) => BranchEnd::ExtraContact,
        _ => BranchEnd::Fold,
    };
    let mut orbits: Vec<Orbit> = nodes.into_iter().map(|n| n.orbit).collect();
    if end != BranchEnd::SearchLimit {
        // The special orbit itself lies on the border.
        let before = orbits.len().checked_sub(2).map_or(seed, |i| &orbits[i]);
        let last = orbits.last().unwrap_or(seed);
        let frequency_hz = last.frequency_hz - direction * EDGE_TOLERANCE * unit;
        let guess = polynomial(&[before, last].map(RigParams::place), frequency_hz);
        let inside = shoot_at(params, frequency_hz, guess, 1).filter(Orbit::is_stable_one_one);
        orbits.pop();
        orbits.extend(inside);
    }
    let frequency_hz = orbits.last().unwrap_or(seed).frequency_hz;
    (orbits, BranchEdge { frequency_hz, end })
}

/// Ratios to the natural frequency at which a stable 1/1 is searched for.
const SEEDS: [f64; 10] = [1.5, 2.0, 1.3, 1.8, 2.3, 1.1, 2.7, 1.0, 0.9, 3.2];
/// How long a seed may take to settle, drive periods.
const SETTLE: Plan = Plan {
    cycles: 320,
    transient: 280,
};

/// Stable stretches of 1/1, found from seeds started at rest and with a push, by rising frequency.
pub fn one_one_branches(params: &RigParams, limits_ratio: (f64, f64)) -> Vec<Branch> {
    let unit = params.natural_frequency_hz();
    let limits_hz = (limits_ratio.0 * unit, limits_ratio.1 * unit);
    let mut found: Vec<Branch> = Vec::new();
    let settled = |ratio: f64| {
        let push = Start::Moving(-3.0 * params.amplitude_m - params.gap_m.abs(), 0.0);
        let mut starts = [Start::Rest, push].into_iter();
        starts.find_map(|start| settle(params, ratio * unit, start, SETTLE))
    };
    let known = |found: &[Branch], ratio: f64| {
        let holds =
            |b: &Branch| (b.low.frequency_hz..=b.high.frequency_hz).contains(&(ratio * unit));
        found.iter().any(holds)
    };
    let mut seeds: Vec<f64> = SEEDS.to_vec();
    seeds.retain(|ratio| (limits_ratio.0..=limits_ratio.1).contains(ratio));
    // The first branch covers most seeds; what is left of them is looked at side by side.
    while !seeds.is_empty() {
        let side_by_side = if found.is_empty() { 1 } else { seeds.len() };
        let now: Vec<f64> = seeds.drain(..side_by_side).collect();
        let orbits = parallel::map(&now, |ratio| settled(*ratio));
        for (ratio, orbit) in now.into_iter().zip(orbits) {
            if let Some(seed) = orbit.filter(|_| !known(&found, ratio)) {
                found.push(Branch::follow(params, seed, limits_hz));
            }
        }
        seeds.retain(|ratio| !known(&found, *ratio));
    }
    found.sort_by(|a, b| a.low.frequency_hz.total_cmp(&b.low.frequency_hz));
    found
}

/// Of the stable stretches of 1/1 the one with the largest force.
pub fn strongest_branch(params: &RigParams, limits_ratio: (f64, f64)) -> Option<Branch> {
    let largest = |b: &Branch| b.orbits.iter().map(|o| o.force_n).fold(0.0, f64::max);
    let branches = one_one_branches(params, limits_ratio).into_iter();
    branches.max_by(|a, b| largest(a).total_cmp(&largest(b)))
}

/// The stable 1/1 that a run of `plan` from `start` settles on, if it does.
pub(crate) fn settle(
    params: &RigParams,
    frequency_hz: f64,
    start: Start,
    plan: Plan,
) -> Option<Orbit> {
    /// A run that moves less than this from one strobe to the next, in A0 and A0 Ω, is left to Newton's iteration.
    const NEAR: f64 = 1e-6;
    let mut hammer = machine(Engine::Event, params, frequency_hz, start).ok()?;
    let orbit = |section| shoot(params, frequency_hz, section).filter(Orbit::is_stable_one_one);
    if let Some(run) = lanes::settled(params, frequency_hz, hammer.section(), plan) {
        return orbit(run.section).filter(|_| run.regime.is(1, 1));
    }
    let mut arrival = Arrival::of(hammer.as_ref(), NEAR);
    for _ in 0..plan.transient {
        hammer.period(None);
        within_reach(hammer.as_ref()).ok()?;
        if arrival.at(&hammer.section()) == Some(1) {
            return orbit(hammer.section());
        }
    }
    let recorded = Plan {
        cycles: plan.cycles - plan.transient,
        transient: 0,
    };
    let seen = observe(hammer.as_mut(), recorded, &mut CycleRecorder::default()).ok()?;
    if !seen.regime.is(1, 1) {
        return None;
    }
    orbit(hammer.section())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::orbit::Multipliers;
    use shared::model::params::{BEAM_150, WIRES};

    #[test]
    fn the_chapter_s_first_band_on_wires_at_zero_gap() {
        let branches = one_one_branches(&WIRES, (0.5, 4.0));
        assert_eq!(branches.len(), 1);
        let branch = &branches[0];
        let ratio = |edge: BranchEdge| edge.frequency_hz / WIRES.natural_frequency_hz();
        // Several contacts per cycle below about 1.16, doubled at 2.7.
        assert_eq!(branch.low.end, BranchEnd::ExtraContact);
        assert!(
            (1.14..1.17).contains(&ratio(branch.low)),
            "{}",
            ratio(branch.low)
        );
        assert_eq!(branch.high.end, BranchEnd::PeriodDoubling);
        assert!(
            (2.6..2.7).contains(&ratio(branch.high)),
            "{}",
            ratio(branch.high)
        );
        let last = branch.orbits.last().unwrap();
        let multipliers = last.multipliers();
        assert!(
            matches!(multipliers, Multipliers::Real(smallest, _) if (smallest + 1.0).abs() < 1e-5),
            "{multipliers:?}"
        );
    }

    #[test]
    fn beyond_the_doubling_the_simulation_doubles_and_before_it_does_not() {
        let branch = &one_one_branches(&BEAM_150, (0.5, 4.0))[0];
        let edge = branch.high.frequency_hz;
        let regime = |frequency_hz: f64| {
            let mut hammer = machine(Engine::Event, &BEAM_150, frequency_hz, Start::Rest).unwrap();
            let plan = Plan {
                cycles: 900,
                transient: 860,
            };
            observe(hammer.as_mut(), plan, &mut CycleRecorder::default())
                .unwrap()
                .regime
        };
        assert!(regime(0.995 * edge).is(1, 1));
        assert!(regime(1.005 * edge).is(2, 2));
    }
}
