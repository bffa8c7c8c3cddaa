//! Recordings over a wire that is disturbed, and after it.

use std::time::Duration;

use emulator::log::LogReader;
use files::made_from::MadeFrom;
use host_sim::link::recording::record;
use host_sim::progress::ProgressLine;
use host_sim::replay::replay;
use shared::control::{Command, Mode, State};
use shared::link::RATES;

use super::session::Bench;
use super::{Found, Setup, must};
use crate::rig::{Disturbance, wired};

/// Rig time of each recording, ticks: 2 s.
const TICKS: u64 = 40_000;

/// One recording while bytes are lost and garbled: it must end with an error that says how many ticks are gone. Then one
/// on the quiet wire: without a gap.
pub fn disturbed(setup: &Setup) -> Found {
    let (mut bench, hello) = Bench::idle(setup)?;
    let folder = tempfile::tempdir()?;
    let made = MadeFrom::this_program();
    let start = || Some(Command::Start(Mode::Automatic));
    bench.rig.borrow_mut().disturbed = Some(Disturbance {
        lost: 20_011,
        garbled: 30_011,
    });
    let broken = record(
        &mut bench.client,
        &hello,
        &folder.path().join("broken"),
        &made,
        TICKS,
        start(),
        &|| false,
    );
    bench.rig.borrow_mut().disturbed = None;
    let why = match broken {
        Ok(_) => return Err("bytes were lost, and the recording says nothing of it".into()),
        Err(why) => why.to_string(),
    };
    must(why.contains("ticks were lost"), || {
        format!("the recording ends with: {why}")
    })?;
    // What came before is a whole log.
    let broken = LogReader::open(folder.path().join("broken"));
    let before = replay(&mut broken?, &ProgressLine::new("", 1, true))?;
    must(before.difference.is_none() && before.ticks > 0, || {
        format!("before the gap: {before:?}")
    })?;
    while bench.client.streamed(Duration::ZERO)?.is_some() {}
    for _ in 0..60 {
        bench.advance_ms(100)?;
        if bench.status()?.state == State::Idle {
            break;
        }
    }
    bench.must_be(State::Idle)?;
    let (log, _) = record(
        &mut bench.client,
        &hello,
        &folder.path().join("after"),
        &made,
        TICKS,
        start(),
        &|| false,
    )?;
    let replayed = replay(&mut LogReader::open(&log)?, &ProgressLine::new("", 1, true))?;
    must(
        replayed.difference.is_none() && replayed.ticks >= TICKS,
        || format!("after it: {replayed:?}"),
    )?;
    let lost = bench.client.lost();
    must(lost == 0, || {
        format!("{lost} packets lost after the disturbance")
    })?;
    Ok((
        format!(
            "while disturbed the recording ends with an error that counts the ticks lost; after it {} ticks without a gap, \
             decisions bit-equal to the desktop's",
            replayed.ticks
        ),
        bench.now(),
    ))
}

/// A computer at the slower rate: the board finds it with the first message's three attempts, and is steered at it.
pub fn slower(setup: &Setup) -> Found {
    let mut around = wired();
    around.baud = u64::from(RATES[1]);
    let (mut bench, _) = Bench::power_up(setup, around)?.prepared(None)?;
    bench.start_drive()?;
    bench.client.command(Command::Stop)?;
    bench.advance_ms(1_000)?;
    bench.must_be(State::Idle)?;
    Ok((format!("steered at {} Bd", RATES[1]), bench.now()))
}
