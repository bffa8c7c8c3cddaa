//! What settled runs show of an operating point: where the hammer jumps, and whether it gets there from rest.

use shared::model::params::RigParams;
use shared::model::regime::Regime;

use super::answer::{ShakerNeed, shaker};
use crate::branch::{Branch, BranchEdge, BranchEnd, Case, settle};
use crate::engine::{Arrival, Engine, Plan, STILL, Start, machine, within_reach};
use crate::error::Error;
use crate::orbit::Orbit;
use crate::parallel;
use crate::progress::Progress;
use crate::row::{NamedRig, RunRow};
use crate::sweep::{Direction, along, drawn, jumps, single, spread};
use crate::uncertainty::Uncertainty;

/// Up and down sweeps that differ by less than this share of force do not jump.
pub(crate) const JUMP_SHARE: f64 = 0.02;
/// Frequencies in the jump test.
pub(crate) const JUMP_POINTS: usize = 48;
/// How long a run settles at a point that is reported.
const SETTLED: Plan = Plan {
    cycles: 600,
    transient: 480,
};
/// A run whose peak force differs from that of the orbit by less than this share has settled on it.
const SETTLED_SHARE: f64 = 0.01;
/// How long each step of the jump sweeps settles.
const JUMP_PLAN: Plan = Plan {
    cycles: 140,
    transient: 124,
};

/// Where the hammer jumps.
pub struct Jumps {
    /// The sweep up across the nominal stable 1/1; empty on ground.
    pub up: Vec<RunRow>,
    /// The sweep down across the nominal stable 1/1, rows by rising frequency; empty on ground.
    pub down: Vec<RunRow>,
    /// Frequencies within the stable 1/1 at which the sweeps differ, and those at which it folds: Hz, rising.
    pub at_hz: Vec<f64>,
}

impl Jumps {
    pub(super) fn find(
        rig: &NamedRig,
        branch: &Branch,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        let frequencies = across(branch);
        let run = |hz: &f64, start| drawn(rig, *hz, start, JUMP_PLAN, progress);
        let one_way = |direction| along(&frequencies, direction, run);
        let (up, down) = rayon::join(|| one_way(Direction::Up), || one_way(Direction::Down));
        let (up, down) = (up?, down?);
        let differ = jumps(&up, &down, rig.params.weight_n(), JUMP_SHARE);
        let at_hz = judged(differ, branch);
        Ok(Self { up, down, at_hz })
    }
}

/// The frequencies of the jump test, Hz.
pub(crate) fn across<C: Case>(branch: &Branch<C>) -> Vec<f64> {
    let (low, high) = branch.range();
    let margin = 0.02 * branch.case.params().natural_frequency_hz();
    spread(low - margin, high + margin, JUMP_POINTS)
}

/// [`Jumps::at_hz`], where the sweeps `differ`. Beyond the ends of the stable 1/1 they are drawn, and not judged.
pub(crate) fn judged<C: Case>(mut differ: Vec<f64>, branch: &Branch<C>) -> Vec<f64> {
    let (low, high) = branch.range();
    differ.retain(|hz| (low..=high).contains(hz));
    // Past a fold there is no 1/1 nearby to go over to.
    let ends = [branch.low, branch.high].into_iter();
    let folds = ends.filter(|edge| edge.end == BranchEnd::Fold);
    differ.extend(folds.map(|edge: BranchEdge| edge.frequency_hz));
    differ.sort_by(f64::total_cmp);
    differ
}

/// Drive periods from rest until the force stays within [`SETTLED_SHARE`] of that of `chosen`; none if it does not.
fn settling_cycles(params: &RigParams, chosen: &Orbit) -> Result<Option<u32>, Error> {
    let mut hammer = machine(Engine::Event, params, chosen.frequency_hz, Start::Rest)?;
    let mut arrival = Arrival::of(hammer.as_ref(), STILL);
    let mut last_apart = 0;
    for cycle in 1..=SETTLED.cycles {
        let force_n = hammer.period(None).peak_force;
        within_reach(hammer.as_ref())?;
        if (force_n / chosen.force_n - 1.0).abs() > SETTLED_SHARE {
            last_apart = cycle;
        }
        if arrival.at(&hammer.section()) == Some(1) {
            if last_apart == cycle {
                return Ok(None);
            }
            break;
        }
    }
    Ok((last_apart <= SETTLED.transient).then_some(last_apart))
}

/// What settled runs show.
pub struct Runs {
    /// Force ratio from rest at the natural frequency.
    pub force_ratio_at_natural: f64,
    /// Regime from rest at the operating frequency.
    pub from_rest: Regime,
    /// Regime of a run that starts on the orbit picked.
    pub on_orbit: Regime,
    /// Drive periods after which a run from rest stays within 1 % of the force of the orbit picked; none if
    /// it does not get there.
    pub settling_cycles: Option<u32>,
    /// Corners of the uncertainty.
    pub corners: usize,
    /// How many of them settle on 1/1 from rest.
    pub corners_reaching: usize,
    /// Speed at which the hammer meets the surface on the orbit picked, m/s.
    pub approach_speed_m_per_s: f64,
    /// How long it stays, s.
    pub contact_s: f64,
    /// What the shaker must give for the orbit picked.
    pub shaker: ShakerNeed,
}

impl Runs {
    pub(super) fn of(
        params: &RigParams,
        uncertainty: Option<Uncertainty>,
        chosen: &Orbit,
    ) -> Result<Self, Error> {
        let natural_hz = params.natural_frequency_hz();
        let at_natural = single(params, natural_hz, Start::Rest, SETTLED)?;
        let settled = |start| single(params, chosen.frequency_hz, start, SETTLED);
        let from_rest = settled(Start::Rest)?;
        let on_orbit = settled(Start::Section(chosen.section))?;
        let corners = uncertainty.map_or(Vec::new(), |u| u.corners());
        let reaching = parallel::map(&corners, |corner| {
            let rig = corner.apply(params, 1.0);
            settle(&rig, chosen.frequency_hz, Start::Rest, SETTLED).is_some()
        });
        Ok(Self {
            force_ratio_at_natural: at_natural.force_ratio,
            settling_cycles: settling_cycles(params, chosen)?,
            from_rest: from_rest.regime,
            on_orbit: on_orbit.regime,
            corners: corners.len(),
            corners_reaching: reaching.iter().filter(|reaches| **reaches).count(),
            approach_speed_m_per_s: chosen.contact.approach_speed_m_per_s,
            contact_s: chosen.contact.duration_s,
            shaker: shaker(params, chosen),
        })
    }
}
