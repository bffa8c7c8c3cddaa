//! Logs of an emulated run, written while it runs.

use std::path::{Path, PathBuf};

use super::{Header, LogBlock, LogInput, LogTick, LogWriter, Samples, Truth, mcap};
use crate::record::{BlockRow, Given, RunEvent, RunEventKind, RunObserver, TickRow, TrueContact};
use files::UserError;
use files::write::{Staged, commit_all};

/// Watches a run and writes `NAME.parquet` and `NAME.mcap`. Dropped before [`finish`](Self::finish), it leaves
/// nothing.
pub struct Logs {
    parquet: LogWriter,
    mcap: mcap::McapWriter,
    truths: Vec<Truth>,
    failed: Option<UserError>,
}

impl Logs {
    /// Begins both logs in `dir`.
    ///
    /// # Errors
    /// A file cannot be written there.
    pub fn create(dir: &Path, name: &str, header: &Header) -> Result<Self, UserError> {
        Ok(Self {
            parquet: LogWriter::create(dir.join(format!("{name}.parquet")), header)?,
            mcap: mcap::McapWriter::create(dir.join(format!("{name}.mcap")), header)?,
            truths: Vec::new(),
            failed: None,
        })
    }

    /// Closes both logs and gives them their names; returns where they are.
    ///
    /// # Errors
    /// A write failed, during the run or now; nothing is left then.
    pub fn finish(self) -> Result<Vec<PathBuf>, UserError> {
        Ok(commit_all(self.close()?)?.paths)
    }

    /// Closes both logs; they are whole then and have their temporary names still.
    ///
    /// # Errors
    /// As [`finish`](Self::finish).
    pub fn close(self) -> Result<Vec<Staged>, UserError> {
        match self.failed {
            Some(error) => Err(error),
            None => Ok(vec![self.parquet.close()?, self.mcap.close()?]),
        }
    }

    /// A run goes on without its log when the disk refuses; [`finish`](Self::finish) says so.
    fn note(&mut self, done: Result<(), UserError>) {
        if let Err(error) = done {
            self.failed.get_or_insert(error);
        }
    }
}

impl RunObserver for Logs {
    fn tick(&mut self, row: &TickRow) {
        self.truths.push(Truth {
            force_n: row.true_force_n,
            hammer_m: row.hammer_m,
            cart_m: row.cart_m,
        });
    }

    fn block(&mut self, row: &BlockRow) {
        let input = |given: &Given| match given {
            Given::Command { command, .. } => LogInput::Command(*command),
            Given::Born(settings, birth) => LogInput::Born(*settings, *birth),
        };
        let mut inputs: Vec<_> = row.given.iter().map(input).collect();
        if row.overrun {
            inputs.push(LogInput::Overrun);
        }
        let truths = self.truths.drain(..).map(Some);
        let truths = truths.chain(std::iter::repeat(None));
        let ticks = row.frames.iter().zip(row.outputs).zip(truths);
        let ticks = ticks.map(|((frame, output), truth)| LogTick {
            frame: *frame,
            output: *output,
            truth,
        });
        let block = LogBlock {
            inputs,
            samples: match (row.delivered, row.stale) {
                (false, _) => Samples::Lost,
                (true, true) => Samples::Blind,
                (true, false) => Samples::Came,
            },
            forecast: None,
            slices: Some(row.slices),
            ticks: ticks.collect(),
            status: Some(*row.status),
            state: None,
        };
        if self.failed.is_some() {
            return;
        }
        let done = self.parquet.block(&block);
        let done = done.and_then(|()| self.mcap.block(&block));
        self.note(done);
    }

    fn contact(&mut self, contact: &TrueContact) {
        let done = self.mcap.contact(contact);
        self.note(done);
    }

    fn event(&mut self, event: &RunEvent) {
        let at_s = event.time_s;
        let mut done = self.mcap.event(event);
        if let RunEventKind::Fault {
            fault,
            origin,
            value,
        } = event.what
        {
            done = done.and_then(|()| self.mcap.fault(at_s, fault, origin, value));
        }
        self.note(done);
    }
}
