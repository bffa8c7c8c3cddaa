//! Resets with the drive on, and a start on a supply that is too low.

use shared::control::{Command, Mode, State};
use shared::fault::Fault;

use super::session::Bench;
use super::{Found, Setup, must};
use crate::machine::Change;
use crate::parts::rcc::cause;

/// The reset button pressed while it drives, once, and three times with 4 ms between: it says so, and does not start again before
/// somebody clears it.
pub fn while_driving(setup: &Setup) -> Found {
    let mut units = 0;
    for times in [1, 3] {
        for flags in [cause::PIN, cause::SOFTWARE | cause::PIN] {
            let mut bench = Bench::driving(setup)?;
            let from = bench.now();
            for _ in 0..times {
                bench.rig.borrow_mut().machine.reset(flags);
                bench.advance_ms(4)?;
            }
            bench.advance_ms(200)?;
            bench
                .must_be_in(Fault::ResetWhileDriving)
                .map_err(|error| format!("{times} times, flags {flags:#x}: {error}"))?;
            // Once it has said so, a reset in Fault adds nothing, and one after it was cleared says nothing.
            bench.client.open_session(false)?;
            bench.client.command(Command::ClearFault)?;
            bench.advance_ms(10)?;
            bench.rig.borrow_mut().machine.reset(flags);
            bench.advance_ms(200)?;
            bench.must_be(State::Idle)?;
            units += bench.now() - from;
        }
    }
    Ok((
        "once, and three times 4 ms apart: in Fault, ResetWhileDriving; cleared, a reset in Idle leaves nothing".into(),
        units,
    ))
}

/// The supply has sagged below the detector's level in Idle, and stays there: a start raises no pulse.
pub fn sagged_before_a_start(setup: &Setup) -> Found {
    let (mut bench, _) = Bench::idle(setup)?;
    bench.rig.borrow_mut().machine.set_supply(2.88);
    bench.advance_ms(500)?;
    bench.must_be(State::Idle)?;
    let from = bench.now();
    bench.client.command(Command::Start(Mode::Automatic))?;
    let mut resets = 0;
    for _ in 0..80 {
        bench.advance_ms(100)?;
        let changes = bench.changes_since(from);
        let high = |(_, change): &(u64, Change)| *change == Change::Enable(Some(true));
        must(!changes.iter().any(high), || "PA8 was high".into())?;
        let is_reset = |(_, change): &&(u64, Change)| matches!(change, Change::Reset(_));
        resets = changes.iter().filter(is_reset).count();
        if resets > 0 {
            break;
        }
    }
    must(resets > 0, || "the start went on".into())?;
    bench.advance_ms(1_000)?;
    bench.must_be_in(Fault::BoardUnfit)?;
    Ok((
        "at 2.88 V: no pulse, a reset, then in Fault: BoardUnfit".into(),
        bench.now() - from,
    ))
}
