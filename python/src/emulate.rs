//! The controller in a closed loop with the emulated rig, once or on many rigs.

use emulator::local::Local;
use emulator::record::{BlockRow, RunEvent, RunObserver, TickRow, TrueContact};
use emulator::run::Run;
use emulator::scenario::{self, BUILTIN};
use emulator::trials::TrialsRequest;
use emulator::verdict::judge;
use numerics::NamedRig;
use numerics::progress::step;
use pyo3::prelude::*;
use serde::Serialize;
use shared::settings::TICK_RATE_HZ;

use crate::arguments::Keywords;
use crate::error::{from_user, wrong};
use crate::rig::PythonRig;
use crate::values::{fields, record, table};

/// One control tick, as it truly was.
#[derive(Serialize)]
struct Sample {
    time_s: f64,
    hammer_mm: f64,
    cart_mm: f64,
    true_force_n: f64,
    powered: bool,
    state: &'static str,
    frequency_hz: f32,
}

/// An event of the run: when it happened, and what, in words.
#[derive(Serialize)]
struct Line {
    time_s: f64,
    what: String,
}

/// What is kept of a run.
struct Watch {
    every: u64,
    samples: Vec<Sample>,
    contacts: Vec<TrueContact>,
    events: Vec<Line>,
    state: &'static str,
    frequency_hz: f32,
}

impl RunObserver for Watch {
    fn tick(&mut self, row: &TickRow) {
        if self.every == 0 || !row.tick.is_multiple_of(self.every) {
            return;
        }
        self.samples.push(Sample {
            time_s: row.time_s,
            hammer_mm: row.hammer_m * 1e3,
            cart_mm: row.cart_m * 1e3,
            true_force_n: row.true_force_n,
            powered: row.powered,
            state: self.state,
            frequency_hz: self.frequency_hz,
        });
    }

    fn block(&mut self, row: &BlockRow) {
        self.state = emulator::names::state_name(row.status.state);
        self.frequency_hz = row.status.frequency_hz;
    }

    fn contact(&mut self, contact: &TrueContact) {
        self.contacts.push(*contact);
    }

    fn event(&mut self, event: &RunEvent) {
        self.events.push(Line {
            time_s: event.time_s,
            what: event.what.to_string(),
        });
    }
}

#[pyfunction]
pub fn emulate(asked: Keywords<'_>) -> PyResult<Bound<'_, PyAny>> {
    let py = asked.py();
    let samples_per_second = asked.take("samples_per_second")?;
    if samples_per_second > TICK_RATE_HZ {
        return Err(wrong(format!(
            "samples_per_second is {samples_per_second}, must be at most {TICK_RATE_HZ}; 0 keeps none"
        )));
    }
    let scenario: String = asked.take("scenario")?;
    let scenario = match asked.take::<Option<String>>("toml")? {
        Some(text) => scenario::parse(&scenario, &text, &scenario),
        None => scenario::load(&scenario),
    }
    .map_err(from_user)?;
    let mut control = Local::new(&scenario.settings).map_err(|e| from_user(e.into()))?;
    let watch = Watch {
        every: TICK_RATE_HZ
            .checked_div(samples_per_second)
            .map_or(0, u64::from),
        samples: Vec::new(),
        contacts: Vec::new(),
        events: Vec::new(),
        state: "idle",
        frequency_hz: 0.0,
    };
    let mut run = Run::new(&scenario, &mut control, watch).map_err(from_user)?;
    let blocks = scenario.blocks();
    let (summary, watch) = asked.run(blocks, |listener| {
        for _ in 0..blocks {
            run.block();
            step(listener, 1)?;
        }
        Ok(run.finish())
    })?;
    let found = fields(py, &judge(&scenario, &summary))?;
    found.set_item("samples", table(py, &watch.samples)?)?;
    found.set_item("contact_list", table(py, &watch.contacts)?)?;
    found.set_item("timeline", table(py, &watch.events)?)?;
    record(found)
}

/// The built-in scenarios: name and description.
#[pyfunction]
pub fn scenarios() -> PyResult<Vec<(String, String)>> {
    let one = |(name, text): &(&str, &str)| {
        let scenario = scenario::parse(name, text, name).map_err(from_user)?;
        Ok(((*name).to_owned(), scenario.description))
    };
    BUILTIN.iter().map(one).collect()
}

/// The controller on many rigs that differ at random from its settings.
#[pyfunction]
pub fn trials(asked: Keywords<'_>) -> PyResult<Bound<'_, PyAny>> {
    let py = asked.py();
    let rigs = match asked.take::<Option<PyRef<'_, PythonRig>>>("rig")? {
        Some(rig) => vec![rig.named.clone()],
        None => NamedRig::presets(),
    };
    let request = TrialsRequest::new(
        asked.take("long")?,
        asked.take("count")?,
        asked.take("seconds")?,
        asked.take("seed")?,
    );
    let request = request.map_err(from_user)?;
    let steps = u64::from(request.count);
    let (found, table) = if request.long {
        let found = asked.run(steps, |watch| Ok(request.run_long(&rigs, watch)))?;
        let found = found.map_err(from_user)?;
        (fields(py, &found)?, table(py, &found.trials)?)
    } else {
        let found = asked.run(steps, |watch| Ok(request.run(&rigs, watch)))?;
        let found = found.map_err(from_user)?;
        let whole = fields(py, &found)?;
        whole.set_item("distributions", table(py, &found.distributions)?)?;
        (whole, table(py, &found.trials)?)
    };
    found.set_item("trials", table)?;
    record(found)
}
