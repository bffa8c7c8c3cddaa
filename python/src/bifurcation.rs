//! Bifurcation diagrams.

use numerics::bifurcation::{DiagramRequest, changes, diagrams, rows};
use numerics::lanes::CellPlan;
use numerics::map::request::chapter_frequencies_hz;
use numerics::pick::CartModel;
use numerics::row::tidy;
use numerics::sweep::Direction;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::arguments;
use crate::error::wrong;
use crate::rig::Rig;
use crate::values::{columns, object};
use crate::work::How;

#[pyfunction]
#[pyo3(signature = (rig, *, ratio, frequency_hz, gap_mm, cart, direction, cycles, recorded, engine, precision, tick_us, threads, progress))]
#[allow(
    clippy::too_many_arguments,
    reason = "each is a keyword of the Python function"
)]
pub fn bifurcation<'py>(
    py: Python<'py>,
    rig: &Rig,
    ratio: Option<Vec<f64>>,
    frequency_hz: Option<Vec<f64>>,
    gap_mm: Option<Vec<f64>>,
    cart: Option<&str>,
    direction: &str,
    cycles: u32,
    recorded: u32,
    engine: &str,
    precision: Option<&str>,
    tick_us: Option<f64>,
    threads: Option<usize>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let rig = arguments::at(rig, None, cart)?;
    let given = arguments::frequencies(&rig, ratio, frequency_hz)?;
    if recorded == 0 || recorded > cycles {
        return Err(wrong(format!(
            "recorded is {recorded}, must be from 1 to cycles ({cycles})"
        )));
    }
    if let Some(gaps) = &gap_mm {
        arguments::rising("gap_mm", gaps)?;
    }
    let request = DiagramRequest {
        gaps_mm: gap_mm.unwrap_or_else(|| vec![tidy(rig.params.gap_m * 1e3)]),
        frequencies_hz: given.unwrap_or_else(|| chapter_frequencies_hz(&rig.params)),
        directions: match direction {
            "all" => vec![Direction::Rest, Direction::Up, Direction::Down],
            one => vec![arguments::direction(one)?],
        },
        engine: arguments::engine(engine, precision, tick_us)?,
        plan: CellPlan {
            cycles,
            recorded,
            early: true,
            strobes: recorded,
        },
        locate: true,
        rig,
    };
    let how = How { threads, progress };
    let made = how.run(py, request.simulations(), |watch| diagrams(&request, watch))?;
    let found = PyDict::new(py);
    found.set_item("rig", &request.rig.name)?;
    found.set_item("cycles", cycles)?;
    found.set_item("recorded", recorded)?;
    found.set_item("simulations", request.simulations())?;
    let list = PyList::empty(py);
    for diagram in &made {
        let one = PyDict::new(py);
        one.set_item("gap_mm", diagram.gap_mm)?;
        one.set_item("direction", diagram.direction.name())?;
        one.set_item("frequencies", diagram.stations.len())?;
        let open = |s: &&numerics::bifurcation::Station| !s.settled && !s.row.failed;
        one.set_item("not_settled", diagram.stations.iter().filter(open).count())?;
        one.set_item("changes", object(py, &diagram.changes)?)?;
        let failed = diagram.stations.iter().filter(|s| s.row.failed).count();
        one.set_item("failed", failed)?;
        list.append(one)?;
    }
    found.set_item("diagrams", list)?;
    let mut twofold = Vec::new();
    for same in made.chunk_by(|a, b| a.gap_mm == b.gap_mm) {
        let of = |direction| same.iter().find(|d| d.direction == direction);
        if let (Some(up), Some(down)) = (of(Direction::Up), of(Direction::Down)) {
            twofold.extend(changes::twofold(up, down));
        }
    }
    found.set_item("twofold", object(py, &twofold)?)?;
    found.set_item("cart", object(py, &CartModel::of(&request.rig.params))?)?;
    found.set_item("points", columns(py, &rows(&made))?)?;
    Ok(found)
}
