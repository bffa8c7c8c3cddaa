//! The nominal 1/1 on ground that gives way, followed over frequency.

use shared::model::params::RigParams;

use super::super::orbit::{DrillOrbit, shoot};
use super::super::run::{DrillSetting, observe, settle};
use super::observe::on;
use crate::branch::{Branch, BranchEdge, BranchEnd, Case};
use crate::interpolation::polynomial;
use crate::orbit::Section;

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
    /// The rig's parameters.
    pub params: RigParams,
    /// Ground and bit; the cart follows the ground.
    pub setting: DrillSetting,
}

impl DrillCase {
    /// The period-one orbit near `guess` at `hz`.
    pub fn orbit(&self, hz: f64, guess: Section) -> Option<DrillOrbit> {
        shoot(&self.params, &self.setting, hz, guess)
    }
}

impl Case for DrillCase {
    type Orbit = DrillOrbit;

    fn params(&self) -> &RigParams {
        &self.params
    }

    fn one_one(&self, hz: f64, guess: Section) -> Option<DrillOrbit> {
        let found = self.orbit(hz, guess)?;
        found.is_stable_one_one().then_some(found)
    }

    fn place(orbit: &DrillOrbit) -> (f64, Section) {
        (orbit.frequency_hz, orbit.section)
    }

    fn resolution_hz(&self, _: f64) -> f64 {
        END * self.params.natural_frequency_hz()
    }
}

/// The stretch of stable 1/1 about `seed`, within `limits_hz`.
pub fn follow(case: DrillCase, seed: DrillOrbit, limits_hz: (f64, f64)) -> Branch<DrillCase> {
    let down = follow_to(&case, seed, limits_hz.0);
    let up = follow_to(&case, seed, limits_hz.1);
    Branch::new(case, down, seed, up)
}

/// Orbits from `seed` (not included) to where the stable 1/1 ends or to `limit_hz`.
fn follow_to(case: &DrillCase, seed: DrillOrbit, limit_hz: f64) -> (Vec<DrillOrbit>, BranchEdge) {
    let natural_hz = case.params.natural_frequency_hz();
    let mut orbits = Vec::new();
    let mut step = STEP * natural_hz;
    let mut last = seed;
    let ahead = (limit_hz - seed.frequency_hz).signum();
    while step > END * natural_hz {
        let to_go = (limit_hz - last.frequency_hz).abs();
        if to_go == 0.0 {
            let (frequency_hz, end) = (limit_hz, BranchEnd::SearchLimit);
            return (orbits, BranchEdge { frequency_hz, end });
        }
        let hz = if step >= to_go {
            limit_hz
        } else {
            last.frequency_hz + ahead * step
        };
        let before = orbits.iter().rev().chain([&seed]).take(3);
        let before: Vec<_> = before.map(DrillCase::place).collect();
        match case.one_one(hz, polynomial(&before, hz)) {
            Some(next) => {
                orbits.push(next);
                last = next;
            }
            None => step *= 0.5,
        }
    }
    let end = end_of(case, &last, last.frequency_hz + 2.0 * ahead * step);
    let frequency_hz = last.frequency_hz;
    (orbits, BranchEdge { frequency_hz, end })
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
