//! Ground that gives way: rate of penetration over gap and frequency.

use numerics::drill::{DrillPlan, DrillSetting, Feed, GroundUncertainty, advise, grid};
use numerics::sweep::spread;
use numerics::{Error, row::tidy};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use shared::model::contact::Law;
use shared::model::slider::Slider;

use crate::arguments;
use crate::error::{from_numerics, wrong};
use crate::rig::Rig;
use crate::values::{columns, object};
use crate::work::How;

/// Ω/ω where none is given, as on the command line.
const USUAL_RATIOS: (f64, f64, usize) = (1.2, 4.0, 141);

#[pyfunction]
#[pyo3(signature = (rig, *, threshold_n, ground_stiffness_n_per_m, ground_damping_n_s_per_m, threshold_percent, ground_stiffness_percent, ratio, frequency_hz, gap_mm, cart, settle, threads, progress))]
#[allow(
    clippy::too_many_arguments,
    reason = "each is a keyword of the Python function"
)]
pub fn drill<'py>(
    py: Python<'py>,
    rig: &Rig,
    threshold_n: f64,
    ground_stiffness_n_per_m: Option<f64>,
    ground_damping_n_s_per_m: Option<f64>,
    threshold_percent: f64,
    ground_stiffness_percent: f64,
    ratio: Option<Vec<f64>>,
    frequency_hz: Option<Vec<f64>>,
    gap_mm: Option<f64>,
    cart: Option<&str>,
    settle: u32,
    threads: Option<usize>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let rig = arguments::as_the_machine(rig, gap_mm, cart)?;
    let own = match rig.params.contact {
        Law::SpringDashpot { stiffness, damping } => Some((stiffness, damping)),
        _ => None,
    };
    let missing = |argument: &str| {
        wrong(format!(
            "the contact of rig {} is no spring-dashpot, so the ground needs {argument}",
            rig.name
        ))
    };
    let stiffness = ground_stiffness_n_per_m.or(own.map(|o| o.0));
    let damping = ground_damping_n_s_per_m.or(own.map(|o| o.1));
    let ground = Slider {
        stiffness: stiffness.ok_or_else(|| missing("ground_stiffness_n_per_m"))?,
        damping: damping.ok_or_else(|| missing("ground_damping_n_s_per_m"))?,
        threshold: threshold_n,
    };
    ground.check().map_err(|e| from_numerics(Error::from(e)))?;
    for (argument, percent) in [
        ("threshold_percent", threshold_percent),
        ("ground_stiffness_percent", ground_stiffness_percent),
    ] {
        if !(0.0..100.0).contains(&percent) {
            return Err(wrong(format!(
                "{argument} is {percent}, must be from 0 to below 100"
            )));
        }
    }
    let setting = DrillSetting {
        ground,
        bit: None,
        feed: Feed::Cart,
    };
    let known = GroundUncertainty {
        threshold_percent,
        ground_stiffness_percent,
    };
    let natural_hz = rig.params.natural_frequency_hz();
    let (from, to, count) = USUAL_RATIOS;
    let given = arguments::frequencies(&rig, ratio, frequency_hz)?;
    let frequencies = given.unwrap_or_else(|| spread(from * natural_hz, to * natural_hz, count));
    let plan = DrillPlan {
        settle,
        ..DrillPlan::default()
    };
    let gaps = [tidy(rig.params.gap_m * 1e3)];
    let how = How { threads, progress };
    let (rows, advice) = how.run(py, frequencies.len() as u64, |watch| {
        let rows = grid(&rig, &setting, &gaps, &frequencies, plan, watch)?;
        let advice = advise(&rig, &setting, &rows, Some(known), plan, watch)?;
        Ok((rows, advice))
    })?;
    let found = PyDict::new(py);
    found.set_item("rig", &rig.name)?;
    found.set_item("threshold_n", ground.threshold)?;
    found.set_item("ground_stiffness_n_per_m", ground.stiffness)?;
    found.set_item("ground_damping_n_s_per_m", ground.damping)?;
    found.set_item("advice", object(py, &advice)?)?;
    found.set_item("rows", columns(py, &rows)?)?;
    Ok(found)
}
