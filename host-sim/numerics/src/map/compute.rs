//! The cells of one tile.

use shared::model::rig::Rig;

use super::MapCell;
use super::request::{MapRequest, Runner};
use crate::engine::{Engine, Start};
use crate::error::Error;
use crate::lanes::{self, Cell, CellOutcome, CellPlan};
use crate::sweep::Direction;

/// Runs the cells of tile `index`, in their order.
///
/// # Errors
/// If a cell cannot be run.
pub(super) fn tile(request: &MapRequest, index: usize) -> Result<Vec<MapCell>, Error> {
    match request.from {
        Direction::Rest => from_rest(request, index),
        Direction::Up | Direction::Down => carried(request, index),
    }
}

/// The cell at `index` of the grid, started from rest.
///
/// # Errors
/// If the rig cannot have this gap.
pub(super) fn cell_from_rest(request: &MapRequest, index: usize) -> Result<Cell, Error> {
    let (gap_mm, frequency_hz) = request.grid.at(index);
    let params = request.params_at(gap_mm);
    let rig = Rig::<f64>::new(&params)?;
    Ok(Cell {
        params,
        frequency_hz,
        start: Start::Rest.section(&rig, std::f64::consts::TAU * frequency_hz)?,
        phase: 0.0,
    })
}

fn from_rest(request: &MapRequest, index: usize) -> Result<Vec<MapCell>, Error> {
    let cells = request.tile(index).map(|i| cell_from_rest(request, i));
    let outcomes = settled(request, &cells.collect::<Result<Vec<_>, _>>()?)?;
    Ok(outcomes.iter().map(map_cell).collect())
}

/// The gaps of the tile go side by side through the frequencies, each from where it was left at the last one.
fn carried(request: &MapRequest, index: usize) -> Result<Vec<MapCell>, Error> {
    let range = request.tile(index);
    let columns = request.grid.frequencies_hz.len();
    let firsts: Vec<usize> = range.clone().step_by(columns).collect();
    let mut order: Vec<usize> = (0..columns).collect();
    if request.from == Direction::Down {
        order.reverse();
    }
    let mut found: Vec<Option<MapCell>> = vec![None; range.len()];
    let mut last: Option<Vec<Option<CellOutcome>>> = None;
    for column in order {
        let cells = firsts
            .iter()
            .map(|first| cell_from_rest(request, first + column));
        let mut cells = cells.collect::<Result<Vec<_>, _>>()?;
        // Behind a cell that failed the next starts from rest.
        for (cell, left) in cells.iter_mut().zip(last.iter().flatten()) {
            if let Some(left) = left {
                cell.start = left.section;
            }
        }
        let outcomes = settled(request, &cells)?;
        for (row, outcome) in outcomes.iter().enumerate() {
            found[row * columns + column] = Some(map_cell(outcome));
        }
        last = Some(outcomes);
    }
    Ok(found.into_iter().flatten().collect())
}

fn map_cell(outcome: &Option<CellOutcome>) -> MapCell {
    outcome.as_ref().map_or(MapCell::FAILED, MapCell::from)
}

/// Runs `cells`; those that have not settled run again, to the cycles of `settle`.
pub(super) fn settled(
    request: &MapRequest,
    cells: &[Cell],
) -> Result<Vec<Option<CellOutcome>>, Error> {
    let mut outcomes = run(request.runner, cells, &request.plan)?;
    if let Some(cycles) = request.settle {
        let restless: Vec<usize> = (0..cells.len())
            .filter(|i| (outcomes[*i].as_ref()).is_some_and(|o| o.settled_after.is_none()))
            .collect();
        let again: Vec<Cell> = restless.iter().map(|i| cells[*i]).collect();
        let longer = CellPlan {
            cycles,
            ..request.plan
        };
        let more = run(request.runner, &again, &longer)?;
        for (i, outcome) in restless.into_iter().zip(more) {
            outcomes[i] = outcome;
        }
    }
    Ok(outcomes)
}

/// None where the hammer could not be followed.
fn run(runner: Runner, cells: &[Cell], plan: &CellPlan) -> Result<Vec<Option<CellOutcome>>, Error> {
    let outcomes = match runner {
        Runner::Lanes => lanes::run_each(cells, plan),
        Runner::Reference => lanes::each_by_engine(Engine::Event, cells, plan),
        Runner::Switch(setting) => lanes::each_by_engine(Engine::Switch(setting), cells, plan),
    };
    outcomes.into_iter().map(lanes::or_failed).collect()
}
