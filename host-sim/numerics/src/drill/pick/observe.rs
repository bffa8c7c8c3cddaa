//! What runs on the ground show: where to begin, the orbit chosen, its reach from rest, and jumps.

use super::branch::DrillCase;
use super::members::apply;
use crate::branch::Branch;
use crate::drill::march::Drill;
use crate::drill::orbit::DrillOrbit;
use crate::drill::run::{DrillPlan, grid, observe, run};
use crate::drill::search::Among;
use crate::error::{Error, MotionError};
use crate::orbit::Section;
use crate::parallel;
use crate::pick::answer::{ShakerNeed, drive_force};
use crate::pick::runs::{JUMP_SHARE, Jumps, Runs, across, judged};
use crate::progress::{Progress, step};
use crate::row::{NamedRig, tidy};
use crate::sweep::spread;
use crate::uncertainty::Uncertainty;

/// Ratios Ω/ω of the runs from rest among which the best 1/1 is where the branch begins, and how many.
const SEED_RATIOS: (f64, f64, usize) = (0.9, 4.0, 32);

/// How long they are.
const SEED_PLAN: DrillPlan = DrillPlan {
    settle: 300,
    recorded: 16,
};

/// Drive periods in which a point that is reported is observed.
const OBSERVED: u32 = 48;

/// Drive periods at each frequency of the jump test, and those of them whose progress is compared.
const JUMP_PERIODS: u32 = 60;
const JUMP_RECORDED: u32 = 16;

/// The stable 1/1 that drills fastest from rest. None if there is none.
///
/// # Errors
/// [`Error::NoProgress`] if nothing gives way; else as [`run`].
pub fn seed(
    rig: &NamedRig,
    case: &DrillCase,
    progress: &dyn Progress,
) -> Result<Option<DrillOrbit>, Error> {
    let natural_hz = rig.params.natural_frequency_hz();
    let (from, to, count) = SEED_RATIOS;
    let frequencies = spread(from * natural_hz, to * natural_hz, count);
    let gap_mm = [tidy(rig.params.gap_m * 1e3)];
    let rows = grid(
        rig,
        &case.setting,
        &gap_mm,
        &frequencies,
        SEED_PLAN,
        progress,
    )?;
    if Among::All.best(&rows).is_none() {
        return Err(Error::NoProgress {
            threshold_n: case.setting.ground.threshold,
        });
    }
    let Some(best) = Among::OneOne.best(&rows) else {
        return Ok(None);
    };
    let hz = rows[best].frequency_hz;
    let seen = run(&case.params, &case.setting, hz, SEED_PLAN)?;
    let found = case.orbit(hz, seen.guess());
    Ok(found.filter(DrillOrbit::is_stable_one_one))
}

/// The hammer at rest.
fn at_rest(case: &DrillCase, hz: f64) -> Result<Drill<f64>, Error> {
    Ok(Drill::through(&case.params, &case.setting, hz)?)
}

/// The hammer on its section point.
///
/// # Errors
/// The first parameter out of range.
pub fn on(case: &DrillCase, hz: f64, section: Section) -> Result<Drill<f64>, Error> {
    let mut drill = at_rest(case, hz)?;
    let [q, v, off, off_rate] = section;
    drill.place_off([q, v, 0.0], [off, off_rate]);
    Ok(drill)
}

/// Largest force of the shaker for `orbit`, N: of its position loop, or of a prescribed cart what moves M + m.
pub fn shaker_force_n(case: &DrillCase, orbit: &DrillOrbit) -> f64 {
    loop_force_n(case, orbit).unwrap_or_else(|| drive_force(&case.params, orbit.frequency_hz))
}

/// The largest force of the loop over a period of `orbit`, N. None with a prescribed cart.
pub fn loop_force_n(case: &DrillCase, orbit: &DrillOrbit) -> Option<f64> {
    let drill = on(case, orbit.frequency_hz, orbit.section).ok()?;
    let mut drill = drill.watching_the_loop();
    drill.run_period(&mut Vec::new());
    drill.largest_loop_force_n()
}

