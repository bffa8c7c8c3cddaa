//! Faults by their electrical cause, with the drive on: how long PA8 goes on, and what the board says after it.

use shared::control::State;
use shared::fault::Fault;

use super::session::Bench;
use super::{Found, Setup, must};
use crate::machine::Change;
use crate::parts::gpio::Outside;
use crate::parts::rcc::External;
use crate::rig::port;

/// Does something to a board that drives; PA8 must be low for good within `limit_us`, and the fault after `wait_ms`
/// the one that is wanted.
fn strike(
    setup: &Setup,
    limit_us: f64,
    wait_ms: u64,
    wanted: Option<Fault>,
    strike: impl Fn(&mut Bench) -> Result<(), Box<dyn std::error::Error>>,
) -> Found {
    let mut bench = Bench::driving(setup)?;
    let from = bench.now();
    strike(&mut bench)?;
    bench.advance_ms(wait_ms)?;
    let gone = bench.enable_gone_us(from)?;
    must(gone <= limit_us, || {
        format!("PA8 was last high {gone:.1} µs after the cause; {limit_us} are allowed")
    })?;
    let resets = bench
        .changes_since(from)
        .iter()
        .filter(|(_, c)| matches!(c, Change::Reset(_)))
        .count();
    let status = bench.status()?;
    let fault = status.fault.map(|record| record.fault);
    must(fault == wanted, || {
        format!("then {fault:?} in {:?}, not {wanted:?}", status.state)
    })?;
    let fault = fault.map_or_else(|| "no fault".into(), |fault| format!("{fault:?}"));
    let text = format!(
        "PA8 low for good {gone:.1} µs after it ({limit_us} allowed), {resets} reset(s), then {:?}: {fault}",
        status.state
    );
    Ok((text, bench.now()))
}

/// PB5 rises.
pub fn chain(setup: &Setup) -> Found {
    strike(setup, 5.0, 50, Some(Fault::EmergencyStop), |bench| {
        let rig = &mut bench.rig.borrow_mut();
        let tick_s = 50e-6;
        let now_s = rig.world.plant().time_s();
        rig.world.set_emergency(true, now_s + tick_s / 2.0);
        rig.machine.set_pin(port::B, 5, Outside::High);
        Ok(())
    })
}

/// TIM2 stands: no samples, and no interrupt of the control task; the block monitor acts.
pub fn samples_stop(setup: &Setup) -> Found {
    strike(setup, 3_100.0, 100, Some(Fault::StaleSamples), |bench| {
        bench.rig.borrow_mut().machine.poke(0x4000_0000, 0)?;
        Ok(())
    })
}

/// The samples' DMA stream is switched off; the converter then overruns.
pub fn stream_stops(setup: &Setup) -> Found {
    const CONTROL: u32 = 0x4002_6410;
    strike(setup, 3_100.0, 100, Some(Fault::StaleSamples), |bench| {
        let machine = &mut bench.rig.borrow_mut().machine;
        let value = machine.peek(CONTROL)?;
        Ok(machine.poke(CONTROL, value & !1)?)
    })
}

/// A debugger is attached and has left its traps in the part, at HardFault and at the other vectors; then a load from
/// nowhere. The program must have cleared them: halted at the fault, it could not make the outputs safe.
pub fn traps(setup: &Setup) -> Found {
    const TRAPS: u32 = 0x7f0;
    let mut bench = Bench::driving_with(setup, Some(TRAPS))?;
    let from = bench.now();
    bench.rig.borrow_mut().machine.cpu.pc = 0x0900_0000;
    bench.advance_ms(5)?;
    let gone = bench.enable_gone_us(from)?;
    must(gone <= 20.0, || {
        format!("PA8 was last high {gone:.1} µs after the fault")
    })?;
    let at = bench.changes_since(from);
    let halt = at.iter().find_map(|(_, change)| match change {
        Change::Halt(why) => Some(*why),
        _ => None,
    });
    let text = format!(
        "PA8 low for good {gone:.1} µs after it, then halted by: {}",
        halt.unwrap_or("nothing")
    );
    Ok((text, bench.now()))
}

/// The debugger's clock ends.
pub fn clock_dies(setup: &Setup) -> Found {
    strike(setup, 20.0, 1500, Some(Fault::BoardUnfit), |bench| {
        Ok(bench.rig.borrow_mut().machine.set_hse(External::Missing)?)
    })
}

/// The supply falls below the voltage detector's level, and comes back.
pub fn supply_sags(setup: &Setup) -> Found {
    strike(setup, 10.0, 400, Some(Fault::BoardUnfit), |bench| {
        let rig = &mut bench.rig.borrow_mut();
        rig.machine.set_supply(2.88);
        rig.advance(2_000)?;
        rig.machine.set_supply(3.3);
        Ok(())
    })
}

/// The stack pointer at the bottom of RAM: the next call or interrupt leaves it.
pub fn stack_overflow(setup: &Setup) -> Found {
    strike(setup, 600.0, 400, Some(Fault::Crash), |bench| {
        bench.rig.borrow_mut().machine.cpu.r[13] = crate::memory::RAM + 8;
        Ok(())
    })
}

/// The program goes on where nothing is.
pub fn bad_address(setup: &Setup) -> Found {
    strike(setup, 20.0, 400, Some(Fault::Crash), |bench| {
        bench.rig.borrow_mut().machine.cpu.pc = 0x0900_0000;
        Ok(())
    })
}

/// A debugger halts the processor and goes away: the pulses end at once, the watchdog resets the board.
pub fn halted(setup: &Setup) -> Found {
    let mut bench = Bench::driving(setup)?;
    let from = bench.now();
    bench.rig.borrow_mut().machine.stand_still();
    bench.advance_ms(10)?;
    let driven = bench.rig.borrow_mut().is_driven();
    must(!driven, || {
        "the pulses hold the enable 10 ms after the processor was halted".into()
    })?;
    bench.advance_ms(4_000)?;
    let reset = bench
        .changes_since(from)
        .iter()
        .find(|(_, c)| matches!(c, Change::Reset(_)))
        .map(|(at, _)| *at);
    let reset = reset.ok_or("no reset within 4 s")?;
    let status = bench.must_be(State::Fault)?;
    let fault = status
        .fault
        .map_or_else(String::new, |record| format!("{:?}", record.fault));
    let seconds = (reset - from) as f64 / crate::parts::UNITS_PER_S as f64;
    Ok((
        format!("the watchdog resets after {seconds:.2} s, then in Fault: {fault}"),
        bench.now(),
    ))
}
