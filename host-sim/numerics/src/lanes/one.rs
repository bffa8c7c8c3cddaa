//! One cell by one of the engines, without lanes.

use shared::model::contacts::Period;
use shared::model::regime::{Detector, MAX_PERIODS};

use super::{Cell, CellOutcome, CellPlan, LaneStrobe, Strobes};
use crate::engine::{Engine, Start, machine_at, within_reach};
use crate::error::Error;

/// Runs one cell by `engine`, all its cycles.
///
/// # Errors
/// If a parameter, the frequency or the start is out of range, or if the hammer leaves what the model describes.
pub fn run_one(engine: Engine, cell: &Cell, plan: &CellPlan) -> Result<CellOutcome, Error> {
    let start = Start::Section(cell.start);
    let mut hammer = machine_at(engine, &cell.params, cell.frequency_hz, start, cell.phase)?;
    let scale = hammer.rig().coordinate_scale();
    let units = [scale, scale * std::f64::consts::TAU * hammer.frequency_hz()];
    let mut detector = Detector::new(units[0], units[1]);
    let opening = plan.cycles.saturating_sub(plan.recorded);
    let first_kept = plan.cycles.saturating_sub(plan.strobes);
    let mut last_contact = None;
    let mut force_n = 0.0_f64;
    let mut sections = Vec::with_capacity(plan.cycles as usize + 1);
    let mut strobes = Vec::new();
    if cell.phase > 0.0 {
        hammer.period(None);
    }
    sections.push(hammer.section());
    for cycle in 1..=plan.cycles {
        if cycle == opening + 1 {
            let [q, v] = hammer.section();
            detector.push(q, v, &Period::default());
        }
        let period = hammer.period(None);
        within_reach(hammer.as_ref())?;
        let [q, v] = hammer.section();
        sections.push([q, v]);
        if period.touched {
            last_contact = Some(cycle);
        }
        if cycle > opening {
            detector.push(q, v, &period);
            force_n = force_n.max(period.peak_force);
        }
        if cycle > first_kept {
            strobes.push(LaneStrobe {
                q,
                v,
                force_n: period.peak_force,
                onsets: period.onsets,
            });
        }
    }
    let regime = detector.regime();
    let before = opening.min(plan.cycles) as usize;
    let unsettled = self::strobes(&sections[before + 1..], units).still_change(regime, before);
    let repeats = regime.periods().filter(|_| !unsettled);
    Ok(CellOutcome {
        regime,
        unsettled,
        force_n,
        settled_after: repeats
            .map(|n| self::strobes(&sections, units).settled_after(usize::from(n))),
        cycles: plan.cycles,
        searched: MAX_PERIODS.min(plan.recorded as usize / 2) as u8,
        last_contact,
        uncertain: false,
        section: hammer.section(),
        strobes,
    })
}

/// The strobes of a section, whose distances are in `units` of it.
pub(crate) fn strobes(
    section: &[[f64; 2]],
    units: [f64; 2],
) -> Strobes<impl Fn(usize, usize) -> f64> {
    Strobes::new(section.len(), move |i, j| {
        let apart = |k: usize| (section[j][k] - section[i][k]).abs() / units[k];
        apart(0).max(apart(1))
    })
}
