//! One run, and the force curve over frequency.

use numerics::engine::answer::{RunAnswer, contact_rows, section_rows};
use numerics::engine::{CycleRecorder, machine, observe};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arguments::{self, StartArgument};
use crate::rig::PythonRig;
use crate::values::{columns, record};
use crate::work::How;

#[pyfunction]
#[pyo3(signature = (rig, *, ratio, frequency_hz, gap_mm, cart, start, cycles, transient, samples_per_period, engine, precision, tick_us))]
#[allow(
    clippy::too_many_arguments,
    reason = "each is a keyword of the Python function"
)]
pub fn simulate<'py>(
    py: Python<'py>,
    rig: &PythonRig,
    ratio: Option<f64>,
    frequency_hz: Option<f64>,
    gap_mm: Option<f64>,
    cart: Option<&str>,
    start: StartArgument,
    cycles: u32,
    transient: u32,
    samples_per_period: usize,
    engine: &str,
    precision: Option<&str>,
    tick_us: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let rig = arguments::at(rig, gap_mm, cart)?;
    let hz = arguments::one_frequency(&rig, ratio, frequency_hz)?;
    let engine = arguments::engine(engine, precision, tick_us)?;
    let plan = arguments::plan(cycles, transient)?;
    let start = start.start()?;
    let how = How {
        threads: None,
        progress: None,
    };
    let (seen, recorder, section) = how.run(py, 1, |_| {
        let mut hammer = machine(engine, &rig.params, hz, start)?;
        let mut recorder = CycleRecorder {
            samples_per_period,
            evenly: true,
            ..CycleRecorder::default()
        };
        let seen = observe(hammer.as_mut(), plan, &mut recorder)?;
        let section = section_rows(&seen, hammer.rig());
        Ok((seen, recorder, section))
    })?;
    let found = record(py, &RunAnswer::new(&rig, engine, plan, &seen, &recorder))?;
    found.set_item("history", columns(py, &recorder.samples)?)?;
    found.set_item("section", columns(py, &section)?)?;
    found.set_item("contacts", columns(py, &contact_rows(&recorder))?)?;
    Ok(found)
}

#[pyfunction]
#[pyo3(signature = (rig, *, ratio, frequency_hz, gap_mm, cart, direction, cycles, transient, engine, precision, tick_us, threads, progress))]
#[allow(
    clippy::too_many_arguments,
    reason = "each is a keyword of the Python function"
)]
pub fn sweep<'py>(
    py: Python<'py>,
    rig: &PythonRig,
    ratio: Option<Vec<f64>>,
    frequency_hz: Option<Vec<f64>>,
    gap_mm: Option<f64>,
    cart: Option<&str>,
    direction: &str,
    cycles: u32,
    transient: u32,
    engine: &str,
    precision: Option<&str>,
    tick_us: Option<f64>,
    threads: Option<usize>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let rig = arguments::at(rig, gap_mm, cart)?;
    let frequencies = arguments::some_frequencies(&rig, ratio, frequency_hz)?;
    let engine = arguments::engine(engine, precision, tick_us)?;
    let direction = arguments::direction(direction)?;
    let plan = arguments::plan(cycles, transient)?;
    let how = How { threads, progress };
    let rows = how.run(py, frequencies.len() as u64, |watch| {
        numerics::sweep::sweep(&rig, engine, &frequencies, direction, plan, watch)
    })?;
    columns(py, &rows)
}
