//! Basins of attraction.

use numerics::basins::{Basins, BasinsRequest, StartWindow, cells, explore};
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arguments;
use crate::error::{from_numerics, wrong};
use crate::rig::PythonRig;
use crate::values::record;
use crate::work::How;

#[pyfunction]
#[pyo3(signature = (rig, *, ratio, frequency_hz, gap_mm, cart, grid, displacement_mm, velocity_m_per_s, phase, cycles, recorded, samples, seed, until, engine, precision, tick_us, threads, progress))]
#[allow(
    clippy::too_many_arguments,
    reason = "each is a keyword of the Python function"
)]
pub fn basins<'py>(
    py: Python<'py>,
    rig: &PythonRig,
    ratio: Option<f64>,
    frequency_hz: Option<f64>,
    gap_mm: Option<f64>,
    cart: Option<&str>,
    grid: (usize, usize),
    displacement_mm: Option<[f64; 2]>,
    velocity_m_per_s: Option<[f64; 2]>,
    phase: f64,
    cycles: u32,
    recorded: u32,
    samples: u32,
    seed: u64,
    until: Option<u32>,
    engine: &str,
    precision: Option<&str>,
    tick_us: Option<f64>,
    threads: Option<usize>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    const MOST_SAMPLES: u32 = 1_000_000;
    if samples > MOST_SAMPLES {
        return Err(wrong(format!(
            "samples is {samples}, must be at most {MOST_SAMPLES}"
        )));
    }
    let rig = arguments::at(rig, gap_mm, cart)?;
    let hz = arguments::one_frequency(&rig, ratio, frequency_hz)?;
    let engine = arguments::engine(engine, precision, tick_us)?;
    let (columns, rows) = grid;
    let mut window = StartWindow::usual(&rig.params, columns, rows);
    if let Some(ends) = displacement_mm {
        window.displacement_m = ends.map(|mm| mm * 1e-3);
    }
    if let Some(ends) = velocity_m_per_s {
        window.velocity_m_per_s = ends;
    }
    let query = BasinsRequest {
        window,
        phase,
        cycles,
        recorded,
        samples,
        seed,
        until: until.unwrap_or(cycles.max(1000)),
        ..BasinsRequest::usual(rig, hz, columns, rows)
    };
    query.check().map_err(from_numerics)?;
    let how = How { threads, progress };
    let found = how.run(py, query.runs(), |watch| explore(engine, &query, watch))?;
    arrays(py, &found)
}

/// The grid's layers, rows by rising velocity, within a row by rising displacement; and the summary.
fn arrays<'py>(py: Python<'py>, basins: &Basins) -> PyResult<Bound<'py, PyDict>> {
    let rows = cells::rows(basins);
    let found = record(py, &basins.summary())?;
    let window = &basins.query.window;
    let x = rows.iter().take(window.columns).map(|r| r.displacement_mm);
    let x: Vec<f64> = x.collect();
    let v = rows
        .iter()
        .step_by(window.columns)
        .map(|r| r.velocity_m_per_s);
    found.set_item("start_displacement_mm", x.into_pyarray(py))?;
    found.set_item(
        "start_velocity_m_per_s",
        v.collect::<Vec<_>>().into_pyarray(py),
    )?;
    found.set_item("which", basins.which.clone().into_pyarray(py))?;
    let names: Vec<String> = basins
        .attractors
        .iter()
        .map(|a| a.name.to_string())
        .collect();
    found.set_item("attractor_names", names)?;
    let impact: Vec<bool> = rows.iter().map(|r| r.impact).collect();
    found.set_item("impact", impact.into_pyarray(py))?;
    let regime: Vec<String> = rows.iter().map(|r| r.regime.to_string()).collect();
    found.set_item("regime", regime)?;
    let known = |n: Option<u32>| n.map_or(f64::NAN, f64::from);
    let force: Vec<f64> = rows
        .iter()
        .map(|r| r.force_ratio.unwrap_or(f64::NAN))
        .collect();
    found.set_item("force_ratio", force.into_pyarray(py))?;
    let settled: Vec<f64> = rows.iter().map(|r| known(r.settled_after_cycles)).collect();
    found.set_item("settled_after_cycles", settled.into_pyarray(py))?;
    let last: Vec<f64> = rows.iter().map(|r| known(r.last_contact_cycle)).collect();
    found.set_item("last_contact_cycle", last.into_pyarray(py))?;
    Ok(found)
}
