//! The emulated rig in the page: plant, sensors and controller in lock-step, and the board's end of the serial link, whose
//! bytes go to and from the page as those of a board do.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::io::{self, Read, Write};

use emulator::board::Served;
use emulator::record::{RunEvent, RunObserver, TickRow, TrueContact};
use emulator::run::Run;
use emulator::scenario::{self, BUILTIN, Scenario};
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::Function;
use crate::json::{read, write};

/// The functions of the emulated rig.
pub const FUNCTIONS: &[(&str, Function)] = &[
    ("emulated.scenarios", scenarios),
    ("emulated.start", start),
    ("emulated.receive", receive),
    ("emulated.step", step),
    ("emulated.event", event),
    ("emulated.truth", truth),
];

/// Lines of the timeline kept.
const LINES: usize = 100;

/// Rig time after which a run in the page ends: a day, s.
const LONGEST_S: f64 = 86_400.0;

/// The bytes between board and page.
#[derive(Debug, Default)]
struct Wire {
    to_board: VecDeque<u8>,
    to_page: Vec<u8>,
}

impl Read for Wire {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        match self.to_board.read(out)? {
            0 => Err(io::ErrorKind::WouldBlock.into()),
            count => Ok(count),
        }
    }
}

impl Write for Wire {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.to_page.extend(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// What is true of the rig.
#[derive(Clone, Debug, Default, Serialize)]
struct Truth {
    time_s: f64,
    /// The drive has power.
    powered: bool,
    contacts: u64,
    /// Of the last contact.
    peak_n: f64,
    impulse_n_s: f64,
    /// What happened since it was last asked.
    events: VecDeque<Line>,
}

#[derive(Clone, Debug, Serialize)]
struct Line {
    time_s: f64,
    text: String,
}

impl RunObserver for Truth {
    fn tick(&mut self, row: &TickRow) {
        (self.time_s, self.powered) = (row.time_s, row.powered);
    }

    fn contact(&mut self, contact: &TrueContact) {
        self.contacts += 1;
        (self.peak_n, self.impulse_n_s) = (contact.peak_force_n, contact.impulse_n_s);
    }

    fn event(&mut self, event: &RunEvent) {
        if self.events.len() >= LINES {
            self.events.pop_front();
        }
        self.events.push_back(Line {
            time_s: event.time_s,
            text: event.what.to_string(),
        });
    }
}

/// A rig that runs.
struct Emulated {
    run: Run<Served<Wire>, Truth>,
    scenario: Scenario,
    /// Its text, with the events that were added.
    text: String,
}

thread_local! {
    static EMULATED: RefCell<Option<Emulated>> = const { RefCell::new(None) };
}

fn with<T>(work: impl FnOnce(&mut Emulated) -> Result<T, String>) -> Result<T, String> {
    EMULATED.with_borrow_mut(|running| match running {
        Some(emulated) => work(emulated),
        None => Err("no rig is running; start a scenario".into()),
    })
}

/// Name and description of every built-in scenario, as JSON.
fn scenarios(_argument: &[u8]) -> Result<Vec<u8>, String> {
    let known = BUILTIN.iter().map(|(name, text)| {
        let scenario = scenario::parse(name, text, name).map_err(|e| e.to_string())?;
        Ok(json!({ "name": name, "description": scenario.description }))
    });
    write(&known.collect::<Result<Vec<_>, String>>()?)
}

#[derive(Deserialize)]
struct Start {
    /// Name of a built-in scenario.
    name: String,
    /// Whether its events happen; without them the rig waits for what the page does.
    events: bool,
}

/// The text of a scenario that goes on for a day.
fn endless(text: &str) -> String {
    let kept = text.lines().map(|line| {
        if line.starts_with("duration_s") {
            format!("duration_s = {LONGEST_S:.1}\n")
        } else {
            format!("{line}\n")
        }
    });
    kept.collect()
}

/// Puts a rig at rest and its board after power-on.
fn start(argument: &[u8]) -> Result<Vec<u8>, String> {
    let Start { name, events } = read(argument)?;
    let (_, text) = BUILTIN
        .iter()
        .find(|(known, _)| *known == name)
        .ok_or_else(|| format!("there is no scenario '{name}'"))?;
    // Without the scenario's own events, and what it expects of them.
    let before = text
        .split_once("[[events]]")
        .map_or(*text, |(before, _)| before);
    let text = endless(if events { text } else { before });
    let scenario = scenario::parse(&name, &text, &name).map_err(|e| e.to_string())?;
    let block_ticks = u8::try_from(scenario.block_ticks).unwrap_or(u8::MAX);
    let board = Served::new(&scenario.settings, block_ticks, Wire::default());
    let board = board.map_err(|e| e.to_string())?;
    let run = Run::new(&scenario, board, Truth::default()).map_err(|e| e.to_string())?;
    EMULATED.set(Some(Emulated {
        run,
        scenario,
        text,
    }));
    Ok(Vec::new())
}

/// Bytes of the page for the board.
fn receive(bytes: &[u8]) -> Result<Vec<u8>, String> {
    with(|rig| {
        rig.run.control().wire().to_board.extend(bytes);
        Ok(Vec::new())
    })
}

#[derive(Deserialize)]
struct Step {
    blocks: u32,
}

/// Lets so many blocks pass; the board's bytes for the page.
fn step(argument: &[u8]) -> Result<Vec<u8>, String> {
    let Step { blocks } = read(argument)?;
    with(|rig| {
        for _ in 0..blocks {
            rig.run.block();
        }
        Ok(std::mem::take(&mut rig.run.control().wire().to_page))
    })
}

#[derive(Deserialize)]
struct Added {
    /// The keys of an event, as in a scenario file, without its time.
    toml: String,
}

/// Lets something happen now.
fn event(argument: &[u8]) -> Result<Vec<u8>, String> {
    let Added { toml } = read(argument)?;
    with(|rig| {
        let now_s = rig.run.time_s();
        let text = format!("{}\n[[events]]\nat_s = {now_s}\n{toml}\n", rig.text);
        let name = &rig.scenario.name;
        let scenario = scenario::parse(name, &text, name).map_err(|e| e.to_string())?;
        rig.run.reschedule(&scenario);
        rig.text = text;
        Ok(Vec::new())
    })
}

/// What is true of the rig, and what has happened since this was last asked.
fn truth(_argument: &[u8]) -> Result<Vec<u8>, String> {
    with(|rig| {
        let truth = rig.run.observer();
        let answer = write(&truth);
        truth.events.clear();
        answer
    })
}

#[cfg(test)]
mod tests;
