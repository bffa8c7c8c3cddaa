//! The nominal 1/1 on ground that gives way, followed over frequency.

use shared::model::bit::Bit;
use shared::model::params::RigParams;
use shared::model::slider::Slider;

use super::super::orbit::{DrillOrbit, shoot};
use super::super::run::{observe, settle};
use super::observe::on;
use crate::branch::{BranchEdge, BranchEnd, beside};
use crate::found_once::FoundOnce;
use crate::interpolation::{around, polynomial};
use crate::orbit::Section;
use crate::root::{largest, stretch};

/// Steps along the branch, as a share of the natural frequency.
const STEP: f64 = 0.02;

/// Ends and best frequencies are found to this share of the natural frequency.
const END: f64 = 1e-5;

/// A multiplier beyond this, of either sign, at an end says how the branch ends.
const NEAR_ONE: f64 = 0.9;

/// Drive periods in which what is beyond an end settles, and in which it is seen.
const SETTLE: u32 = 300;
const RECORDED: u32 = 48;

/// Hammer, ground and bit.
#[derive(Clone, Copy, Debug)]
pub struct DrillCase {
    /// The rig.
    pub params: RigParams,
    /// The ground.
    pub ground: Slider<f64>,
    /// The bit between them.
    pub bit: Option<Bit<f64>>,
}

impl DrillCase {
    /// The 1/1 near `guess` at `hz`, if it is stable.
    pub fn one_one(&self, hz: f64, guess: Section) -> Option<DrillOrbit> {
        let found = self.orbit(hz, guess)?;
        found.is_stable_one_one().then_some(found)
    }

    /// The period-one orbit near `guess` at `hz`.
    pub fn orbit(&self, hz: f64, guess: Section) -> Option<DrillOrbit> {
        shoot(&self.params, &self.ground, self.bit.as_ref(), hz, guess)
    }
}

fn place(orbit: &DrillOrbit) -> (f64, Section) {
    (orbit.frequency_hz, orbit.section)
}

/// A stretch of stable 1/1 orbits, by rising frequency.
#[derive(Clone, Debug)]
pub struct GroundBranch {
    case: DrillCase,
    /// Orbits along it, the ends included.
    pub orbits: Vec<DrillOrbit>,
    /// Its lower end.
    pub low: BranchEdge,
    /// Its upper end.
    pub high: BranchEdge,
    /// Orbits found between.
    between: FoundOnce<DrillOrbit>,
}

impl GroundBranch {
    /// Follows the 1/1 `seed` both ways within `limits_hz`.
    pub fn follow(case: DrillCase, seed: DrillOrbit, limits_hz: (f64, f64)) -> Self {
        let (mut orbits, low) = follow(&case, seed, limits_hz.0);
        orbits.reverse();
        orbits.pop();
        let (up, high) = follow(&case, seed, limits_hz.1);
        orbits.extend(up);
        Self {
            case,
            orbits,
            low,
            high,
            between: FoundOnce::default(),
        }
    }

    /// Where it is stable, Hz.
    pub fn range(&self) -> (f64, f64) {
        (self.low.frequency_hz, self.high.frequency_hz)
    }

    /// The orbit at `hz`.
    pub fn at(&self, hz: f64) -> Option<DrillOrbit> {
        let near = around(&self.orbits, hz, 2, |o| o.frequency_hz);
        if let Some(known) = near.iter().find(|o| o.frequency_hz == hz) {
            return Some(*known);
        }
        let near: Vec<_> = near.iter().map(place).collect();
        let find = || self.case.one_one(hz, beside(&near, hz));
        self.between.at(hz, find)
    }

    /// The orbit in `range_hz` with the largest `value`, which is None where it is not allowed.
    pub fn best(
        &self,
        range_hz: (f64, f64),
        value: impl Fn(&DrillOrbit) -> Option<f64>,
    ) -> Option<DrillOrbit> {
        if range_hz.0 > range_hz.1 {
            return None;
        }
        let worth = |hz: f64| {
            let orbit = self.at(hz)?;
            Some((value(&orbit)?, orbit))
        };
        let found = largest(self.frequencies(), range_hz, self.resolution(), worth)?;
        Some(found.1)
    }

    /// How far the stretch about `from_hz` goes, within `range_hz`, on which `holds`.
    pub fn interval(
        &self,
        from_hz: f64,
        range_hz: (f64, f64),
        holds: impl Fn(f64) -> bool,
    ) -> (f64, f64) {
        let nodes = self.frequencies();
        stretch(nodes, from_hz, range_hz, self.resolution(), holds)
    }

    /// The frequencies of its orbits, Hz, rising.
    pub fn frequencies(&self) -> impl Iterator<Item = f64> {
        self.orbits.iter().map(|o| o.frequency_hz)
    }

    fn resolution(&self) -> f64 {
        END * self.case.params.natural_frequency_hz()
    }
}

/// Orbits from `seed` to where the stable 1/1 ends or to `limit_hz`, `seed` first.
fn follow(case: &DrillCase, seed: DrillOrbit, limit_hz: f64) -> (Vec<DrillOrbit>, BranchEdge) {
    let natural_hz = case.params.natural_frequency_hz();
    let mut orbits = vec![seed];
    let mut step = STEP * natural_hz;
    let mut last = seed;
    let ahead = (limit_hz - seed.frequency_hz).signum();
    while step > END * natural_hz {
        let to_go = (limit_hz - last.frequency_hz).abs();
        if to_go == 0.0 {
            let edge = BranchEdge {
                frequency_hz: limit_hz,
                end: BranchEnd::SearchLimit,
            };
            return (orbits, edge);
        }
        let hz = if step >= to_go {
            limit_hz
        } else {
            last.frequency_hz + ahead * step
        };
        let before: Vec<_> = orbits.iter().rev().take(3).map(place).collect();
        match case.one_one(hz, polynomial(&before, hz)) {
            Some(next) => {
                orbits.push(next);
                last = next;
            }
            None => step *= 0.5,
        }
    }
    let end = end_of(case, &last, last.frequency_hz + 2.0 * ahead * step);
    let edge = BranchEdge {
        frequency_hz: last.frequency_hz,
        end,
    };
    (orbits, edge)
}

/// How the branch ends at its last orbit, seen from `beyond_hz`.
fn end_of(case: &DrillCase, last: &DrillOrbit, beyond_hz: f64) -> BranchEnd {
    use crate::orbit::Multipliers::Real;
    match last.multipliers() {
        Real(small, _) if small < -NEAR_ONE => return BranchEnd::PeriodDoubling,
        Real(_, big) if big > NEAR_ONE => return BranchEnd::Fold,
        _ => {}
    }
    let beyond = on(case, beyond_hz, last.section).and_then(|mut drill| {
        settle(&mut drill, SETTLE);
        observe(&mut drill, beyond_hz, RECORDED)
    });
    match beyond.map(|seen| seen.regime) {
        // It goes on, but hammer or bit is still in contact at drive phase 0, where no orbit is sought.
        Ok(regime) if regime.is(1, 1) => BranchEnd::ContactAtSection,
        Ok(regime) if regime.periods() == Some(1) => BranchEnd::ExtraContact,
        _ => BranchEnd::Fold,
    }
}
