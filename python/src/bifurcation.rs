//! Bifurcation diagrams.

use numerics::bifurcation::answer::BifurcationAnswer;
use numerics::bifurcation::{DiagramRequest, diagrams, rows};
use numerics::lanes::CellPlan;
use numerics::map::request::chapter_frequencies_hz;
use numerics::row::tidy;
use numerics::sweep::Direction;
use pyo3::prelude::*;

use crate::arguments::{Keywords, direction, rising};
use crate::error::from_numerics;
use crate::values::{fields, record, table};

#[pyfunction]
pub fn bifurcation(asked: Keywords<'_>) -> PyResult<Bound<'_, PyAny>> {
    let py = asked.py();
    let rig = asked.rig()?;
    let given = asked.frequencies(&rig)?;
    let recorded = asked.take("recorded")?;
    let gaps_mm = asked.numbers("gap_mm")?;
    if let Some(gaps) = &gaps_mm {
        rising("gap_mm", gaps)?;
    }
    let request = DiagramRequest {
        gaps_mm: gaps_mm.unwrap_or_else(|| vec![tidy(rig.params.gap_m * 1e3)]),
        frequencies_hz: given.unwrap_or_else(|| chapter_frequencies_hz(&rig.params)),
        directions: match asked.take::<String>("direction")?.as_str() {
            "all" => vec![Direction::Rest, Direction::Up, Direction::Down],
            one => vec![direction(one)?],
        },
        engine: asked.engine()?,
        plan: CellPlan {
            cycles: asked.take("cycles")?,
            recorded,
            early: true,
            strobes: recorded,
        },
        locate: true,
        rig,
    };
    request.check().map_err(from_numerics)?;
    let made = asked.run(request.simulations(), |watch| diagrams(&request, watch))?;
    let found = fields(py, &BifurcationAnswer::new(&request, &made, None))?;
    found.set_item("points", table(py, &rows(&made))?)?;
    record(found)
}
