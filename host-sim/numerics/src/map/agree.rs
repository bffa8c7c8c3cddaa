//! How far maps agree: with the reference, with another engine, with another rig's.

use rand::SeedableRng;
use rand::seq::index::sample;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use shared::model::regime::Regime;

use super::compute::{cell_from_rest, settled};
use super::request::MapRequest;
use super::{Map, MapCell};
use crate::engine::Engine;
use crate::error::{Error, MapError};
use crate::lanes::{Cell, CellPlan, each_by_engine, or_failed, run_one};
use crate::progress::{Progress, step};
use crate::sweep::Direction;

/// Two forces are the same when they differ by no more than this share of the larger.
pub const FORCE_TOLERANCE: f64 = 1e-3;

/// Cells compared one by one, and how many agree in what.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Agreement {
    /// Pairs of cells compared.
    pub cells: usize,
    /// Same label: none, aperiodic, chatter, or the same p/n.
    pub same_label: usize,
    /// Both find a section that repeats.
    pub both_periodic: usize,
    /// Of these, same p and n.
    pub same_p_n: usize,
    /// Of these, force the same within [`FORCE_TOLERANCE`].
    pub same_force: usize,
    /// Flagged as uncertain in the first of the two.
    pub uncertain: usize,
    /// Of those with another label, cells where both motions exist: the reference keeps the first's label when it starts
    /// in the first's motion. `None` where this was not looked for.
    pub coexisting: Option<usize>,
}

impl Agreement {
    /// Compares cell by cell.
    pub fn of<'a>(pairs: impl IntoIterator<Item = (&'a MapCell, &'a MapCell)>) -> Self {
        let mut found = Self::default();
        for (a, b) in pairs {
            found.cells += 1;
            found.same_label += usize::from(same_cell(a, b));
            found.uncertain += usize::from(a.uncertain);
            let (Some(n), Some(m)) = (a.regime.periods(), b.regime.periods()) else {
                continue;
            };
            found.both_periodic += 1;
            let same = n == m && a.regime.impacts() == b.regime.impacts();
            found.same_p_n += usize::from(same);
            let largest = a.force_n.max(b.force_n);
            let near = (a.force_n - b.force_n).abs() <= FORCE_TOLERANCE * largest;
            found.same_force += usize::from(near);
        }
        found
    }
}

/// Whether two cells show the same: a run that failed shows nothing, which is not "no contact".
fn same_cell(a: &MapCell, b: &MapCell) -> bool {
    a.failed == b.failed && same_label(a.regime, b.regime)
}

/// Whether two regimes have the same name.
pub fn same_label(a: Regime, b: Regime) -> bool {
    match (a, b) {
        (Regime::None, Regime::None)
        | (Regime::Aperiodic { .. }, Regime::Aperiodic { .. })
        | (Regime::Chatter { .. }, Regime::Chatter { .. }) => true,
        (Regime::Periodic { .. }, Regime::Periodic { .. }) => a == b,
        _ => false,
    }
}

/// Runs `count` cells of `map`, drawn with `seed`, again by the reference, all their cycles, and compares.
///
/// # Errors
/// If the map was made with the state carried, so that its cells depend on each other, or if the work is interrupted.
pub fn audit(
    request: &MapRequest,
    map: &Map,
    (count, seed): (usize, u64),
    progress: &dyn Progress,
) -> Result<Agreement, Error> {
    check_audit(request)?;
    let count = count.min(map.cells.len());
    let mut chosen =
        sample(&mut ChaCha8Rng::seed_from_u64(seed), map.cells.len(), count).into_vec();
    chosen.sort_unstable();
    let mut again = Vec::with_capacity(count);
    let plan = |cycles: u32| CellPlan {
        cycles,
        early: false,
        ..request.plan
    };
    // In portions, so that the progress moves.
    for portion in chosen.chunks(64) {
        let cells = portion.iter().map(|i| cell_from_rest(request, *i));
        let cells = cells.collect::<Result<Vec<_>, _>>()?;
        let first = each_by_engine(Engine::Event, &cells, &plan(request.plan.cycles));
        for (cell, seen) in cells.iter().zip(first) {
            let mut seen = or_failed(seen)?;
            let settled = seen.as_ref().is_none_or(|o| o.settled_after.is_some());
            if let (false, Some(longer)) = (settled, request.settle) {
                seen = or_failed(run_one(Engine::Event, cell, &plan(longer)))?;
            }
            again.push(seen.as_ref().map_or(MapCell::FAILED, MapCell::from));
        }
        step(progress, portion.len() as u64)?;
    }
    let mut found = Agreement::of(chosen.iter().map(|i| &map.cells[*i]).zip(&again));
    let mut coexisting = 0;
    for (i, seen) in chosen.iter().zip(&again) {
        let cell = &map.cells[*i];
        if cell.failed || seen.failed || same_label(cell.regime, seen.regime) {
            continue;
        }
        let first = settled(request, &[cell_from_rest(request, *i)?])?;
        if let [Some(left)] = first.as_slice() {
            let kept = Cell {
                start: left.section,
                ..cell_from_rest(request, *i)?
            };
            let kept = or_failed(run_one(Engine::Event, &kept, &plan(request.plan.cycles)))?;
            let kept = kept.map_or(MapCell::FAILED, |seen| MapCell::from(&seen));
            coexisting += usize::from(!kept.failed && same_label(kept.regime, cell.regime));
        }
        step(progress, 0)?;
    }
    found.coexisting = Some(coexisting);
    Ok(found)
}

