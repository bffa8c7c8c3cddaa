//! What is kept over a reset: the record, and where the program crashed.

use shared::control::State;
use shared::fault::Fault;

use super::faults::{Strike, struck};
use super::session::Bench;
use super::{Found, Setup, must};
use crate::core::decode32;
use crate::core::op::Kind;
use crate::image::Image;
use crate::machine::Machine;
use crate::memory::{FLASH, RAM};

/// From the end of what is retained: the crash's address and status, before the word about the drive.
const CRASH_ADDRESS: usize = 12;
const CRASH_STATUS: usize = 8;

/// CFSR: an instruction could not be fetched.
const FETCH_FAILED: u32 = 1 << 8;

/// The crash as the program has retained it: address and CFSR.
fn crash(machine: &Machine) -> Result<(u32, u32), String> {
    let (start, size) = machine
        .image
        .object("RETAINED")
        .ok_or("nothing is retained")?;
    let end = (start - RAM + size) as usize;
    let word = |back: usize| {
        let bytes = &machine.ram[end - back..end - back + 4];
        bytes.iter().rev().fold(0, |w, b| w << 8 | u32::from(*b))
    };
    Ok((word(CRASH_ADDRESS), word(CRASH_STATUS)))
}

/// A place in the program that has found a division by zero and panics: two instructions that load where it is in the
/// source, and the call.
fn panics(image: &Image, flash: &[u8]) -> Option<u32> {
    let target = image.symbol_of("panic_const_div_by_zero")? & !1;
    let half = |at: usize| u32::from(flash[at]) | u32::from(flash[at + 1]) << 8;
    let decoded = |at: usize| decode32::decode(FLASH + at as u32, half(at), half(at + 2));
    (0xc008..flash.len() - 4).step_by(2).find_map(|at| {
        let call = decoded(at);
        let loads = [decoded(at - 8).kind, decoded(at - 4).kind];
        (call.kind == Kind::BranchLink && call.imm == target && loads == [Kind::MovI, Kind::Movt])
            .then_some(FLASH + at as u32 - 8)
    })
}

/// The program finds a division by zero, at a place in its code where it would.
pub fn panic(setup: &Setup) -> Found {
    let strike = Strike {
        limit_us: super::faults::CRASH_US,
        wait_ms: 400,
        wanted: Fault::Crash,
    };
    let found = struck(setup, &strike, |bench| {
        let machine = &mut bench.rig.borrow_mut().machine;
        let at = panics(&machine.image, &machine.flash).ok_or("no place that panics")?;
        machine.cpu.pc = at;
        machine.cpu.it = 0;
        Ok(())
    })?;
    let kept = crash(&found.bench.rig.borrow().machine)?;
    must(kept == (0, 0), || {
        format!("a panic has retained {:#010x}, CFSR {:#x}", kept.0, kept.1)
    })?;
    Ok((found.text(&strike), found.units))
}

/// A fetch from nowhere: the record says so after the reset, with the address and the processor's own account.
pub fn crash_record(setup: &Setup) -> Found {
    const NOWHERE: u32 = 0x0900_0000;
    let strike = Strike {
        limit_us: super::faults::CRASH_US,
        wait_ms: 400,
        wanted: Fault::Crash,
    };
    let found = struck(setup, &strike, |bench| {
        bench.rig.borrow_mut().machine.cpu.pc = NOWHERE;
        Ok(())
    })?;
    let (address, status) = crash(&found.bench.rig.borrow().machine)?;
    must((address, status) == (NOWHERE, FETCH_FAILED), || {
        format!("retained: {address:#010x}, CFSR {status:#x}")
    })?;
    Ok((
        format!("retained: {address:#010x}, CFSR {status:#x}; status shows Crash"),
        found.units,
    ))
}

/// A fault by a sensor, then a reset by the watchdog: the first stays in the episode, with the tick and the value.
pub fn record_over_reset(setup: &Setup) -> Found {
    let mut bench = Bench::driving(setup)?;
    let from = bench.now();
    bench.rig.borrow_mut().forced[0] = Some(100);
    bench.advance_ms(20)?;
    let before = bench.must_be(State::Fault)?.fault.ok_or("no record")?;
    must(before.fault == Fault::SensorSaturated, || {
        format!("{:?} at first", before.fault)
    })?;
    bench.rig.borrow_mut().machine.stand_still();
    bench.until_reset(from, super::hung::WATCHDOG_S)?;
    let after = bench.must_be(State::Fault)?.fault.ok_or("no record")?;
    must(
        (after.fault, after.tick, after.value) == (before.fault, before.tick, before.value)
            && after.episode.contains(Fault::WatchdogReset),
        || format!("{before:?} before the reset, {after:?} after it"),
    )?;
    Ok((
        format!(
            "{:?} with tick {} and value {} before and after the watchdog's reset, which has joined the episode",
            after.fault, after.tick, after.value
        ),
        bench.now() - from,
    ))
}
