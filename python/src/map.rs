//! The Peterka map.

use numerics::engine::Engine;
use numerics::lanes::CellPlan;
use numerics::map::request::{chapter_frequencies_hz, chapter_gaps_mm};
use numerics::map::{Grid, Map, MapRequest, MapSummary, Runner, run};
use numerics::row::tidy;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arguments::{Keywords, direction, rising};
use crate::error::from_numerics;
use crate::values::{object, or_nan, put, record};

fn request(asked: &Keywords<'_>) -> PyResult<MapRequest> {
    let rig = asked.rig()?;
    let given = asked.frequencies(&rig)?;
    let gaps_mm = match asked.numbers("gap_mm")? {
        None => chapter_gaps_mm(&rig.params),
        Some(gaps) => {
            rising("gap_mm", &gaps)?;
            gaps.into_iter().map(tidy).collect()
        }
    };
    for mm in [gaps_mm.first(), gaps_mm.last()].into_iter().flatten() {
        let there = rig.params.with_gap_mm(*mm);
        there.map_err(|e| from_numerics(e.into()))?;
    }
    let runner = match asked.take::<String>("engine")?.as_str() {
        "reference" => asked.engine_called("event").map(|_| Runner::Reference)?,
        name => match asked.engine_called(name)? {
            Engine::Event => Runner::Lanes,
            Engine::Switch(setting) => Runner::Switch(setting),
        },
    };
    let cycles: u32 = asked.take("cycles")?;
    let recorded: Option<u32> = asked.take("recorded")?;
    let request = MapRequest {
        grid: Grid {
            frequencies_hz: given.unwrap_or_else(|| chapter_frequencies_hz(&rig.params)),
            gaps_mm,
        },
        rig,
        runner,
        plan: CellPlan {
            cycles,
            recorded: recorded.unwrap_or((cycles / 2).min(100)),
            early: true,
            strobes: 0,
        },
        settle: asked.take("settle")?,
        from: direction(&asked.take::<String>("direction")?)?,
    };
    request.check().map_err(from_numerics)?;
    Ok(request)
}

#[pyfunction]
pub fn map(asked: Keywords<'_>) -> PyResult<Bound<'_, PyAny>> {
    let py = asked.py();
    let request = request(&asked)?;
    let made = asked.run(request.grid.len() as u64, |watch| run(&request, watch))?;
    arrays(py, &request, &made)
}

/// Axes, layers (row by row: every frequency of the first gap, then of the second) and summary.
fn arrays<'py>(py: Python<'py>, request: &MapRequest, map: &Map) -> PyResult<Bound<'py, PyAny>> {
    let found = PyDict::new(py);
    found.set_item("rig", &map.rig.name)?;
    found.set_item("engine", request.runner.name())?;
    found.set_item("direction", request.from.name())?;
    found.set_item("cycles", request.plan.cycles)?;
    found.set_item("recorded", request.plan.recorded)?;
    found.set_item("settle", request.settle)?;
    found.set_item("summary", object(py, &MapSummary::of(map))?)?;
    put(&found, "gap_mm", map.grid.gaps_mm.iter().copied())?;
    put(&found, "gap_ratio", map.gap_ratios())?;
    let hz = map.grid.frequencies_hz.iter().copied();
    put(&found, "frequency_hz", hz)?;
    put(&found, "frequency_ratio", map.frequency_ratios())?;
    let cells = &map.cells;
    // Hundreds of thousands of cells have some tens of regimes: names once, and which cell has which.
    let mut names: Vec<String> = Vec::new();
    let mut which = Vec::with_capacity(cells.len());
    for cell in cells {
        let name = cell.label().to_string();
        let at = names.iter().position(|n| *n == name);
        which.push(at.unwrap_or_else(|| {
            names.push(name);
            names.len() - 1
        }));
    }
    found.set_item("regime_names", names)?;
    put(&found, "regime_index", which)?;

    put(&found, "impacts", cells.iter().map(|c| c.regime.impacts()))?;
    let periods = cells.iter().map(|c| or_nan(c.regime.periods()));
    put(&found, "periods", periods)?;
    let ratios = (0..cells.len()).map(|i| map.force_ratio(i));
    put(&found, "force_ratio", ratios)?;
    put(&found, "force_n", cells.iter().map(|c| c.force_n))?;
    let settled = cells.iter().map(|c| or_nan(c.settled_after));
    put(&found, "settling_cycles", settled)?;
    let searched = cells.iter().map(|c| c.searched);
    put(&found, "largest_period_searched", searched)?;
    put(&found, "uncertain", cells.iter().map(|c| c.uncertain))?;
    put(&found, "failed", cells.iter().map(|c| c.failed))?;
    record(found)
}
