//! The controller in a closed loop with the emulated rig.

use emulator::local::Local;
use emulator::record::{BlockRow, Contact, Event, Observer, TickRow};
use emulator::scenario::{self, BUILTIN};
use emulator::verdict::judge;
use files::UserError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;
use shared::settings::TICK_RATE_HZ;

use crate::error::{from_user, wrong};
use crate::values::{columns, record};
use crate::work::How;

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

/// Something that happened.
#[derive(Serialize)]
struct Line {
    time_s: f64,
    what: String,
}

/// What is kept of a run.
struct Watch {
    every: u64,
    samples: Vec<Sample>,
    contacts: Vec<Contact>,
    events: Vec<Line>,
    state: &'static str,
    frequency_hz: f32,
}

impl Observer for Watch {
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

    fn contact(&mut self, contact: &Contact) {
        self.contacts.push(*contact);
    }

    fn event(&mut self, event: &Event) {
        self.events.push(Line {
            time_s: event.time_s,
            what: event.what.to_string(),
        });
    }
}

#[pyfunction]
#[pyo3(signature = (scenario, *, toml, samples_per_second))]
pub fn emulate<'py>(
    py: Python<'py>,
    scenario: String,
    toml: Option<String>,
    samples_per_second: u32,
) -> PyResult<Bound<'py, PyDict>> {
    if samples_per_second > TICK_RATE_HZ {
        return Err(wrong(format!(
            "samples_per_second is {samples_per_second}, must be at most {TICK_RATE_HZ}; 0 keeps none"
        )));
    }
    let every = match samples_per_second {
        0 => 0,
        n => u64::from(TICK_RATE_HZ / n),
    };
    let how = How {
        threads: None,
        progress: None,
    };
    let ran = how.run(py, 1, |_| Ok(ran(&scenario, toml.as_deref(), every)))?;
    let (verdict, watch) = ran.map_err(from_user)?;
    let found = record(py, &verdict)?;
    found.set_item("samples", columns(py, &watch.samples)?)?;
    found.set_item("contact_list", columns(py, &watch.contacts)?)?;
    found.set_item("timeline", columns(py, &watch.events)?)?;
    Ok(found)
}

fn ran(
    name: &str,
    toml: Option<&str>,
    every: u64,
) -> Result<(emulator::verdict::Verdict, Watch), UserError> {
    let scenario = match toml {
        Some(text) => scenario::parse(name, text, name)?,
        None => scenario::load(name)?,
    };
    let mut control = Local::new(&scenario.settings)?;
    let mut watch = Watch {
        every,
        samples: Vec::new(),
        contacts: Vec::new(),
        events: Vec::new(),
        state: "idle",
        frequency_hz: 0.0,
    };
    let tally = emulator::run::run(&scenario, &mut control, &mut watch)?;
    Ok((judge(&scenario, &tally), watch))
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
