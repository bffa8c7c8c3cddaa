//! Beam springs that bend in several modes.

use numerics::modes::{Beam, ModalRig, ModesRequest, TipJoint};
use pyo3::prelude::*;
use serde::Serialize;

use crate::arguments::{Keywords, choice};
use crate::error::{from_numerics, wrong};
use crate::values::{record, table};

/// A bending mode, in the units of the command line's answer.
#[derive(Serialize)]
struct ModeRow {
    frequency_hz: f64,
    mass_kg: f64,
    participation_kg: f64,
}

#[pyfunction]
pub fn modes(asked: Keywords<'_>) -> PyResult<Bound<'_, PyAny>> {
    let py = asked.py();
    let rig = asked.rig_at_gap()?;
    let frequencies_hz = asked.some_frequencies(&rig)?;
    let mut counts: Vec<usize> = asked.take("modes")?;
    counts.sort_unstable();
    counts.dedup();
    let Some(most) = counts.last().copied() else {
        return Err(wrong("modes is empty, must have a value"));
    };
    let beam = Beam {
        tip: match asked.take::<String>("tip")?.as_str() {
            "guided" => TipJoint::Guided,
            "free" => TipJoint::Free,
            other => return Err(choice("tip", other, &["guided", "free"])),
        },
        mass_ratio: asked.take("springs_mass")?,
    };
    let modal = ModalRig::new(&rig.params, beam, most).map_err(from_numerics)?;
    let request = ModesRequest {
        rig: &rig,
        beam,
        counts: &counts,
        frequencies_hz: &frequencies_hz,
        cycles: asked.plan()?,
    };
    let runs = counts.len() * frequencies_hz.len();
    let rows = asked.run(runs as u64, |watch| request.run(watch))?;
    let modes = modal.modes.iter().map(|mode| ModeRow {
        frequency_hz: mode.omega / std::f64::consts::TAU,
        mass_kg: mode.mass_kg,
        participation_kg: mode.participation_kg,
    });
    let found = pyo3::types::PyDict::new(py);
    found.set_item("modes", table(py, &modes.collect::<Vec<_>>())?)?;
    found.set_item("rows", table(py, &rows)?)?;
    record(found)
}