/// What runs show of `chosen`, over the `uncertainty` of [`super::members::with_ground`].
///
/// # Errors
/// If a motion cannot be followed.
pub fn runs(
    case: &DrillCase,
    chosen: &DrillOrbit,
    uncertainty: Option<Uncertainty>,
) -> Result<Runs, Error> {
    let (hz, params) = (chosen.frequency_hz, &case.params);
    let mut drill = on(case, hz, chosen.section)?;
    let on_orbit = observe(&mut drill, hz, OBSERVED)?;
    let damping_j = drill.energies().damping / f64::from(OBSERVED);
    let lost = MotionError::Lost { frequency_hz: hz };
    let blow = *on_orbit.blows.last().ok_or(lost)?;
    let at_rest = |case: &DrillCase, hz: f64| run(&case.params, &case.setting, hz, SEED_PLAN);
    let corners = uncertainty.map_or(Vec::new(), |u| u.corners());
    let reaching = parallel::map(&corners, |corner| {
        let there = apply(case, corner, 1.0);
        at_rest(&there, hz).is_ok_and(|seen| seen.regime.is(1, 1))
    });
    let at_natural = at_rest(case, params.natural_frequency_hz())?;
    Ok(Runs {
        force_ratio_at_natural: at_natural.force_n / params.weight_n(),
        from_rest: at_rest(case, hz)?.regime,
        on_orbit: on_orbit.regime,
        // The force is cut off at the threshold: it says nothing of settling.
        settling_cycles: None,
        corners: corners.len(),
        corners_reaching: reaching.iter().filter(|reaches| **reaches).count(),
        approach_speed_m_per_s: blow.approach_speed_m_per_s,
        contact_s: blow.duration_s,
        shaker: ShakerNeed {
            mean_power_w: (chosen.contact_j + damping_j) * hz,
            energy_per_blow_j: chosen.contact_j,
            loop_force_n: loop_force_n(case, chosen),
            ..ShakerNeed::to_move(params, hz)
        },
    })
}

/// Where sweeps up and down dig differently, and where the 1/1 folds.
///
/// # Errors
/// If a motion cannot be followed, or the work is interrupted.
pub fn jumps(branch: &Branch<DrillCase>, progress: &dyn Progress) -> Result<Jumps, Error> {
    let case = &branch.case;
    let up = across(branch);
    let down: Vec<f64> = up.iter().rev().copied().collect();
    let one_way = |frequencies| sweep(case, frequencies, progress);
    let (a, b) = rayon::join(|| one_way(&up), || one_way(&down));
    let (a, mut b) = (a?, b?);
    b.reverse();
    let largest = a.iter().chain(&b).copied().fold(0.0, f64::max);
    let differ = |i: &usize| (a[*i] - b[*i]).abs() > JUMP_SHARE * largest;
    let differ = (0..up.len()).filter(differ).map(|i| up[i]).collect();
    Ok(Jumps {
        up: Vec::new(),
        down: Vec::new(),
        at_hz: judged(differ, branch),
    })
}

/// Progress per period at each frequency, m, each from where the last one ended.
fn sweep(
    case: &DrillCase,
    frequencies: &[f64],
    progress: &dyn Progress,
) -> Result<Vec<f64>, Error> {
    let mut last: Option<Section> = None;
    let mut dug = Vec::with_capacity(frequencies.len());
    for hz in frequencies {
        let mut drill = match last {
            None => at_rest(case, *hz)?,
            Some(section) => on(case, *hz, section)?,
        };
        let mut blows = Vec::new();
        let mut before = 0.0;
        for period in 0..JUMP_PERIODS {
            if period == JUMP_PERIODS - JUMP_RECORDED {
                before = drill.drift_m();
            }
            drill.run_period(&mut blows);
            blows.clear();
        }
        let ([q, v, _], [off, off_rate]) = (drill.section(), drill.cart());
        if q.is_nan() {
            return Err(MotionError::Lost { frequency_hz: *hz }.into());
        }
        last = Some([q, v, off, off_rate]);
        dug.push((drill.drift_m() - before) / f64::from(JUMP_RECORDED));
        step(progress, 1)?;
    }
    Ok(dug)
}
