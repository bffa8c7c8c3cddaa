//! Writing a log, block by block, in bounded memory.

use std::fmt::Display;
use std::io::Write;
use std::path::{Path, PathBuf};

use shared::settings::TICK_RATE_HZ;

use super::columns::{Col, FORMAT, VERSION, fields};
use super::status::STATUS;
use super::{Header, LogBlock, LogTick, StatusCell, TICK_US, cells};
use crate::names::state_name;
use files::UserError;
use files::columns::{self, Column, ColumnValue, PROGRAM};
#[cfg(feature = "disk")]
use files::write::Staged;

/// Rows of a row group: ten seconds. Held in memory until they are written.
const GROUP_ROWS: usize = 200_000;

/// Writes a log into a file. Dropped before `finish`, it leaves nothing.
#[cfg(feature = "disk")]
pub type LogWriter = WriterTo<Staged>;

/// Writes a log into anything that takes bytes.
pub struct WriterTo<W: Write + Send> {
    file: columns::ParquetWriter<W>,
    target: PathBuf,
    columns: Vec<Column>,
    rows: usize,
    next: i64,
}

#[cfg(feature = "disk")]
impl LogWriter {
    /// Begins the log `path`; an older one stays until this one is whole.
    ///
    /// # Errors
    /// The file cannot be written there.
    pub fn create(path: impl AsRef<Path>, header: &Header) -> Result<Self, UserError> {
        let staged = Staged::new(path)?;
        let target = staged.path().to_owned();
        Self::over(staged, target, header)
    }

    /// Closes the log and gives it its name; returns where it is.
    ///
    /// # Errors
    /// The disk refuses; nothing is left then.
    pub fn finish(self) -> Result<PathBuf, UserError> {
        Ok(self.close()?.commit()?)
    }
}

impl<W: Write + Send> WriterTo<W> {
    /// Begins a log in `sink`, which errors call `target`.
    ///
    /// # Errors
    /// The sink takes nothing.
    pub fn over(sink: W, target: PathBuf, header: &Header) -> Result<Self, UserError> {
        let fields = fields(VERSION);
        let file = columns::ParquetWriter::new(sink, "run", &fields, metadata(header)?);
        Ok(Self {
            file: file.map_err(|e| failed(&target, e))?,
            target,
            columns: fields.iter().map(Column::new).collect(),
            rows: 0,
            next: 0,
        })
    }

    /// Appends a block; the ticks follow on those of the block before.
    ///
    /// # Errors
    /// The disk refuses, or the block has no ticks.
    pub fn block(&mut self, block: &LogBlock) -> Result<(), UserError> {
        if block.ticks.is_empty() {
            return Err(UserError::new("a block without ticks cannot be logged"));
        }
        let cells = block.status.as_ref().map(cells);
        let state = match (&block.status, block.state) {
            (Some(status), _) => Some(state_name(status.state)),
            (None, state) => state.map(state_name),
        };
        for tick in &block.ticks {
            self.tick(tick, state);
        }
        self.block_columns(block, cells.as_ref())?;
        if self.rows >= GROUP_ROWS {
            self.flush()?;
        }
        Ok(())
    }

    /// Ticks written so far.
    pub fn ticks(&self) -> u64 {
        self.next as u64
    }

    /// Writes what is left; the sink has the whole log then. (A file still has its temporary name.)
    ///
    /// # Errors
    /// The sink takes nothing more.
    pub fn close(mut self) -> Result<W, UserError> {
        self.flush()?;
        let target = self.target;
        self.file.finish().map_err(|e| failed(&target, e))
    }

    fn push(&mut self, col: Col, value: Option<ColumnValue>) {
        let pushed = self.columns[col as usize].push(value);
        pushed.expect("a value of the column's kind");
    }

