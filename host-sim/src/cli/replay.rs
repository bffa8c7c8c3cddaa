//! `host-sim replay`.

use std::path::PathBuf;

use serde::Serialize;

use super::arguments::output::{Format, emit};
use crate::progress::ProgressLine;
use crate::replay::{Replayed, replay};
use emulator::log::{LogReader, TICK_US};
use files::UserError;
use files::made_from::MadeFrom;

/// Feed a log to the controller again: the same decisions, bit for bit, or the first tick that differs
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  host-sim replay out/field.parquet")]
pub struct Args {
    /// The log: a .parquet file of `host-sim emulate` or of a board's recording
    #[arg(value_name = "LOG")]
    log: PathBuf,

    /// Form of the answer on standard output
    #[arg(long, value_enum, default_value = "text")]
    format: Format,

    /// No progress on standard error
    #[arg(long)]
    quiet: bool,

    /// What is asked for, as the answer carries it.
    #[arg(skip)]
    pub made_from: MadeFrom,
}

/// The answer for programs.
#[derive(Debug, Serialize)]
struct Answer {
    log: String,
    source: String,
    same: bool,
    ticks: u64,
    /// The first difference: since the log's start, what, both values.
    at_tick: Option<u64>,
    at_s: Option<f64>,
    what: Option<&'static str>,
    recorded: Option<String>,
    here: Option<String>,
}

pub fn run(args: &Args) -> Result<i32, UserError> {
    let mut log = LogReader::open(&args.log)?;
    let progress = ProgressLine::new("ticks", log.ticks(), args.quiet);
    let done = replay(&mut log, &progress);
    progress.finish();
    let Replayed { ticks, difference } = done?;
    let at_s = |tick: u64| tick as f64 * TICK_US as f64 * 1e-6;
    let same = difference.is_none();
    let answer = Answer {
        log: args.log.display().to_string(),
        source: log.header().source.clone(),
        same,
        ticks,
        at_tick: difference.as_ref().map(|d| d.tick),
        at_s: difference.as_ref().map(|d| at_s(d.tick)),
        what: difference.as_ref().map(|d| d.what),
        recorded: difference.as_ref().map(|d| d.recorded.clone()),
        here: difference.as_ref().map(|d| d.here.clone()),
    };
    let made = Some(&args.made_from);
    emit(
        args.format,
        made,
        &answer,
        &[&answer],
        || match &difference {
            None => format!("same decisions over {ticks} ticks ({:.3} s)\n", at_s(ticks)),
            Some(d) => format!(
                "first difference at tick {} ({:.5} s): {} was {}, is {} here\n",
                d.tick,
                at_s(d.tick),
                d.what,
                d.recorded,
                d.here
            ),
        },
    )?;
    Ok(i32::from(!same))
}
