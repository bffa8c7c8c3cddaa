//! Faults by their electrical cause, with the drive on: how long PA8 goes on, and what the board says after it.

use shared::control::{Command, Mode, State};
use shared::fault::Fault;

use super::session::Bench;
use super::{Found, Setup, must};
use crate::machine::{Change, Machine};
use crate::parts::rcc::External;
use crate::profile::CONTROL;
use crate::rig::wired;

/// docs/controller.md, "How soon the drive is off": PA8 low for good at the latest so many µs after the cause, at the pin.
pub const CHAIN_US: f64 = 20.0;
/// A panic, a processor fault, a clock that dies, a supply that sags.
pub const CRASH_US: f64 = 20.0;
/// No block is served.
pub const NO_BLOCKS_US: f64 = 3_000.0;

/// Where in the block monitor's millisecond the samples stop.
const PHASES: u64 = 10;
const PHASE_US: u64 = 97;

type Done = Result<(), Box<dyn std::error::Error>>;

/// What must come of a fault.
pub struct Strike {
    /// PA8 must be low for good so soon, µs.
    pub limit_us: f64,
    /// When the fault is looked at.
    pub wait_ms: u64,
    /// The fault that the board must report then.
    pub wanted: Fault,
}

/// What came of it.
pub struct Struck {
    /// The board after it.
    pub bench: Bench,
    /// After how many µs PA8 was low for good.
    pub gone_us: f64,
    /// How many resets came of it.
    pub resets: usize,
    /// Rig time that it took.
    pub units: u64,
}

impl Struck {
    /// What came of it in a line, beside what `strike` allows.
    pub fn text(&self, strike: &Strike) -> String {
        format!(
            "PA8 low for good {:.1} µs after it ({} allowed), {} reset(s), then in Fault: {:?}",
            self.gone_us, strike.limit_us, self.resets, strike.wanted
        )
    }
}

/// Does something to a board that drives; PA8 must be low for good in time, and the fault afterwards the one wanted.
pub fn struck(
    setup: &Setup,
    strike: &Strike,
    act: impl Fn(&mut Bench) -> Done,
) -> Result<Struck, Box<dyn std::error::Error>> {
    struck_from(Bench::driving(setup)?, strike, act)
}

/// As [`struck`], to a board in a given state.
pub fn struck_from(
    mut bench: Bench,
    strike: &Strike,
    act: impl Fn(&mut Bench) -> Done,
) -> Result<Struck, Box<dyn std::error::Error>> {
    let from = bench.now();
    act(&mut bench)?;
    bench.advance_ms(strike.wait_ms)?;
    let gone_us = bench.enable_gone_us(from)?;
    let limit_us = strike.limit_us;
    must(gone_us <= limit_us, || {
        format!("PA8 was last high {gone_us:.1} µs after the cause; {limit_us} are allowed")
    })?;
    let changes = bench.changes_since(from);
    let resets = changes
        .iter()
        .filter(|(_, c)| matches!(c, Change::Reset(_)))
        .count();
    let status = bench.status()?;
    let fault = status.fault.map(|record| record.fault);
    must(
        fault == Some(strike.wanted) && status.state == State::Fault,
        || {
            format!(
                "then {fault:?} in {:?}, not {:?}",
                status.state, strike.wanted
            )
        },
    )?;
    let units = bench.now() - from;
    Ok(Struck {
        bench,
        gone_us,
        resets,
        units,
    })
}

fn strike(
    setup: &Setup,
    limit_us: f64,
    wait_ms: u64,
    wanted: Fault,
    act: impl Fn(&mut Bench) -> Done,
) -> Found {
    let strike = Strike {
        limit_us,
        wait_ms,
        wanted,
    };
    let found = struck(setup, &strike, act)?;
    Ok((found.text(&strike), found.units))
}

/// PB5 rises, while the control task works: its interrupt must come above that task.
pub fn chain(setup: &Setup) -> Found {
    let strike = Strike {
        limit_us: CHAIN_US,
        wait_ms: 50,
        wanted: Fault::EmergencyStop,
    };
    let found = struck_from(in_control(setup)?, &strike, |bench| {
        bench.rig.borrow_mut().open_chain();
        Ok(())
    })?;
    Ok((found.text(&strike), found.units))
}

/// A board that drives, at the start of the control task, with PA8 high.
fn in_control(setup: &Setup) -> Result<Bench, Box<dyn std::error::Error>> {
    let bench = Bench::driving(setup)?;
    for _ in 0..10_000 {
        let there = |machine: &Machine| machine.cpu.ipsr as usize == CONTROL && machine.enabled();
        if there(&bench.rig.borrow().machine) {
            return Ok(bench);
        }
        bench.rig.borrow_mut().advance(1)?;
    }
    Err("the control task does not raise PA8".into())
}

/// TIM2 stands: no samples, and no interrupt of the control task; the block monitor acts.
pub fn samples_stop(setup: &Setup) -> Found {
    let strike = Strike {
        limit_us: NO_BLOCKS_US,
        wait_ms: 100,
        wanted: Fault::StaleSamples,
    };
    let mut longest = 0.0f64;
    let mut units = 0;
    for phase in 0..PHASES {
        let bench = Bench::driving(setup)?;
        bench.rig.borrow_mut().advance(phase * PHASE_US)?;
        let found = struck_from(bench, &strike, |bench| {
            Ok(bench.rig.borrow_mut().machine.poke(0x4000_0000, 0)?)
        })?;
        longest = longest.max(found.gone_us);
        units += found.units;
    }
    let text = format!(
        "{PHASES} times, {PHASE_US} µs apart: PA8 low for good {longest:.1} µs after it at the latest ({NO_BLOCKS_US} \
         allowed), then in Fault: StaleSamples"
    );
    Ok((text, units))
}