/// Whether an audit of this request makes sense, before any work.
///
/// # Errors
/// As [`audit`].
pub fn check_audit(request: &MapRequest) -> Result<(), Error> {
    if request.from == Direction::Rest {
        return Ok(());
    }
    Err(MapError::AuditCarried.into())
}

/// How alike two maps are over Ω/ω and gap/A0.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Similarity {
    /// Names of the two rigs.
    pub rigs: [String; 2],
    /// Cells of the first that have a place in the second.
    pub cells: usize,
    /// Of these, same label.
    pub same: usize,
    /// Of these, cells with contact in at least one of the two.
    pub striking: usize,
    /// Of the cells with contact, same label.
    pub same_striking: usize,
    /// Of these, both repeat with n of at most 2: the orderly part.
    pub orderly: usize,
    /// Of the orderly, same label.
    pub same_orderly: usize,
}

/// Compares the cells of `a` with those of `b` that lie nearest over Ω/ω and gap/A0.
pub fn similarity(a: &Map, b: &Map) -> Similarity {
    let rows = places(&a.gap_ratios(), &b.gap_ratios());
    let columns = places(&a.frequency_ratios(), &b.frequency_ratios());
    let mut found = Similarity {
        rigs: [a.rig.name.clone(), b.rig.name.clone()],
        ..Similarity::default()
    };
    let orderly = |r: Regime| r.periods().is_some_and(|n| n <= 2);
    for (i, row) in rows.iter().enumerate() {
        for (j, column) in columns.iter().enumerate() {
            let (Some(row), Some(column)) = (*row, *column) else {
                continue;
            };
            let (here, there) = (a.cell(i, j), b.cell(row, column));
            let (x, y) = (here.regime, there.regime);
            let same = usize::from(same_cell(here, there));
            found.cells += 1;
            found.same += same;
            if x != Regime::None || y != Regime::None {
                found.striking += 1;
                found.same_striking += same;
            }
            if orderly(x) && orderly(y) {
                found.orderly += 1;
                found.same_orderly += same;
            }
        }
    }
    found
}

