//! Curves of periodic orbits over frequency or gap.

use numerics::continuation::table::OrbitsAnswer;
use numerics::continuation::{Along, OrbitsRequest, diagram};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use shared::model::contact::Law;

use crate::arguments;
use crate::error::wrong;
use crate::rig::PythonRig;
use crate::values::{columns, record};
use crate::work::How;

#[pyfunction]
#[pyo3(signature = (rig, *, along, ratio, frequency_hz, gap_mm, cart, periods, impacts, starts, checks, threads, progress))]
#[allow(
    clippy::too_many_arguments,
    reason = "each is a keyword of the Python function"
)]
pub fn orbits<'py>(
    py: Python<'py>,
    rig: &PythonRig,
    along: &str,
    ratio: Option<Vec<f64>>,
    frequency_hz: Option<Vec<f64>>,
    gap_mm: Option<Vec<f64>>,
    cart: Option<&str>,
    periods: u8,
    impacts: u16,
    starts: usize,
    checks: Option<usize>,
    threads: Option<usize>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let mut rig = arguments::at(rig, None, cart)?;
    for (argument, count, most) in [
        ("periods", usize::from(periods), 8),
        ("impacts", usize::from(impacts), 16),
        ("starts", starts, 2000),
    ] {
        if !(1..=most).contains(&count) {
            return Err(wrong(format!(
                "{argument} is {count}, must be from 1 to {most}"
            )));
        }
    }
    if checks.is_some_and(|n| n > 20_000) {
        return Err(wrong("checks must be at most 20000"));
    }
    let natural_hz = rig.params.natural_frequency_hz();
    let (given, unit, argument) = match (&ratio, &frequency_hz) {
        (Some(_), Some(_)) => {
            return Err(wrong(
                "ratio and frequency_hz are two ways to say one thing; give one of them",
            ));
        }
        (Some(ratio), None) => (Some(ratio), 1.0, "ratio"),
        (None, Some(hz)) => (Some(hz), natural_hz, "frequency_hz"),
        (None, None) => (None, 1.0, "ratio"),
    };
    let pair = |argument: &str, values: &[f64]| match values {
        [from, to] if from < to && from.is_finite() && to.is_finite() => Ok((*from, *to)),
        _ => Err(wrong(format!(
            "{argument} must be a rising pair (from, to) of finite numbers"
        ))),
    };
    let (along, limits) = match along {
        "frequency" => {
            match gap_mm.as_deref() {
                None => {}
                Some([mm]) => {
                    let there = rig.params.with_gap_mm(*mm);
                    rig.params = there.map_err(|e| crate::error::from_numerics(e.into()))?;
                }
                Some(_) => return Err(wrong("gap_mm must be one number with along=\"frequency\"")),
            }
            let usual = vec![0.8, 4.0];
            let (from, to) = pair(argument, given.unwrap_or(&usual))?;
            if from <= 0.0 {
                return Err(wrong(format!(
                    "{argument} begins at {from}, must be positive"
                )));
            }
            (Along::Frequency, (from / unit, to / unit))
        }
        "gap" => {
            let hz = match given.map(Vec::as_slice) {
                Some([one]) if *one > 0.0 && one.is_finite() => match argument {
                    "ratio" => *one * natural_hz,
                    _ => *one,
                },
                _ => {
                    return Err(wrong(
                        "along=\"gap\" needs one drive frequency: ratio or frequency_hz",
                    ));
                }
            };
            let usual = vec![0.0, 3.56];
            let (from, to) = pair("gap_mm", gap_mm.as_deref().unwrap_or(&usual))?;
            for mm in [from, to] {
                let there = rig.params.with_gap_mm(mm);
                there.map_err(|e| crate::error::from_numerics(e.into()))?;
            }
            let amplitude_mm = rig.params.amplitude_m * 1e3;
            (Along::Gap(hz), (from / amplitude_mm, to / amplitude_mm))
        }
        other => return Err(arguments::choice("along", other, &["frequency", "gap"])),
    };
    let fast = matches!(rig.params.contact, Law::SpringDashpot { .. });
    let request = OrbitsRequest {
        along,
        limits,
        periods,
        impacts,
        starts,
        checks: checks.unwrap_or(starts * if fast { 40 } else { 2 }),
    };
    let how = How { threads, progress };
    let found = how.run(py, request.simulations(), |watch| {
        diagram(&rig.params, &request, watch)
    })?;
    let answer = OrbitsAnswer::new(&rig.name, &found);
    let whole = record(py, &answer)?;
    whole.set_item("orbits", columns(py, &answer.orbits)?)?;
    whole.set_item("special_points", columns(py, &answer.special_points)?)?;
    Ok(whole)
}
