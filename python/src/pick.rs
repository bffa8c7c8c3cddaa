//! The operating point.

use files::rigfile::WIDTHS;
use files::words::pick::WordedPick;
use numerics::PickLimits;
use numerics::pick::{Springs, pick_on, steps};
use numerics::uncertainty::Stated;
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arguments;
use crate::error::{from_user, wrong};
use crate::rig::PythonRig;
use crate::values::record;
use crate::work::How;

/// Random rigs at most.
const MOST_SAMPLES: u32 = 100_000;

#[pyfunction]
#[pyo3(signature = (rig, *, gap_mm, cart, nominal, widths, samples, seed, max_force_n, max_frequency_hz, max_shaker_force_n, threads, progress))]
#[allow(
    clippy::too_many_arguments,
    reason = "each is a keyword of the Python function"
)]
pub fn pick<'py>(
    py: Python<'py>,
    rig: &PythonRig,
    gap_mm: f64,
    cart: Option<&str>,
    nominal: bool,
    widths: Vec<(String, f64)>,
    samples: u32,
    seed: u64,
    max_force_n: Option<f64>,
    max_frequency_hz: Option<f64>,
    max_shaker_force_n: Option<f64>,
    threads: Option<usize>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    if samples > MOST_SAMPLES {
        return Err(wrong(format!(
            "samples is {samples}, must be at most {MOST_SAMPLES}"
        )));
    }
    let rig = arguments::at(rig, Some(gap_mm), cart)?;
    let mut given = Stated::default();
    for (name, value) in &widths {
        let width = WIDTHS.iter().find(|width| width.key == name);
        let width = width.ok_or_else(|| wrong(format!("{name} is no uncertainty")))?;
        width.set(&mut given, name, *value).map_err(from_user)?;
    }
    let stated = given.or(&rig.stated);
    let whole = stated.complete(samples, seed, rig.params.cart.recoils());
    let uncertainty = (!nominal).then_some(whole);
    let limit = |name: &str, value: Option<f64>| match value {
        Some(x) if !(x > 0.0 && x.is_finite()) => {
            Err(wrong(format!("{name} is {x}, must be a positive number")))
        }
        _ => Ok(value),
    };
    let limits = PickLimits {
        max_force_n: limit("max_force_n", max_force_n)?,
        max_frequency_hz: limit("max_frequency_hz", max_frequency_hz)?,
        max_shaker_force_n: limit("max_shaker_force_n", max_shaker_force_n)?,
        rig_shaker_force_n: None,
    };
    let how = How { threads, progress };
    let found = how.run(py, steps(uncertainty), |watch| {
        pick_on(&rig, Springs::default(), uncertainty, limits, watch)
    })?;
    let answer = record(py, &WordedPick::from(&found.answer))?;
    let (hz, force): (Vec<f64>, Vec<f64>) = found.curve.iter().copied().unzip();
    answer.set_item("curve_frequency_hz", hz.into_pyarray(py))?;
    answer.set_item("curve_force_ratio", force.into_pyarray(py))?;
    Ok(answer)
}
