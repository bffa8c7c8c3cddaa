//! Poincaré sections and Lyapunov exponents.

use numerics::lyapunov::{LyapunovSpan, exponents};
use numerics::poincare::answer::SectionAnswer;
use numerics::poincare::{SectionRequest, portrait};
use pyo3::prelude::*;
use shared::model::rig::Rig as Model;

use crate::arguments::Keywords;
use crate::error::from_numerics;
use crate::values::{fields, record, table};

#[pyfunction]
pub fn poincare(asked: Keywords<'_>) -> PyResult<Bound<'_, PyAny>> {
    let py = asked.py();
    let mut phases = asked.numbers("phases_turns")?.unwrap_or_default();
    phases.sort_by(f64::total_cmp);
    phases.dedup();
    let rig = asked.rig_at_gap()?;
    let request = SectionRequest {
        params: rig.params,
        frequency_hz: asked.one_frequency(&rig)?,
        start: asked.start()?,
        phases,
        transient: asked.take("transient")?,
        points: asked.take("points")?,
    };
    request.check().map_err(from_numerics)?;
    let seen = asked.run(u64::from(request.points), |watch| portrait(&request, watch))?;
    let rows: Vec<_> = seen.sections.iter().flatten().copied().collect();
    let found = fields(py, &SectionAnswer::new(&rig.name, &request, &seen, None))?;
    found.set_item("section", table(py, &rows)?)?;
    found.set_item("trajectory", table(py, &seen.trajectory)?)?;
    record(found)
}

#[pyfunction]
pub fn lyapunov(asked: Keywords<'_>) -> PyResult<Bound<'_, PyAny>> {
    let py = asked.py();
    let rig = asked.rig_at_gap()?;
    let hz = asked.one_frequency(&rig)?;
    let start = asked.start()?;
    let span = LyapunovSpan {
        transient: asked.take("transient")?,
        periods: asked.take("periods")?,
    };
    let found = asked.run(1, |_| {
        numerics::engine::check_frequency(hz, &rig.params)?;
        let model = Model::<f64>::new(&rig.params)?;
        let section = start.section(&model, std::f64::consts::TAU * hz)?;
        exponents(&rig.params, hz, section, span)
    })?;
    let answer = fields(py, &found)?;
    answer.set_item("meaning", found.meaning())?;
    record(answer)
}
