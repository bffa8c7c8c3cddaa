//! Logs of an emulated run, written while it runs.

use std::path::{Path, PathBuf};

use shared::control::Controller;
use shared::fault::{Persisted, Record};
use shared::settings::Settings;

use super::{Block, Header, Input, Samples, Tick, Truth, Writer, mcap};
use crate::local::birth;
use crate::record::{BlockRow, Contact, Event, EventKind, Observer, TickRow};
use crate::under_test::Reset;
use files::UserError;

/// Watches a run and writes `NAME.parquet` and `NAME.mcap`. Dropped before [`finish`](Self::finish), it leaves
/// nothing.
pub struct Logs {
    parquet: Writer,
    mcap: mcap::Writer,
    truths: Vec<Truth>,
    inputs: Vec<Input>,
    born: bool,
    record: Option<Record>,
    failed: Option<UserError>,
}

impl Logs {
    /// Begins both logs in `dir`.
    ///
    /// # Errors
    /// A file cannot be written there.
    pub fn create(dir: &Path, name: &str, header: &Header) -> Result<Self, UserError> {
        Ok(Self {
            parquet: Writer::create(dir.join(format!("{name}.parquet")), header)?,
            mcap: mcap::Writer::create(dir.join(format!("{name}.mcap")), header)?,
            truths: Vec::new(),
            inputs: Vec::new(),
            born: false,
            record: None,
            failed: None,
        })
    }

    /// Closes both logs and gives them their names; returns where they are.
    ///
    /// # Errors
    /// A write failed, during the run or now; nothing is left then.
    pub fn finish(self) -> Result<[PathBuf; 2], UserError> {
        if let Some(error) = self.failed {
            return Err(error);
        }
        // Both are whole before the first gets its name.
        let (parquet, mcap) = (self.parquet.close()?, self.mcap.close()?);
        Ok([parquet.commit()?, mcap.commit()?])
    }

    /// A run goes on without its log when the disk refuses; [`finish`](Self::finish) says so.
    fn note(&mut self, done: Result<(), UserError>) {
        if let Err(error) = done {
            self.failed.get_or_insert(error);
        }
    }
}

impl Observer for Logs {
    fn born(&mut self, _tick: u64, reset: Reset, settings: &Settings) {
        // The first birth stands in the header.
        if self.born {
            let kept = self
                .record
                .as_ref()
                .map_or(Persisted::EMPTY, Persisted::new);
            let birth = birth(reset, &kept);
            self.inputs.push(Input::Born(*settings, birth));
            // For the case that the next reset comes before the next block.
            let newborn = Controller::new(settings, &birth);
            self.record = newborn.ok().and_then(|c| c.persisted().record());
        }
        self.born = true;
    }

    fn tick(&mut self, row: &TickRow) {
        self.truths.push(Truth {
            force_n: row.true_force_n,
            hammer_m: row.hammer_m,
            cart_m: row.cart_m,
        });
    }

    fn block(&mut self, row: &BlockRow) {
        let mut inputs = std::mem::take(&mut self.inputs);
        inputs.extend(row.commands.iter().map(|g| Input::Command(g.command)));
        if row.overrun {
            inputs.push(Input::Overrun);
        }
        let truths = self.truths.drain(..).map(Some);
        let truths = truths.chain(std::iter::repeat(None));
        let ticks = row.frames.iter().zip(row.outputs).zip(truths);
        let ticks = ticks.map(|((frame, output), truth)| Tick {
            frame: *frame,
            output: *output,
            truth,
        });
        let block = Block {
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
        self.record = row.status.fault;
        if self.failed.is_some() {
            return;
        }
        let done = self.parquet.block(&block);
        let done = done.and_then(|()| self.mcap.block(&block));
        self.note(done);
    }

    fn contact(&mut self, contact: &Contact) {
        let done = self.mcap.contact(contact);
        self.note(done);
    }

    fn event(&mut self, event: &Event) {
        let at_s = event.time_s;
        let mut done = self.mcap.event(at_s, &event.what.to_string());
        if let EventKind::Fault {
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
