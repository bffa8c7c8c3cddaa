//! One run, and the force curve over frequency.

use numerics::engine::{Engine, Method, Observation, Plan, Precision, Recorder, machine, observe};
use numerics::row::{Row, tidy};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;

use crate::arguments::{self, StartArgument};
use crate::rig::Rig;
use crate::values::{columns, record};
use crate::work::How;

/// The answer, with the fields of the command line's JSON.
#[derive(Serialize)]
struct Answer {
    #[serde(flatten)]
    row: Row,
    contacts_recorded: usize,
    rebound_speed_m_per_s: Option<f64>,
    energy_per_blow_j: Option<f64>,
    impulse_n_s: Option<f64>,
    cycles: u32,
    transient: u32,
    engine: &'static str,
    stepper: Option<&'static str>,
    precision: &'static str,
    tick_us: Option<f64>,
}

#[derive(Serialize)]
struct ContactRow {
    onset_s: f64,
    duration_ms: f64,
    approach_speed_m_per_s: f64,
    rebound_speed_m_per_s: f64,
    peak_force_n: f64,
    impulse_n_s: f64,
    energy_lost_j: f64,
}

#[derive(Serialize)]
struct SectionRow {
    relative_displacement_mm: f64,
    relative_velocity_m_per_s: f64,
}

#[pyfunction]
#[pyo3(signature = (rig, *, ratio, frequency_hz, gap_mm, cart, start, cycles, transient, samples_per_period, engine, precision, tick_us))]
#[allow(
    clippy::too_many_arguments,
    reason = "each is a keyword of the Python function"
)]
pub fn simulate<'py>(
    py: Python<'py>,
    rig: &Rig,
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
        let mut recorder = Recorder {
            samples_per_period,
            ..Recorder::default()
        };
        let seen = observe(hammer.as_mut(), plan, &mut recorder)?;
        let rig = hammer.rig();
        let row = |[q, v]: &[f64; 2]| SectionRow {
            relative_displacement_mm: rig.relative_displacement(*q) * 1e3,
            relative_velocity_m_per_s: rig.kinematics(*q, *v).rate,
        };
        let section: Vec<_> = seen.section.iter().map(row).collect();
        Ok((seen, recorder, section))
    })?;
    let contacts: Vec<_> = recorder.contacts.iter().map(contact_row).collect();
    let found = record(py, &answer(&rig, engine, plan, &seen, &recorder))?;
    found.set_item("history", columns(py, &recorder.samples)?)?;
    found.set_item("section", columns(py, &section)?)?;
    found.set_item("contacts", columns(py, &contacts)?)?;
    Ok(found)
}

fn contact_row(c: &numerics::reference::Contact) -> ContactRow {
    ContactRow {
        onset_s: c.onset_s,
        duration_ms: c.duration_s * 1e3,
        approach_speed_m_per_s: c.approach_speed_m_per_s,
        rebound_speed_m_per_s: c.rebound_speed_m_per_s,
        peak_force_n: c.peak_force_n,
        impulse_n_s: c.impulse_n_s,
        energy_lost_j: c.energy_lost_j,
    }
}

fn answer(
    rig: &numerics::NamedRig,
    engine: Engine,
    plan: Plan,
    seen: &Observation,
    recorder: &Recorder,
) -> Answer {
    let setting = match engine {
        Engine::Event => None,
        Engine::Switch(setting) => Some(setting),
    };
    Answer {
        row: Row::new(&rig.name, &rig.params, seen),
        contacts_recorded: recorder.contacts.len(),
        rebound_speed_m_per_s: seen.strongest.map(|c| c.rebound_speed_m_per_s),
        energy_per_blow_j: seen.strongest.map(|c| c.energy_lost_j),
        impulse_n_s: seen.strongest.map(|c| c.impulse_n_s),
        cycles: plan.cycles,
        transient: plan.transient,
        engine: setting.map_or("event", |_| "switch"),
        stepper: setting.map(|setting| match setting.method {
            Method::Corrected => "corrected",
            Method::Banded { .. } => "banded",
            Method::Smoothed { .. } => "smoothed",
        }),
        precision: match setting.map(|setting| setting.precision) {
            Some(Precision::F32) => "f32",
            Some(Precision::F64) | None => "f64",
        },
        tick_us: setting.map(|setting| tidy(setting.tick_s * 1e6)),
    }
}

#[pyfunction]
#[pyo3(signature = (rig, *, ratio, frequency_hz, gap_mm, cart, direction, cycles, transient, engine, precision, tick_us, threads, progress))]
#[allow(
    clippy::too_many_arguments,
    reason = "each is a keyword of the Python function"
)]
pub fn sweep<'py>(
    py: Python<'py>,
    rig: &Rig,
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
