//! Ground that gives way: rate of penetration over gap and frequency.

use files::ground::{BitWords, FEEDS, GroundAsked, feed_name};
use numerics::drill::{DrillPlan, DrillRuns, DrillSetting, grid};
use numerics::row::tidy;
use numerics::sweep::spread;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arguments::Keywords;
use crate::error::{from_user, wrong};
use crate::values::{object, record, table};

/// Ω/ω where none is given, as on the command line.
const USUAL_RATIOS: (f64, f64, usize) = (1.2, 4.0, 141);

#[pyfunction]
pub fn drill(asked: Keywords<'_>) -> PyResult<Bound<'_, PyAny>> {
    let py = asked.py();
    let rig = asked.rig_at_gap()?;
    let on = GroundAsked {
        threshold_n: Some(asked.take("threshold_n")?),
        ground_stiffness_n_per_m: asked.take("ground_stiffness_n_per_m")?,
        ground_damping_n_s_per_m: asked.take("ground_damping_n_s_per_m")?,
        threshold_percent: asked.take("threshold_percent")?,
        ground_stiffness_percent: asked.take("ground_stiffness_percent")?,
        bit_mass_kg: asked.take("bit_mass_kg")?,
        bit_stiffness_n_per_m: asked.take("bit_stiffness_n_per_m")?,
        bit_damping_n_s_per_m: asked.take("bit_damping_n_s_per_m")?,
        bit_feed_force_n: asked.take("bit_feed_force_n")?,
    };
    let feed = asked.take::<Bound<'_, PyAny>>("feed")?.to_string();
    let ground = on.ground(&rig).map_err(from_user)?;
    let setting = DrillSetting {
        ground,
        bit: on.bit(&rig, &ground).map_err(from_user)?,
        feed: files::ground::feed(&feed)
            .ok_or_else(|| wrong(format!("feed is {feed}, must be {FEEDS}")))?,
    };
    let known = on.uncertainty().map_err(from_user)?;
    let natural_hz = rig.params.natural_frequency_hz();
    let (from, to, count) = USUAL_RATIOS;
    let given = asked.frequencies(&rig)?;
    let frequencies = given.unwrap_or_else(|| spread(from * natural_hz, to * natural_hz, count));
    let plan = DrillPlan {
        settle: asked.take("settle")?,
        ..DrillPlan::default()
    };
    let gaps = [tidy(rig.params.gap_m * 1e3)];
    let (rows, advice) = asked.run(frequencies.len() as u64, |watch| {
        let rows = grid(&rig, &setting, &gaps, &frequencies, plan, watch)?;
        let rig = &rig;
        let advice = DrillRuns { rig, setting, plan }.advise(&rows, Some(known), watch)?;
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
    found.set_item("rows", table(py, &rows)?)?;
    record(found)
}
