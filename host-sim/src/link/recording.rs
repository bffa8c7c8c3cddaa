//! Records what a board streams into a log that `host-sim replay` reads.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use shared::control::{BootInfo, Command, State, Status};
use shared::link::{FromBoard, Hello, LinkAct, ToBoard};

use super::client::Client;
use emulator::log::{Header, LogBlock, LogWriter};
use emulator::names::state_name;
use files::UserError;
use files::made_from::{self, MadeFrom};

/// A board that streams nothing for so long is taken as stopped.
const PATIENCE: Duration = Duration::from_secs(3);

/// Time between two signs of life.
const PACE: Duration = Duration::from_millis(200);

/// How often a recording looks whether it was interrupted.
const LOOK: Duration = Duration::from_millis(200);

/// Records `ticks` ticks of a controller that is idle at first and is restarted with its own settings. The command
/// `given` is sent once the recording runs; the client has opened its session. If there is one, the controller is stopped
/// at the
/// end. Returns the log's path and its ticks: fewer than asked for once `interrupted` says so.
///
/// # Errors
/// If the link fails, the controller is not idle, or ticks are lost. What was recorded before is kept, and the error says
/// where.
pub fn record<P: Read + Write>(
    client: &mut Client<P>,
    hello: &Hello,
    path: &Path,
    made: &MadeFrom,
    ticks: u64,
    given: Option<Command>,
    interrupted: &dyn Fn() -> bool,
) -> Result<(PathBuf, u64), UserError> {
    let settings = client.settings()?;
    let status = client.status()?;
    if status.state != State::Idle {
        let first = match status.state {
            State::Fault => "clear-fault",
            _ => "stop",
        };
        return Err(client.complaint(format!(
            "a recording begins in idle, so that it can be replayed, and the controller is in {}; `host-sim link {} {first}` first",
            state_name(status.state),
            client.name()
        )));
    }
    let header = Header {
        source: hello.board.to_string(),
        settings,
        birth: BootInfo::STORED,
        block_ticks: u32::from(hello.block_ticks),
        scenario: None,
        made_from: Some(made_from::pair(made).1),
    };
    let mut writer = LogWriter::create(path, &header)?;
    client.tell(ToBoard::StreamFrames { on: true })?;
    // The same settings again: the controller is made anew, and a replay can begin where it did.
    client.steer(LinkAct::SetSettings(settings))?;
    if let Some(command) = given {
        client.command(command)?;
    }
    // With a heartbeat, who has started must be heard.
    let heartbeat = given.is_some() && settings.operator.heartbeat;
    let done = stream(client, &mut writer, ticks, heartbeat, interrupted);
    // Whatever happened, the board is left in peace.
    let quiet = client.tell(ToBoard::StreamFrames { on: false });
    let stopped = match given {
        Some(_) => client.command(Command::Stop),
        None => Ok(()),
    };
    // In Fault it has stopped already, and refuses.
    let in_fault = |status: Status| status.state == State::Fault;
    let stopped = stopped.or_else(|why| match client.status().is_ok_and(in_fault) {
        true => Ok(()),
        false => Err(why),
    });
    let recorded = writer.ticks();
    let whole = done.and(quiet).and(stopped);
    if recorded == 0 {
        whole?;
        return Err(client.complaint("interrupted before the first tick; nothing was recorded"));
    }
    let path = writer.finish()?;
    let kept = |why| UserError::new(format!("{why}; {recorded} ticks are in {}", path.display()));
    whole.map_err(kept)?;
    Ok((path, recorded))
}

fn stream<P: Read + Write>(
    client: &mut Client<P>,
    writer: &mut LogWriter,
    ticks: u64,
    heartbeat: bool,
    interrupted: &dyn Fn() -> bool,
) -> Result<(), UserError> {
    let mut expected = None;
    let mut heard = Instant::now();
    let mut alive = Instant::now();
    while writer.ticks() < ticks && !interrupted() {
        if heartbeat && alive.elapsed() > PACE {
            alive = Instant::now();
            client.command(Command::Alive)?;
        }
        let Some(FromBoard::Recording(recording)) = client.streamed(LOOK)? else {
            if heard.elapsed() > PATIENCE {
                return Err(client.complaint(
                    "the board streams no samples for a recording; does a debugger hold it? Reset it and try again",
                ));
            }
            continue;
        };
        let exchange = recording.unpack();
        if expected.is_none() && !exchange.notes.restarted {
            if heard.elapsed() > PATIENCE {
                return Err(client.complaint(
                    "the board does not restart with its settings, so the recording could not be replayed; reset it and try again",
                ));
            }
            continue;
        }
        heard = Instant::now();
        let next = expected.unwrap_or(exchange.tick);
        if exchange.tick != next {
            return Err(client.complaint(format!(
                "{} ticks were lost; use a faster port, or a computer with less to do",
                exchange.tick.wrapping_sub(next)
            )));
        }
        expected = Some(next.wrapping_add(exchange.frames.len() as u32));
        writer.block(&LogBlock::from(&exchange))?;
    }
    Ok(())
}
