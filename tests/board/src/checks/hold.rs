//! Faults in Hold, where the drive is at its strongest.

use shared::fault::Fault;

use super::faults::{CRASH_US, Strike, struck_from};
use super::session::Bench;
use super::{Found, Setup};
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