/// The samples' DMA stream is switched off; the converter then overruns.
pub fn stream_stops(setup: &Setup) -> Found {
    const CONTROL: u32 = 0x4002_6410;
    strike(setup, NO_BLOCKS_US, 100, Fault::StaleSamples, |bench| {
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
    must(gone <= CRASH_US, || {
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
    strike(setup, CRASH_US, 1500, Fault::BoardUnfit, |bench| {
        Ok(bench.rig.borrow_mut().machine.set_hse(External::Missing)?)
    })
}

/// It pauses: so shortly that nothing acts, and longer.
pub fn clock_pauses(setup: &Setup) -> Found {
    let pause = |bench: &mut Bench, us: u64| -> Done {
        let rig = &mut bench.rig.borrow_mut();
        rig.machine.set_hse(External::Missing)?;
        rig.advance(us)?;
        Ok(rig.machine.set_hse(External::RUNNING)?)
    };
    let mut bench = Bench::driving(setup)?;
    let from = bench.now();
    pause(&mut bench, 1)?;
    bench.advance_ms(200)?;
    let status = bench.status()?;
    let driven = bench.rig.borrow_mut().is_driven();
    must(driven && status.fault.is_none(), || {
        format!("1 µs: driven: {driven}, {:?}", status.fault)
    })?;
    let mut units = bench.now() - from;
    let strike = Strike {
        limit_us: CRASH_US,
        wait_ms: 600,
        wanted: Fault::BoardUnfit,
    };
    let mut gone_us = 0.0f64;
    for us in [3, 50, 5_000] {
        let found = struck(setup, &strike, |bench| pause(bench, us))
            .map_err(|error| format!("{us} µs: {error}"))?;
        let hclk = found.bench.rig.borrow().machine.parts.rcc.hclk_hz()?;
        must(found.resets == 1 && hclk == 180_000_000, || {
            format!("{us} µs: {} resets, then {hclk} Hz", found.resets)
        })?;
        gone_us = gone_us.max(found.gone_us);
        units += found.units;
    }
    let text = format!(
        "for 1 µs: drives on; for 3 µs, 50 µs and 5 ms: PA8 low for good {gone_us:.1} µs after it at most ({CRASH_US} allowed), \
         then with the clock in Fault: BoardUnfit"
    );
    Ok((text, units))
}

/// The supply falls below the voltage detector's level while the control task works, and comes back.
pub fn supply_sags(setup: &Setup) -> Found {
    let strike = Strike {
        limit_us: CRASH_US,
        wait_ms: 400,
        wanted: Fault::BoardUnfit,
    };
    let found = struck_from(in_control(setup)?, &strike, |bench| {
        let rig = &mut bench.rig.borrow_mut();
        rig.machine.set_supply(2.88);
        rig.advance(2_000)?;
        rig.machine.set_supply(3.3);
        Ok(())
    })?;
    Ok((found.text(&strike), found.units))
}

/// The stack pointer at the bottom of RAM: the next call or interrupt leaves it.
pub fn stack_overflow(setup: &Setup) -> Found {
    strike(setup, CRASH_US, 400, Fault::Crash, |bench| {
        bench.rig.borrow_mut().machine.cpu.r[13] = crate::memory::RAM + 8;
        Ok(())
    })
}

/// The program goes on where nothing is.
pub fn bad_address(setup: &Setup) -> Found {
    strike(setup, CRASH_US, 400, Fault::Crash, |bench| {
        bench.rig.borrow_mut().machine.cpu.pc = 0x0900_0000;
        Ok(())
    })
}

/// A debugger halts the processor and goes away: pulses and set-points end at once, the watchdog resets the board.
pub fn halted(setup: &Setup) -> Found {
    let mut bench = Bench::driving(setup)?;
    let from = bench.now();
    bench.rig.borrow_mut().machine.stand_still();
    bench.advance_ms(1)?;
    let ticks = bench.rig.borrow().machine.ticks;
    bench.advance_ms(9)?;
    must(bench.rig.borrow().machine.ticks == ticks, || {
        "samples and set-points go on while the processor is halted".into()
    })?;
    let driven = bench.rig.borrow_mut().is_driven();
    must(!driven, || {
        "the pulses hold the enable 10 ms after the processor was halted".into()
    })?;
    let (reset, _) = bench.until_reset(from, super::hung::WATCHDOG_S)?;
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

/// With the heartbeat asked for, the program on the link falls silent while the drive is on in automatic mode.
pub fn silent_link(setup: &Setup) -> Found {
    let mut bench = Bench::power_up(setup, wired())?;
    bench.scenario.settings.operator.heartbeat = true;
    let silence_s = bench.scenario.settings.trips.link_timeout_s;
    let (mut bench, _) = bench.prepared(None)?;
    bench.client.command(Command::Start(Mode::Automatic))?;
    // Signs of life, for longer than the timeout.
    for _ in 0..20 {
        bench.advance_ms(500)?;
        bench.client.command(Command::Alive)?;
    }
    let driven = bench.rig.borrow_mut().is_driven();
    must(driven, || "the drive is not on with a heartbeat".into())?;
    let from = bench.now();
    bench.advance_ms((1e3 * silence_s) as u64 + 300)?;
    let gone_s = 1e-6 * bench.enable_gone_us(from)?;
    let limit_s = f64::from(silence_s) + 0.01;
    must(gone_s > 0.5 && gone_s <= limit_s, || {
        format!("PA8 was last high {gone_s:.3} s after the last sign of life")
    })?;
    bench.must_be_in(Fault::LinkTimeout)?;
    Ok((
        format!("PA8 low for good {gone_s:.2} s after the last sign of life: LinkTimeout"),
        bench.now() - from,
    ))
}
