//! Two faults at once.

use shared::fault::Fault;
use shared::link::{LinkAct, LinkAnswer, ToBoard};

use super::faults::{CRASH_US, NO_BLOCKS_US, Strike, struck};
use super::session::Bench;
use super::{Found, Setup, must};
use crate::machine::Change;
use crate::parts::rcc::External;
use crate::rig::{Rig, Trap, wired};

/// The control register of the samples' DMA stream.
const SAMPLES: u32 = 0x4002_6410;

/// The chain opens while settings are saved and the processor stands: it is in Fault afterwards, the settings are saved.
pub fn chain_in_a_save(setup: &Setup) -> Found {
    let (mut bench, _) = Bench::idle(setup)?;
    let mut second = bench.scenario.settings;
    second.rig.amplitude_m *= 1.01;
    bench.rig.borrow_mut().trap = Some(Trap {
        when: |machine| machine.parts.flash.is_erasing(),
        then: Rig::open_chain,
    });
    let from = bench.now();
    bench.client.steer(LinkAct::SetSettings(second))?;
    let open = bench.rig.borrow().trap.is_none();
    must(open, || "nothing was erased".into())?;
    bench.must_be_in(Fault::EmergencyStop)?;
    let high = bench
        .changes_since(from)
        .iter()
        .any(|(_, change)| *change == Change::Enable(Some(true)));
    must(!high, || "PA8 was high".into())?;
    let mut after = Bench::power_up(setup, wired())?;
    after
        .rig
        .borrow_mut()
        .machine
        .set_flash(&bench.rig.borrow().machine.flash);
    after.advance_ms(100)?;
    after.client.hello()?;
    let stored = after.client.ask(ToBoard::GetSettings)?;
    must(stored == LinkAnswer::Settings(second), || {
        "the settings that were sent are not stored".into()
    })?;
    Ok((
        "in Fault: EmergencyStop, and the settings are stored".into(),
        bench.now() - from + after.now(),
    ))
}

/// The samples stop, and a millisecond later the clock dies.
pub fn clock_dies_in_a_stall(setup: &Setup) -> Found {
    let strike = Strike {
        limit_us: NO_BLOCKS_US,
        wait_ms: 1500,
        wanted: Fault::BoardUnfit,
    };
    let found = struck(setup, &strike, |bench| {
        let rig = &mut bench.rig.borrow_mut();
        let value = rig.machine.peek(SAMPLES)?;
        rig.machine.poke(SAMPLES, value & !1)?;
        rig.advance(1_000)?;
        rig.machine.set_hse(External::Missing)?;
        Ok(())
    })?;
    Ok((found.text(&strike), found.units))
}

/// The clock dies, and while the program reports it the supply falls below the brown-out reset.
pub fn supply_falls_after_the_clock(setup: &Setup) -> Found {
    let strike = Strike {
        limit_us: CRASH_US,
        wait_ms: 1500,
        wanted: Fault::BoardUnfit,
    };
    let found = struck(setup, &strike, |bench| {
        let rig = &mut bench.rig.borrow_mut();
        rig.machine.set_hse(External::Missing)?;
        rig.advance(500)?;
        rig.machine.set_supply(2.5);
        rig.machine.set_supply(3.3);
        Ok(())
    })?;
    Ok((found.text(&strike), found.units))
}

/// A sensor's wire breaks and the chain opens with it.
pub fn wire_and_chain(setup: &Setup) -> Found {
    let strike = Strike {
        limit_us: super::faults::CHAIN_US,
        wait_ms: 60,
        wanted: Fault::EmergencyStop,
    };
    let found = struck(setup, &strike, |bench| {
        let rig = &mut bench.rig.borrow_mut();
        rig.forced[1] = Some(0);
        rig.open_chain();
        Ok(())
    })?;
    Ok((found.text(&strike), found.units))
}
