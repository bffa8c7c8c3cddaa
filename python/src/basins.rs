//! Basins of attraction.

use numerics::basins::{Basins, BasinsRequest, StartWindow, cells, explore};
use pyo3::prelude::*;

use crate::arguments::Keywords;
use crate::error::{from_numerics, wrong};
use crate::values::{fields, or_nan, put, record};

#[pyfunction]
pub fn basins(asked: Keywords<'_>) -> PyResult<Bound<'_, PyAny>> {
    let py = asked.py();
    let rig = asked.rig_at_gap()?;
    let hz = asked.one_frequency(&rig)?;
    let engine = asked.engine()?;
    let grid: Bound<'_, PyAny> = asked.take("grid")?;
    let (columns, rows) = match grid.extract() {
        Ok(both) => (both, both),
        Err(_) => grid.extract().map_err(|_| {
            wrong(format!(
                "grid is {grid}, must be a number of starts, or one for each side"
            ))
        })?,
    };
    let mut window = StartWindow::usual(&rig.params, columns, rows);
    if let Some(ends) = asked.take::<Option<[f64; 2]>>("displacement_mm")? {
        window.displacement_m = ends.map(|mm| mm * 1e-3);
    }
    if let Some(ends) = asked.take("velocity_m_per_s")? {
        window.velocity_m_per_s = ends;
    }
    let cycles: u32 = asked.take("cycles")?;
    let until: Option<u32> = asked.take("until")?;
    let query = BasinsRequest {
        rig,
        frequency_hz: hz,
        window,
        phase: asked.take("phase")?,
        cycles,
        recorded: asked.take("recorded")?,
        samples: asked.take("samples")?,
        seed: asked.take("seed")?,
        until: until.unwrap_or(cycles.max(1000)),
    };
    query.check().map_err(from_numerics)?;
    let found = asked.run(query.runs(), |watch| explore(engine, &query, watch))?;
    arrays(py, &found)
}

/// The grid's layers, rows by rising velocity, within a row by rising displacement; and the summary.
fn arrays<'py>(py: Python<'py>, basins: &Basins) -> PyResult<Bound<'py, PyAny>> {
    let rows = cells::rows(basins);
    let found = fields(py, &basins.summary())?;
    let window = &basins.query.window;
    let x = rows.iter().take(window.columns).map(|r| r.displacement_mm);
    put(&found, "start_displacement_mm", x)?;
    let v = rows.iter().step_by(window.columns);
    put(
        &found,
        "start_velocity_m_per_s",
        v.map(|r| r.velocity_m_per_s),
    )?;
    put(&found, "which", basins.which.iter().copied())?;
    let names = basins.attractors.iter().map(|a| a.name.to_string());
    found.set_item("attractor_names", names.collect::<Vec<_>>())?;
    put(&found, "impact", rows.iter().map(|r| r.impact))?;
    let regime = rows.iter().map(|r| r.regime.to_string());
    found.set_item("regime", regime.collect::<Vec<_>>())?;
    let force = rows.iter().map(|r| or_nan(r.force_ratio));
    put(&found, "force_ratio", force)?;
    let settled = rows.iter().map(|r| or_nan(r.settled_after_cycles));
    put(&found, "settled_after_cycles", settled)?;
    let last = rows.iter().map(|r| or_nan(r.last_contact_cycle));
    put(&found, "last_contact_cycle", last)?;
    record(found)
}