/// For every value of `from`, where among the rising `to` the nearest is; none beyond half a step outside.
pub(super) fn places(from: &[f64], to: &[f64]) -> Vec<Option<usize>> {
    let half_step = match to {
        [first, .., last] => 0.5 * (last - first) / (to.len() - 1) as f64,
        _ => 0.0,
    };
    let reach = half_step * (1.0 + 1e-6) + 1e-9;
    let nearest = |x: &f64| {
        let above = to.partition_point(|t| t < x);
        let candidates = [above.checked_sub(1), (above < to.len()).then_some(above)];
        let distance = |i: &usize| (to[*i] - x).abs();
        let near = candidates.into_iter().flatten();
        let near = near.min_by(|i, j| distance(i).total_cmp(&distance(j)))?;
        let inside = to[0] - reach <= *x && *x <= to[to.len() - 1] + reach;
        inside.then_some(near)
    };
    from.iter().map(nearest).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::measured::{MeasuredRegime, hits};
    use crate::map::{Grid, Runner};
    use crate::row::NamedRig;
    use shared::model::params::{BEAM_150, BEAM_170, RigParams};

    fn cell(regime: Regime, force_n: f64, uncertain: bool) -> MapCell {
        MapCell {
            regime,
            force_n,
            searched: 16,
            uncertain,
            failed: false,
            ..MapCell::FAILED
        }
    }

    fn periodic(impacts: u16, periods: u8) -> Regime {
        Regime::Periodic { impacts, periods }
    }

    #[test]
    fn every_kind_of_agreement_is_counted() {
        let chatter = |impacts| Regime::Chatter {
            impacts,
            periods: None,
        };
        let a = [
            cell(periodic(1, 1), 10.0, false),
            cell(periodic(2, 2), 10.0, true),
            cell(Regime::Aperiodic { impacts: 9 }, 5.0, false),
            cell(chatter(40), 5.0, false),
            cell(Regime::None, 0.0, false),
            cell(Regime::None, 0.0, false),
        ];
        let b = [
            cell(periodic(1, 1), 10.0 * (1.0 - 0.9e-3), false),
            cell(periodic(1, 1), 10.1, false),
            cell(Regime::Aperiodic { impacts: 11 }, 50.0, false),
            cell(chatter(41), 5.0, true),
            cell(Regime::None, 0.0, false),
            cell(periodic(1, 2), 1.0, false),
        ];
        let found = Agreement::of(a.iter().zip(&b));
        let expected = Agreement {
            cells: 6,
            same_label: 4,
            both_periodic: 2,
            same_p_n: 1,
            same_force: 1,
            uncertain: 1,
            coexisting: None,
        };
        assert_eq!(found, expected);
    }

    #[test]
    fn nearest_places_are_found_and_none_outside() {
        let to = [1.0, 2.0, 3.0];
        let places = places(&[0.4, 0.5, 1.4, 1.6, 3.5, 3.6, f64::NAN], &to);
        let expected = [None, Some(0), Some(0), Some(1), Some(2), None, None];
        assert_eq!(places, expected);
        assert_eq!(super::places(&[1.0, 2.0], &[2.0]), [None, Some(0)]);
        assert_eq!(super::places(&[1.0], &[]), [None]);
    }

    /// At this cell the lanes come to rest on 6/14 and the reference loses contact: both motions exist.
    #[test]
    fn an_audit_tells_where_motions_coexist() {
        let request = MapRequest {
            rig: NamedRig::new("beam-150", BEAM_150),
            grid: Grid {
                gaps_mm: vec![1.7374],
                frequencies_hz: vec![3.6589 * BEAM_150.natural_frequency_hz()],
            },
            runner: Runner::Lanes,
            plan: CellPlan::CHAPTER,
            settle: None,
            from: Direction::Rest,
        };
        let lanes = Map {
            rig: request.rig.clone(),
            grid: request.grid.clone(),
            from: request.from,
            cells: vec![cell(periodic(6, 14), 1.0, false)],
        };
        let found = audit(&request, &lanes, (1, 1), &()).unwrap();
        assert_eq!((found.same_label, found.coexisting), (0, Some(1)));
        // A label that is merely wrong is not excused.
        let wrong = MapRequest {
            grid: Grid {
                gaps_mm: vec![0.0],
                frequencies_hz: vec![2.0 * BEAM_150.natural_frequency_hz()],
            },
            ..request
        };
        let map = Map {
            grid: wrong.grid.clone(),
            ..lanes
        };
        let found = audit(&wrong, &map, (1, 1), &()).unwrap();
        assert_eq!((found.same_label, found.coexisting), (0, Some(0)));
    }

    /// Two rigs that show the same over Ω/ω and gap/A0, though neither Hz nor mm are the same.
    #[test]
    fn alike_over_dimensionless_axes() {
        let map = |params: RigParams, odd: Regime| {
            let regimes = [periodic(1, 1), Regime::None, periodic(1, 2), odd];
            Map {
                rig: NamedRig::new("r", params),
                grid: Grid {
                    gaps_mm: [0.5, 1.0].map(|r| r * params.amplitude_m * 1e3).to_vec(),
                    frequencies_hz: [1.5, 2.5]
                        .map(|r| r * params.natural_frequency_hz())
                        .to_vec(),
                },
                from: Direction::Rest,
                cells: regimes.map(|r| cell(r, 1.0, false)).to_vec(),
            }
        };
        let doubled = RigParams {
            amplitude_m: 2.0 * BEAM_170.amplitude_m,
            ..BEAM_170
        };
        let aperiodic = Regime::Aperiodic { impacts: 3 };
        let found = similarity(&map(doubled, aperiodic), &map(BEAM_150, periodic(3, 5)));
        let numbers = (found.cells, found.same, found.striking, found.same_striking);
        assert_eq!(numbers, (4, 3, 3, 2));
        assert_eq!((found.orderly, found.same_orderly), (2, 2));
        // What failed shows nothing: it is neither like "no contact" nor what was measured there.
        let mut failed = map(BEAM_150, periodic(3, 5));
        let measured = MeasuredRegime {
            gap_mm: failed.grid.gaps_mm[0],
            frequency_hz: failed.grid.frequencies_hz[1],
            regime: Regime::None,
        };
        assert_eq!(hits(&[measured], &failed).same, 1);
        failed.cells[1] = MapCell::FAILED;
        assert_eq!(hits(&[measured], &failed).same, 0);
        assert_eq!(similarity(&map(doubled, aperiodic), &failed).same, 2);
    }
}
