//! Ground that gives way: rate of penetration over gap and frequency.

use files::ground::{BitWords, FEEDS, GroundAsked, feed_name};
use numerics::drill::{DrillPlan, DrillSetting, advise, grid};
use numerics::row::tidy;
use numerics::sweep::spread;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arguments;
use crate::error::{from_user, wrong};
use crate::rig::PythonRig;
use crate::values::{columns, object};
use crate::work::How;

/// Ω/ω where none is given, as on the command line.
const USUAL_RATIOS: (f64, f64, usize) = (1.2, 4.0, 141);

#[pyfunction]
#[pyo3(signature = (rig, *, threshold_n, ground_stiffness_n_per_m, ground_damping_n_s_per_m, threshold_percent, ground_stiffness_percent, bit_mass_kg, bit_stiffness_n_per_m, bit_damping_n_s_per_m, bit_feed_force_n, feed, ratio, frequency_hz, gap_mm, cart, settle, threads, progress))]
#[allow(
    clippy::too_many_arguments,
    reason = "each is a keyword of the Python function"
)]
pub fn drill<'py>(
    py: Python<'py>,
    rig: &PythonRig,
    threshold_n: f64,
    ground_stiffness_n_per_m: Option<f64>,
    ground_damping_n_s_per_m: Option<f64>,
    threshold_percent: f64,
    ground_stiffness_percent: f64,
    bit_mass_kg: Option<f64>,
    bit_stiffness_n_per_m: Option<f64>,
    bit_damping_n_s_per_m: Option<f64>,
    bit_feed_force_n: Option<f64>,
    feed: &str,
    ratio: Option<Vec<f64>>,
    frequency_hz: Option<Vec<f64>>,
    gap_mm: Option<f64>,
    cart: Option<&str>,
    settle: u32,
    threads: Option<usize>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let rig = arguments::at(rig, gap_mm, cart)?;
    let asked = GroundAsked {
        threshold_n: Some(threshold_n),
        ground_stiffness_n_per_m,
        ground_damping_n_s_per_m,
        threshold_percent,
        ground_stiffness_percent,
        bit_mass_kg,
        bit_stiffness_n_per_m,
        bit_damping_n_s_per_m,
        bit_feed_force_n,
    };
    let ground = asked.ground(&rig).map_err(from_user)?;
    let setting = DrillSetting {
        ground,
        bit: asked.bit(&rig, &ground).map_err(from_user)?,
        feed: files::ground::feed(feed)
            .ok_or_else(|| wrong(format!("feed is {feed}, must be {FEEDS}")))?,
    };
    let known = asked.uncertainty().map_err(from_user)?;
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
    found.set_item("feed", feed_name(setting.feed))?;
    found.set_item("bit", object(py, &setting.bit.map(BitWords::from))?)?;
    found.set_item("advice", object(py, &advice)?)?;
    found.set_item("rows", columns(py, &rows)?)?;
    Ok(found)
}
