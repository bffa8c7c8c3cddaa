//! Waiting that is passed over must change nothing.

use std::time::Duration;

use shared::link::ToBoard;

use super::session::Bench;
use super::{Found, Setup, must};

/// Rig time of each run, s: longer than a forecast takes, in which nothing waits.
const SECONDS: f64 = 5.0;

/// All that a run leaves behind, and the instructions that were executed and passed over.
struct Left {
    fingerprint: u64,
    profile: String,
    executed: u64,
    passed: u64,
}

fn left(setup: &Setup, skips: bool) -> Result<(Left, u64), Box<dyn std::error::Error>> {
    let mut bench = Bench::holding(setup)?;
    let (from, instructions, passed) = {
        let machine = &mut bench.rig.borrow_mut().machine;
        machine.skips = skips;
        machine.start_profile();
        (machine.now, machine.instructions, machine.passed)
    };
    bench.client.hello()?;
    bench.client.tell(ToBoard::StreamFrames { on: true })?;
    let end = from + (SECONDS * crate::parts::UNITS_PER_S as f64) as u64;
    while bench.now() < end {
        bench.client.streamed(Duration::from_millis(1))?;
    }
    let rig = bench.rig.borrow();
    let machine = &rig.machine;
    let passed = machine.passed - passed;
    let left = Left {
        fingerprint: rig.fingerprint(),
        profile: format!("{:?}", machine.profile),
        executed: machine.instructions - instructions - passed,
        passed,
    };
    Ok((left, machine.now - from))
}

/// Hold twice, streaming: every instruction executed, and waiting passed over.
pub fn same(setup: &Setup) -> Found {
    let (all, units) = left(setup, false)?;
    let (some, _) = left(setup, true)?;
    must(all.passed == 0, || "waiting was passed over in both".into())?;
    must(some.passed > all.executed / 10, || {
        format!("only {} instructions were passed over", some.passed)
    })?;
    must(all.executed == some.executed + some.passed, || {
        format!(
            "{} instructions, or {}",
            all.executed,
            some.executed + some.passed
        )
    })?;
    must(all.fingerprint == some.fingerprint, || {
        "pins, wire, registers or RAM differ".into()
    })?;
    must(all.profile == some.profile, || {
        format!("what it costs differs:\n{}\n{}", all.profile, some.profile)
    })?;
    let text = format!(
        "{SECONDS} s of Hold with every instruction executed and with {:.0} % of them passed over: pins, wire, \
         registers, RAM, counts and cycles are the same",
        100.0 * some.passed as f64 / all.executed as f64
    );
    Ok((text, 2 * units))
}