    fn tick(&mut self, tick: &LogTick, state: Option<&str>) {
        let (frame, output) = (tick.frame, tick.output);
        let code = |code: u16| Some(ColumnValue::Int(i32::from(code)));
        self.push(Col::Tick, Some(ColumnValue::Long(self.next)));
        self.push(Col::TimeUs, Some(ColumnValue::Long(self.next * TICK_US)));
        self.push(Col::Force, code(frame.force.0));
        self.push(Col::Hammer, code(frame.hammer.0));
        self.push(Col::Cart, code(frame.cart.0));
        self.push(Col::Emergency, Some(ColumnValue::Flag(frame.emergency)));
        self.push(Col::Dac, code(output.dac.0));
        self.push(
            Col::FrequencySet,
            Some(ColumnValue::Float(output.frequency_hz)),
        );
        self.push(Col::Enable, Some(ColumnValue::Flag(output.enable)));
        let truth = |value: fn(&super::Truth) -> f64| {
            tick.truth
                .as_ref()
                .map(|t| ColumnValue::Float(value(t) as f32))
        };
        self.push(Col::TrueForce, truth(|t| t.force_n));
        self.push(Col::TrueHammer, truth(|t| t.hammer_m * 1e3));
        self.push(Col::TrueCart, truth(|t| t.cart_m * 1e3));
        self.push(Col::State, state.map(ColumnValue::Text));
        self.next += 1;
        self.rows += 1;
    }

    /// The columns that have a value at the block's first tick alone.
    fn block_columns(
        &mut self,
        block: &LogBlock,
        cells: Option<&[StatusCell; STATUS.len()]>,
    ) -> Result<(), UserError> {
        let int = |n: usize| ColumnValue::Int(i32::try_from(n).unwrap_or(i32::MAX));
        let (text, packed) = if block.inputs.is_empty() {
            (None, None)
        } else {
            let text = format!("{:?}", block.inputs);
            (Some(text), Some(to_postcard(&block.inputs)?))
        };
        self.push(Col::BlockTicks, Some(int(block.ticks.len())));
        self.push(Col::Slices, block.slices.map(|n| int(n as usize)));
        self.push(Col::Samples, Some(ColumnValue::Text(block.samples.name())));
        self.push(Col::Forecast, block.forecast.map(ColumnValue::Flag));
        self.push(Col::Inputs, text.as_deref().map(ColumnValue::Text));
        self.push(
            Col::InputsPostcard,
            packed.as_deref().map(ColumnValue::Bytes),
        );
        for (i, col) in STATUS.into_iter().enumerate().skip(1) {
            self.push(col, cells.and_then(|cells| value(&cells[i])));
        }
        for column in &mut self.columns[Col::BlockTicks as usize..] {
            let absent = column.absent(block.ticks.len() - 1);
            absent.expect("what stands once a block may be absent");
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), UserError> {
        if self.rows == 0 {
            return Ok(());
        }
        let written = self.file.group(&self.columns);
        written.map_err(|e| failed(&self.target, e))?;
        self.columns.iter_mut().for_each(Column::clear);
        self.rows = 0;
        Ok(())
    }
}

fn value(cell: &StatusCell) -> Option<ColumnValue<'_>> {
    match cell {
        StatusCell::Null => None,
        StatusCell::Int(value) => Some(ColumnValue::Long(*value)),
        StatusCell::Float(value) => Some(ColumnValue::Float(*value)),
        StatusCell::Text(text) => Some(ColumnValue::Text(text)),
    }
}

/// The log `path` could not be written.
pub(super) fn failed(path: &Path, why: impl Display) -> UserError {
    UserError::new(format!(
        "cannot write {}: {why}; check the path and the free space and try again",
        path.display()
    ))
}

fn to_postcard<T: serde::Serialize + ?Sized>(what: &T) -> Result<Vec<u8>, UserError> {
    postcard::to_stdvec(what).map_err(|e| UserError::new(format!("cannot pack for the log: {e}")))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The header as the file's key-value metadata: exact as postcard in hexadecimal, and as JSON to read.
fn metadata(header: &Header) -> Result<Vec<(String, String)>, UserError> {
    let settings = serde_json::to_string(&header.settings)
        .map_err(|e| UserError::new(format!("cannot write the settings as JSON: {e}")))?;
    let mut pairs = vec![
        ("format", format!("{FORMAT}{VERSION}")),
        ("program", PROGRAM.to_owned()),
        ("source", header.source.clone()),
        ("tick_rate_hz", TICK_RATE_HZ.to_string()),
        ("block_ticks", header.block_ticks.to_string()),
        ("settings", settings),
        ("settings_postcard", hex(&to_postcard(&header.settings)?)),
        ("birth_postcard", hex(&to_postcard(&header.birth)?)),
    ];
    if let Some(scenario) = &header.scenario {
        pairs.push(("scenario", scenario.clone()));
    }
    if let Some(made) = &header.made_from {
        pairs.push((files::made_from::KEY, made.clone()));
    }
    let pairs = pairs
        .into_iter()
        .map(|(key, value)| (key.to_owned(), value));
    Ok(pairs.collect())
}
