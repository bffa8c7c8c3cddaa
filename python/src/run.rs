//! One run, and the force curve over frequency.

use numerics::engine::answer::{RunAnswer, contact_rows, section_rows};
use numerics::engine::{CycleRecorder, machine, observe};
use pyo3::prelude::*;

use crate::arguments::{Keywords, direction};
use crate::values::{fields, record, table};

#[pyfunction]
pub fn simulate(asked: Keywords<'_>) -> PyResult<Bound<'_, PyAny>> {
    let py = asked.py();
    let rig = asked.rig_at_gap()?;
    let hz = asked.one_frequency(&rig)?;
    let engine = asked.engine()?;
    let plan = asked.plan()?;
    let start = asked.start()?;
    let samples_per_period = asked.take("samples_per_period")?;
    let (seen, recorder, section) = asked.run(1, |_| {
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
    let found = fields(py, &RunAnswer::new(&rig, engine, plan, &seen, &recorder))?;
    found.set_item("history", table(py, &recorder.samples)?)?;
    found.set_item("section", table(py, &section)?)?;
    found.set_item("contacts", table(py, &contact_rows(&recorder))?)?;
    record(found)
}

#[pyfunction]
pub fn sweep(asked: Keywords<'_>) -> PyResult<Bound<'_, PyAny>> {
    let py = asked.py();
    let rig = asked.rig_at_gap()?;
    let frequencies = asked.some_frequencies(&rig)?;
    let engine = asked.engine()?;
    let direction = direction(&asked.take::<String>("direction")?)?;
    let plan = asked.plan()?;
    let rows = asked.run(frequencies.len() as u64, |watch| {
        numerics::sweep::sweep(&rig, engine, &frequencies, direction, plan, watch)
    })?;
    table(py, &rows)
}
