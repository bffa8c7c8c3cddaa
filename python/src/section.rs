//! Poincaré sections and Lyapunov exponents.

use numerics::lyapunov::{LyapunovSpan, exponents};
use numerics::poincare::answer::SectionAnswer;
use numerics::poincare::{SectionRequest, portrait};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use shared::model::rig::Rig as Model;

use crate::arguments::{self, StartArgument};
use crate::error::wrong;
use crate::rig::PythonRig;
use crate::values::{columns, record};
use crate::work::How;

#[pyfunction]
#[pyo3(signature = (rig, *, ratio, frequency_hz, gap_mm, cart, points, transient, phases_turns, start, progress))]
#[allow(
    clippy::too_many_arguments,
    reason = "each is a keyword of the Python function"
)]
pub fn poincare<'py>(
    py: Python<'py>,
    rig: &PythonRig,
    ratio: Option<f64>,
    frequency_hz: Option<f64>,
    gap_mm: Option<f64>,
    cart: Option<&str>,
    points: u32,
    transient: u32,
    mut phases_turns: Vec<f64>,
    start: StartArgument,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    const MOST: u32 = 10_000_000;
    if !(1..=MOST).contains(&points) {
        return Err(wrong(format!(
            "points is {points}, must be from 1 to {MOST}"
        )));
    }
    if let Some(bad) = phases_turns.iter().find(|p| !(0.0..1.0).contains(*p)) {
        return Err(wrong(format!(
            "phases_turns has {bad}, must be from 0 to below 1"
        )));
    }
    phases_turns.sort_by(f64::total_cmp);
    phases_turns.dedup();
    let rig = arguments::at(rig, gap_mm, cart)?;
    let request = SectionRequest {
        params: rig.params,
        frequency_hz: arguments::one_frequency(&rig, ratio, frequency_hz)?,
        start: start.start()?,
        phases: phases_turns,
        transient,
        points,
    };
    let how = How {
        threads: None,
        progress,
    };
    let seen = how.run(py, u64::from(points), |watch| portrait(&request, watch))?;
    let answer = SectionAnswer::new(&rig.name, &request, &seen, None);
    let rows: Vec<_> = seen.sections.iter().flatten().copied().collect();
    let found = record(py, &answer)?;
    found.set_item("section", columns(py, &rows)?)?;
    found.set_item("trajectory", columns(py, &seen.trajectory)?)?;
    Ok(found)
}

#[pyfunction]
#[pyo3(signature = (rig, *, ratio, frequency_hz, gap_mm, cart, periods, transient, start))]
#[allow(
    clippy::too_many_arguments,
    reason = "each is a keyword of the Python function"
)]
pub fn lyapunov<'py>(
    py: Python<'py>,
    rig: &PythonRig,
    ratio: Option<f64>,
    frequency_hz: Option<f64>,
    gap_mm: Option<f64>,
    cart: Option<&str>,
    periods: u32,
    transient: u32,
    start: StartArgument,
) -> PyResult<Bound<'py, PyDict>> {
    let rig = arguments::at(rig, gap_mm, cart)?;
    let hz = arguments::one_frequency(&rig, ratio, frequency_hz)?;
    let start = start.start()?;
    let how = How {
        threads: None,
        progress: None,
    };
    let found = how.run(py, 1, |_| {
        numerics::engine::check_frequency(hz, &rig.params)?;
        let model = Model::<f64>::new(&rig.params)?;
        let section = start.section(&model, std::f64::consts::TAU * hz)?;
        exponents(
            &rig.params,
            hz,
            section,
            LyapunovSpan { transient, periods },
        )
    })?;
    let answer = record(py, &found)?;
    answer.set_item("meaning", found.meaning())?;
    Ok(answer)
}
