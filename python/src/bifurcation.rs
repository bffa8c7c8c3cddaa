//! Bifurcation diagrams.

use numerics::bifurcation::answer::BifurcationAnswer;
use numerics::bifurcation::{DiagramRequest, diagrams, rows};
use numerics::lanes::CellPlan;
use numerics::map::request::chapter_frequencies_hz;
use numerics::row::tidy;
use numerics::sweep::Direction;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arguments;
use crate::error::wrong;
use crate::rig::PythonRig;
use crate::values::{columns, record};
use crate::work::How;

#[pyfunction]
#[pyo3(signature = (rig, *, ratio, frequency_hz, gap_mm, cart, direction, cycles, recorded, engine, precision, tick_us, threads, progress))]
#[allow(
    clippy::too_many_arguments,
    reason = "each is a keyword of the Python function"
)]
pub fn bifurcation<'py>(
    py: Python<'py>,
    rig: &PythonRig,
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
    let found = record(py, &BifurcationAnswer::new(&request, &made, None))?;
    found.set_item("points", columns(py, &rows(&made))?)?;
    Ok(found)
}
