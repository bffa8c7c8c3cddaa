//! Programs that hang or are starved: nothing says that they did, but the pulses and the watchdog.

use shared::control::State;
use shared::fault::Fault;

use super::session::Bench;
use super::{Found, Setup, must};
use crate::core::nvic::FIRST;
use crate::machine::Machine;
use crate::memory::FLASH;
use crate::parts::{UNITS_PER_S, interrupt, rcc::cause};
use crate::profile::CONTROL;
use crate::rig::wired;

/// `b .`, and where nothing else is in flash.
const HANG: u16 = 0xe7fe;
const FREE: u32 = FLASH + 0x7_ff00;

/// The longest until the watchdog resets, at the LSI's slowest (docs/flashing.md), s.
pub const WATCHDOG_S: f64 = 3.8;

impl Machine {
    /// The program goes round in one place.
    fn hang(&mut self) {
        self.place_code(FREE, &[HANG]);
        self.cpu.pc = FREE;
        self.cpu.it = 0;
    }
}

/// Goes on until no task is at work, none is masked, and PA8 is high: low for good, it drops the drive by itself.
fn until_idle(bench: &mut Bench) -> Result<(), Box<dyn std::error::Error>> {
    for _ in 0..10_000 {
        {
            let machine = &bench.rig.borrow().machine;
            let cpu = &machine.cpu;
            if cpu.ipsr == 0 && cpu.basepri == 0 && !cpu.primask && machine.enabled() {
                return Ok(());
            }
        }
        bench.rig.borrow_mut().advance(1)?;
    }
    Err("the idle loop does not run".into())
}

/// The watchdog must have reset the board, and the controller must know.
fn watchdog_acts(bench: &mut Bench, from: u64) -> Result<f64, Box<dyn std::error::Error>> {
    let (at, flags) = bench.until_reset(from, WATCHDOG_S)?;
    must(flags & cause::WATCHDOG != 0, || {
        format!("the reset has flags {flags:#010x}, not the watchdog's")
    })?;
    bench.must_be_in(Fault::WatchdogReset)?;
    Ok((at - from) as f64 / UNITS_PER_S as f64)
}

/// Everything is masked, for ever; with the LSI at its usual frequency, and at its slowest.
pub fn hung(setup: &Setup) -> Found {
    let (usual, from_usual) = hung_with(setup, 32_000)?;
    let (slow, from_slow) = hung_with(setup, 17_000)?;
    Ok((
        format!(
            "no pulses; reset after {usual:.2} s, or {slow:.2} s with an LSI of 17 kHz, then in Fault: WatchdogReset"
        ),
        from_usual + from_slow,
    ))
}

/// After how many seconds the reset comes, and the rig time of it all.
fn hung_with(setup: &Setup, lsi_hz: u64) -> Result<(f64, u64), Box<dyn std::error::Error>> {
    let mut bench = Bench::driving(setup)?;
    let from = bench.now();
    {
        let machine = &mut bench.rig.borrow_mut().machine;
        machine.parts.watchdog.lsi_hz = lsi_hz;
        machine.hang();
        machine.cpu.primask = true;
    }
    bench.advance_ms(3)?;
    let driven = bench.rig.borrow_mut().is_driven();
    must(!driven, || {
        "the pulses hold the enable 3 ms after the program hung".into()
    })?;
    let seconds = watchdog_acts(&mut bench, from)?;
    Ok((seconds, bench.now() - from))
}

/// When the program hangs in its start, ms after power comes on: as soon as memory is set up, and behind the clock.
const IN_THE_START_MS: [u64; 2] = [13, 25];

/// The watchdog runs from the first moment on.
pub fn hung_in_the_start(setup: &Setup) -> Found {
    let mut text = Vec::new();
    let mut units = 0;
    for ms in IN_THE_START_MS {
        let mut bench = Bench::power_up(setup, wired())?;
        bench.advance_ms(ms)?;
        let from = bench.now();
        {
            let machine = &mut bench.rig.borrow_mut().machine;
            machine.parts.watchdog.lsi_hz = 17_000;
            machine.hang();
            machine.cpu.primask = true;
        }
        let (at, flags) = bench
            .until_reset(from, WATCHDOG_S)
            .map_err(|error| format!("after {ms} ms: {error}"))?;
        must(flags & cause::WATCHDOG != 0, || {
            format!("after {ms} ms: a reset with flags {flags:#010x}")
        })?;
        let seconds = at as f64 / UNITS_PER_S as f64;
        text.push(format!(
            "after {ms} ms: reset {seconds:.2} s after power-up"
        ));
        units += bench.now();
    }
    Ok((text.join(", ") + ", with an LSI of 17 kHz", units))
}

/// What holds the control task off does not hold off the block monitor.
pub fn control_starved(setup: &Setup) -> Found {
    let mut bench = Bench::driving(setup)?;
    until_idle(&mut bench)?;
    let from = bench.now();
    {
        let machine = &mut bench.rig.borrow_mut().machine;
        machine.hang();
        machine.cpu.basepri = machine.nvic.priority[CONTROL];
    }
    bench.advance_ms(10)?;
    let gone = bench.enable_gone_us(from)?;
    must(gone <= super::faults::NO_BLOCKS_US, || {
        format!("PA8 was last high {gone:.1} µs after the last block")
    })?;
    let seconds = watchdog_acts(&mut bench, from)?;
    Ok((
        format!(
            "PA8 low for good {gone:.1} µs after it ({} allowed), by the block monitor; reset after {seconds:.2} s, then in \
             Fault: WatchdogReset",
            super::faults::NO_BLOCKS_US
        ),
        bench.now() - from,
    ))
}

/// The enable must be gone so soon after the link's or the supervisor's last turn, µs.
const NOT_HEARD_US: f64 = 103_000.0;

/// The link's task and what is below it; the control task goes on.
pub fn link_starved(setup: &Setup) -> Found {
    starved(setup, interrupt::TIM6)
}

/// The supervisor's task, and what is below it.
pub fn supervisor_starved(setup: &Setup) -> Found {
    starved(setup, interrupt::UART5)
}

fn starved(setup: &Setup, task: usize) -> Found {
    let mut bench = Bench::driving(setup)?;
    until_idle(&mut bench)?;
    let from = bench.now();
    {
        let machine = &mut bench.rig.borrow_mut().machine;
        machine.hang();
        machine.cpu.basepri = machine.nvic.priority[FIRST + task];
    }
    bench.advance_ms(150)?;
    let gone = bench.enable_gone_us(from)?;
    must(gone <= NOT_HEARD_US, || {
        format!("PA8 was last high {gone:.1} µs after the task's last turn")
    })?;
    let (at, flags) = bench.until_reset(from, WATCHDOG_S)?;
    must(flags & cause::WATCHDOG != 0, || {
        format!("the reset has flags {flags:#010x}, not the watchdog's")
    })?;
    let record = bench.must_be(State::Fault)?.fault.ok_or("no record")?;
    let both = [Fault::StaleSamples, Fault::WatchdogReset];
    must(
        both.iter().all(|fault| record.episode.contains(*fault)),
        || format!("after the reset: {record:?}"),
    )?;
    let seconds = (at - from) as f64 / UNITS_PER_S as f64;
    Ok((
        format!(
            "PA8 low for good {:.1} ms after it ({:.0} allowed); reset after {seconds:.2} s, then in Fault: {:?}",
            1e-3 * gone,
            1e-3 * NOT_HEARD_US,
            record.fault
        ),
        bench.now() - from,
    ))
}
