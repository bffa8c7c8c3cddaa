//! What the board watches besides its sensors: the relay, the power stage, its own measuring reference.

use shared::control::{Command, Mode, State};
use shared::fault::Fault;

use super::faults::{Strike, struck};
use super::session::{Bench, START_STEP_MS};
use super::{Found, Setup, must};
use crate::memory::VREFINT_CODE;
use crate::parts::gpio::Outside;
use crate::rig::{port, wired};

/// Channel of the reference.
const VREFINT: usize = 17;

/// The relay has not pulled in so long after the enable, or the stage is not ready (docs/wiring.md), and for how long a
/// report must contradict the enable, ms.
const RELAY_MS: f64 = 100.0;
const READY_MS: f64 = 1_000.0;
const LASTS_MS: f64 = 10.0;

/// A relay that stays dropped, then a power stage that never gets ready, each with its report wired and set.
pub fn contradict(setup: &Setup) -> Found {
    let mut text = Vec::new();
    let mut units = 0;
    for (name, relay, after_ms) in [
        ("the relay stays dropped", true, RELAY_MS),
        ("the stage is not ready", false, READY_MS),
    ] {
        let mut around = wired();
        around.pins[port::A][9] = Outside::Low;
        let mut bench = Bench::power_up(setup, around)?;
        bench.scenario.settings.interlock.relay = relay;
        bench.scenario.settings.interlock.ready = !relay;
        let (mut bench, _) = bench.prepared(None)?;
        bench.start_drive()?;
        let from = bench.now();
        bench.advance_ms(1_100)?;
        let gone_ms = bench.enable_gone_us(from)? / 1e3;
        let limit_ms = after_ms + LASTS_MS + 1.0;
        must(
            gone_ms <= limit_ms && gone_ms > after_ms - START_STEP_MS as f64,
            || format!("{name}: PA8 was last high after {gone_ms:.1} ms of {limit_ms}"),
        )?;
        bench
            .must_be_in(Fault::EmergencyStop)
            .map_err(|error| format!("{name}: {error}"))?;
        text.push(format!("{name}: PA8 low for good after {gone_ms:.0} ms"));
        units += bench.now();
    }
    Ok((text.join(", ") + ", EmergencyStop", units))
}

/// With `operator.acknowledge`, a chain whose report was not tried since the last start starts nothing: a report that is stuck
/// closed would never be seen. A relay that contradicts is the same fault, and no trial of the chain.
pub fn chain_tried(setup: &Setup) -> Found {
    let mut around = wired();
    around.pins[port::A][9] = Outside::Low;
    let mut bench = Bench::power_up(setup, around)?;
    bench.scenario.settings.operator.acknowledge = true;
    bench.scenario.settings.interlock.relay = true;
    let (mut bench, _) = bench.prepared(None)?;
    let start = Command::Start(Mode::Automatic);
    let pin = |bench: &mut Bench, (port, pin): (usize, usize), level: Outside, ms: u64| {
        bench.rig.borrow_mut().machine.set_pin(port, pin, level);
        bench.advance_ms(ms)
    };
    let press = |bench: &mut Bench| {
        pin(bench, (port::C, 13), Outside::Low, 60)?;
        pin(bench, (port::C, 13), Outside::High, 60)
    };
    for _ in 0..2 {
        pin(&mut bench, (port::A, 9), Outside::Open, 300)?;
        bench.must_be(State::Fault)?;
        pin(&mut bench, (port::A, 9), Outside::Low, 100)?;
        press(&mut bench)?;
        bench.client.command(Command::ClearFault)?;
        must(bench.client.command(start).is_err(), || {
            "a start without a trial of the chain is taken".into()
        })?;
        bench.rig.borrow_mut().open_chain();
        bench.advance_ms(20)?;
        bench.must_be(State::Fault)?;
        bench.rig.borrow_mut().close_chain();
        bench.advance_ms(100)?;
        press(&mut bench)?;
        bench.client.command(Command::ClearFault)?;
        bench.client.command(start)?;
        bench.client.command(Command::Stop)?;
        bench.advance_ms(20)?;
        bench.must_be(State::Idle)?;
    }
    Ok((
        "a start is refused until the chain was opened, closed and acknowledged; after it, again; a relay that contradicts and is \
         acknowledged does not count"
            .into(),
        bench.now(),
    ))
}

/// The relay drops its contact and the stage is ready as they should: the drive stays on.
pub fn agree(setup: &Setup) -> Found {
    let mut around = wired();
    around.pins[port::A][9] = Outside::Low;
    around.pins[port::B][10] = Outside::Low;
    let mut bench = Bench::power_up(setup, around)?;
    bench.scenario.settings.interlock.relay = true;
    bench.scenario.settings.interlock.ready = true;
    let (mut bench, _) = bench.prepared(None)?;
    bench.start_drive()?;
    bench
        .rig
        .borrow_mut()
        .machine
        .set_pin(port::A, 9, Outside::Open);
    bench.advance_ms(1_100)?;
    let driven = bench.rig.borrow_mut().is_driven();
    must(driven, || "the drive went off".into())?;
    Ok((
        "relay pulled in, stage ready: the drive is on 1.1 s later".into(),
        bench.now(),
    ))
}

/// VDDA falls by 4 %: the reference reads that much higher.
pub fn reference(setup: &Setup) -> Found {
    let strike = Strike {
        // Looked at once a second, three times in a row.
        limit_us: 4e6,
        wait_ms: 4_500,
        wanted: Fault::BoardUnfit,
    };
    let found = struck(setup, &strike, |bench| {
        let codes = &mut bench.rig.borrow_mut().machine.codes;
        codes[VREFINT] = VREFINT_CODE + VREFINT_CODE / 25;
        Ok(())
    })?;
    Ok((found.text(&strike), found.units))
}
