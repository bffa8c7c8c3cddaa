//! Scenarios with faults in the closed loop.

use emulator::log::LogReader;
use emulator::scenario::{ScenarioAct, load};
use files::made_from::MadeFrom;
use host_sim::link::recording::record;
use host_sim::progress::ProgressLine;
use host_sim::replay::replay;
use shared::control::{Command, Mode};

use super::session::Bench;
use super::{Found, Setup, must};
use crate::rig::wired;

/// Five of the built-in ones.
const NAMES: [&str; 5] = [
    "sensor-open",
    "over-force",
    "emergency-stop",
    "sensor-frozen",
    "over-travel",
];

/// When the first fault comes in place of its own time, and how much is recorded, s of rig time.
const FAULT_S: f64 = 6.5;
const RECORDED_S: f64 = 8.0;

/// Each shortened, started over the link and recorded at full rate: decisions equal to the desktop's bit for bit, and the
/// scenario's fault.
pub fn with_faults(setup: &Setup) -> Found {
    let mut text = Vec::new();
    let mut units = 0;
    for name in NAMES {
        let (found, took) = one(setup, name).map_err(|e| format!("{name}: {e}"))?;
        text.push(found);
        units += took;
    }
    Ok((text.join("; "), units))
}

fn one(setup: &Setup, name: &str) -> Found {
    let mut scenario = load(name)?;
    // The start comes over the link.
    scenario
        .events
        .retain(|event| !matches!(event.act, ScenarioAct::Start { .. }));
    let first = scenario.events.first().ok_or("no event")?.at_s;
    for event in &mut scenario.events {
        event.at_s += FAULT_S - first;
    }
    let wanted = scenario.expect.faults.first().copied();
    let bench = Bench::power_up_in(setup, scenario, wired())?;
    let (mut bench, hello) = bench.prepared(None)?;
    let folder = tempfile::tempdir()?;
    let ticks = (RECORDED_S * f64::from(hello.tick_rate_hz)) as u64;
    let (log, _) = record(
        &mut bench.client,
        &hello,
        &folder.path().join("board"),
        &MadeFrom::this_program(),
        ticks,
        Some(Command::Start(Mode::Automatic)),
        &|| false,
    )?;
    let status = bench.client.status()?;
    let fault = status.fault.map(|record| record.fault);
    must(fault == wanted, || {
        format!("{fault:?} in {:?}, not {wanted:?}", status.state)
    })?;
    let replayed = replay(&mut LogReader::open(&log)?, &ProgressLine::new("", 1, true))?;
    must(replayed.difference.is_none(), || {
        format!("the desktop decides otherwise: {:?}", replayed.difference)
    })?;
    Ok((
        format!("{name}: {} ticks bit-equal, in Fault", replayed.ticks),
        bench.now(),
    ))
}
