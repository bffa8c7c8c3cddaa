//! Faults in Hold, where the drive is at its strongest.

use shared::fault::Fault;

use super::faults::{CHAIN_US, CRASH_US, Strike, struck_from};
use super::session::Bench;
use super::{Found, Setup, must};
use crate::parts::rcc::External;

/// The debugger's clock ends in Hold.
pub fn clock_dies(setup: &Setup) -> Found {
    let strike = Strike {
        limit_us: CRASH_US,
        wait_ms: 1500,
        wanted: Fault::BoardUnfit,
    };
    let bench = Bench::holding(setup)?;
    let found = struck_from(bench, &strike, |bench| {
        Ok(bench.rig.borrow_mut().machine.set_hse(External::Missing)?)
    })?;
    Ok((found.text(&strike), found.bench.now()))
}

/// After the last contact and `trips.no_contact_s`, a drive period at 1 Hz and a block are allowed, µs.
const DEAD_US: f64 = 1.0e6;

/// The force's element dies in Hold, its amplifier and their noise do not.
pub fn dead_force(setup: &Setup) -> Found {
    let bench = Bench::holding(setup)?;
    let settings = bench.scenario.settings;
    let zero = settings.force.zero_code as u16;
    let strike = Strike {
        limit_us: 1e6 * f64::from(settings.trips.no_contact_s) + DEAD_US,
        wait_ms: 60,
        wanted: Fault::NoContact,
    };
    let found = struck_from(bench, &strike, |bench| {
        for ms in 0..(strike.limit_us / 1e3) as u16 {
            bench.rig.borrow_mut().forced[0] = Some(zero + ms % 2);
            bench.advance_ms(1)?;
        }
        Ok(())
    })?;
    Ok((found.text(&strike), found.bench.now()))
}

/// The way back of the set-point after a trip (docs/wiring.md): codes per tick, and ticks at most.
const STEP: u16 = 2;
const WAY_BACK: usize = 900;
const MIDDLE: u16 = 2048;

/// The chain opens in Hold: the set-point at PA4 goes back to the middle, and in no step.
pub fn way_back(setup: &Setup) -> Found {
    let strike = Strike {
        limit_us: CHAIN_US,
        wait_ms: 60,
        wanted: Fault::EmergencyStop,
    };
    let bench = Bench::holding(setup)?;
    let from = bench.rig.borrow().played.len();
    let found = struck_from(bench, &strike, |bench| {
        bench.rig.borrow_mut().open_chain();
        Ok(())
    })?;
    let rig = found.bench.rig.borrow();
    let codes = &rig.played[from..];
    let steps = codes.windows(2).map(|pair| pair[0].abs_diff(pair[1]));
    let step = steps.max().unwrap_or(0);
    let far = codes.iter().map(|code| code.abs_diff(MIDDLE)).max();
    let ticks = codes.iter().rposition(|code| *code != MIDDLE);
    let ticks = ticks.map_or(0, |last| last + 1);
    must(step <= STEP && ticks <= WAY_BACK, || {
        format!("steps of {step} codes, at the middle after {ticks} ticks")
    })?;
    let text = format!(
        "from {} codes off the middle in steps of {step} at most, there after {:.1} ms",
        far.unwrap_or(0),
        ticks as f64 / 20.0
    );
    Ok((text, rig.machine.now))
}
