//! Reading a log back, block by block.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use shared::io::{AdcCode, DacCode, Frame, Output};

use super::columns::{CHECKED, Col, FORMAT, VERSION, fields};
use super::status::STATUS;
use super::{Header, LogInput, LogTick, Samples, StatusCell, Truth};
use files::columns::{self, Column, ColumnField, ColumnValues};
use files::{UserError, open_file};

/// A block as it was logged.
#[derive(Clone, Debug, PartialEq)]
pub struct Logged {
    /// The index of its first tick since the log's start.
    pub first_tick: u64,
    /// Inputs before the block, in order.
    pub inputs: Vec<LogInput>,
    /// How the samples came to the controller.
    pub samples: Samples,
    /// Whether a finished forecast was delivered just before the block, if that was recorded.
    pub forecast: Option<bool>,
    /// Slices of forecast after the block, if they were counted.
    pub slices: Option<u32>,
    /// The block's ticks in order.
    pub ticks: Vec<LogTick>,
    /// The state after the block, if it was known.
    pub state: Option<String>,
    /// The cells of the status after the block, in the order of [`super::names`], if it was known: those that the log's
    /// version has.
    pub status: Option<Vec<StatusCell>>,
}

/// Reads a run's Parquet log from its beginning, one block at a time.
pub struct LogReader {
    path: PathBuf,
    file: columns::ParquetReader,
    fields: Vec<ColumnField>,
    header: Header,
    group: usize,
    rows: Option<Rows>,
}

impl LogReader {
    /// Opens the log `path`.
    ///
    /// # Errors
    /// The file cannot be read, is cut short, is no log, or a log of a version that this program does not read.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, UserError> {
        let path = path.as_ref();
        let file = columns::ParquetReader::open(open_file(path)?).map_err(|e| broken(path, &e))?;
        let pairs: HashMap<&str, &str> = file.pairs().collect();
        let version = version(path, &pairs)?;
        if version >= CHECKED && !file.is_checked() {
            return Err(broken(path, &"its check sums are missing"));
        }
        let fields = fields(version);
        let header = header(path, &pairs)?;
        if !file.has(&fields) {
            return Err(foreign(path, "its columns are not those of a log"));
        }
        Ok(Self {
            path: path.to_owned(),
            file,
            fields,
            header,
            group: 0,
            rows: None,
        })
    }

    /// How the log was made.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Ticks in the log.
    pub fn ticks(&self) -> u64 {
        self.file.rows()
    }

    /// The next block; none at the end.
    ///
    /// # Errors
    /// The file is damaged.
    pub fn block(&mut self) -> Result<Option<Logged>, UserError> {
        loop {
            if let Some(rows) = &mut self.rows
                && rows.at < rows.count
            {
                let path = &self.path;
                return match rows.block() {
                    Some(block) => Ok(Some(block)),
                    None => Err(broken(path, &"its blocks do not fit its ticks")),
                };
            }
            if self.group >= self.file.groups() {
                return Ok(None);
            }
            let columns = self.file.group(self.group, &self.fields);
            let columns = columns.map_err(|e| {
                let (before, rows) = self.file.rows_of(self.group);
                let (part, parts) = (self.group + 1, self.file.groups());
                let last = (before + rows).saturating_sub(1);
                let place = format!("part {part} of {parts}, ticks {before} to {last}: {e}");
                broken(&self.path, &place)
            })?;
            self.rows = Some(Rows::new(columns));
            self.group += 1;
        }
    }
}

/// A row group in memory, and how far it has been read.
struct Rows {
    columns: Vec<Cursor>,
    count: usize,
    at: usize,
}

/// A column and the position of its next value.
struct Cursor {
    column: Column,
    row: usize,
    value: usize,
}

impl Cursor {
    /// The position of this row's value, if it has one; steps to the next row.
    fn step(&mut self) -> Option<usize> {
        let there = self.column.has(self.row);
        self.row += 1;
        let at = self.value;
        self.value += usize::from(there);
        there.then_some(at)
    }
}

impl Rows {
    fn new(columns: Vec<Column>) -> Self {
        let count = columns.first().map_or(0, Column::rows);
        let cursor = |column| Cursor {
            column,
            row: 0,
            value: 0,
        };
        Self {
            columns: columns.into_iter().map(cursor).collect(),
            count,
            at: 0,
        }
    }

    fn flag(&mut self, col: Col) -> Option<bool> {
        let cursor = &mut self.columns[col as usize];
        let at = cursor.step()?;
        match cursor.column.values() {
            ColumnValues::Flag(all) => all.get(at).copied(),
            _ => None,
        }
    }

    fn int(&mut self, col: Col) -> Option<i64> {
        match self.cell(col) {
            StatusCell::Int(value) => Some(value),
            _ => None,
        }
    }

    fn float(&mut self, col: Col) -> Option<f32> {
        match self.cell(col) {
            StatusCell::Float(value) => Some(value),
            _ => None,
        }
    }

    fn bytes(&mut self, col: Col) -> Option<Vec<u8>> {
        let cursor = &mut self.columns[col as usize];
        let at = cursor.step()?;
        match cursor.column.values() {
            ColumnValues::Bytes(all) => all.get(at).map(|v| v.data().to_vec()),
            _ => None,
        }
    }

    fn cell(&mut self, col: Col) -> StatusCell {
        let cursor = &mut self.columns[col as usize];
        let Some(at) = cursor.step() else {
            return StatusCell::Null;
        };
        let cell = match cursor.column.values() {
            ColumnValues::Flag(_) => None,
            ColumnValues::Int(all) => all.get(at).map(|v| StatusCell::Int(i64::from(*v))),
            ColumnValues::Long(all) => all.get(at).map(|v| StatusCell::Int(*v)),
            ColumnValues::Float(all) => all.get(at).map(|v| StatusCell::Float(*v)),
            ColumnValues::Bytes(all) => all.get(at).map(|v| {
                let text = String::from_utf8_lossy(v.data()).into_owned();
                StatusCell::Text(Cow::Owned(text))
            }),
        };
        cell.unwrap_or(StatusCell::Null)
    }

    /// The block that begins at this row.
    fn block(&mut self) -> Option<Logged> {
        let length = usize::try_from(self.int(Col::BlockTicks)?).ok()?;
        if length == 0 || length > self.count - self.at {
            return None;
        }
        let slices = self.int(Col::Slices).and_then(|n| u32::try_from(n).ok());
        let samples = Samples::from_name(&self.bytes(Col::Samples)?)?;
        let forecast = self.flag(Col::Forecast);
        let _text = self.bytes(Col::Inputs);
        let inputs = match self.bytes(Col::InputsPostcard) {
            Some(bytes) => postcard::from_bytes(&bytes).ok()?,
            None => Vec::new(),
        };
        let there = self.columns.len();
        let known = STATUS[1..].iter().filter(|col| (**col as usize) < there);
        let rest: Vec<_> = known.map(|col| self.cell(*col)).collect();
        for cursor in &mut self.columns[Col::BlockTicks as usize..] {
            // Within the block these columns must be empty.
            for _ in 1..length {
                if cursor.step().is_some() {
                    return None;
                }
            }
        }
        let mut state = StatusCell::Null;
        let mut first_tick = 0;
        let mut ticks = Vec::with_capacity(length);
        for i in 0..length {
            let number = u64::try_from(self.int(Col::Tick)?).ok()?;
            if i == 0 {
                first_tick = number;
            }
            ticks.push(self.tick()?);
            state = self.cell(Col::State);
        }
        self.at += length;
        let name = match &state {
            StatusCell::Text(name) => Some(name.to_string()),
            _ => None,
        };
        // A status has a tick; a recording may know the state alone.
        let status = (rest.first() != Some(&StatusCell::Null))
            .then(|| std::iter::once(state).chain(rest).collect());
        Some(Logged {
            first_tick,
            inputs,
            samples,
            forecast,
            slices,
            ticks,
            state: name,
            status,
        })
    }

    fn tick(&mut self) -> Option<LogTick> {
        let code = |value: Option<i64>| u16::try_from(value?).ok();
        let _time = self.int(Col::TimeUs)?;
        let frame = Frame {
            force: AdcCode(code(self.int(Col::Force))?),
            hammer: AdcCode(code(self.int(Col::Hammer))?),
            cart: AdcCode(code(self.int(Col::Cart))?),
            emergency: self.flag(Col::Emergency)?,
        };
        let output = Output {
            dac: DacCode(code(self.int(Col::Dac))?),
            frequency_hz: self.float(Col::FrequencySet)?,
            enable: self.flag(Col::Enable)?,
        };
        let truth = [Col::TrueForce, Col::TrueHammer, Col::TrueCart].map(|col| self.float(col));
        let truth = match truth {
            [Some(force), Some(hammer), Some(cart)] => Some(Truth {
                force_n: f64::from(force),
                hammer_m: f64::from(hammer) * 1e-3,
                cart_m: f64::from(cart) * 1e-3,
            }),
            _ => None,
        };
        Some(LogTick {
            frame,
            output,
            truth,
        })
    }
}

fn broken(path: &Path, why: &dyn std::fmt::Display) -> UserError {
    UserError::new(format!(
        "{} cannot be read as a log ({why}); it may be cut short or of another program: record or emulate it again",
        path.display()
    ))
}

fn foreign(path: &Path, why: &str) -> UserError {
    UserError::new(format!(
        "{} is no log of this program ({why}); give a .parquet file that `host-sim emulate` or a recording wrote",
        path.display()
    ))
}

/// The version of the log's columns, if this program reads it.
fn version(path: &Path, pairs: &HashMap<&str, &str>) -> Result<u32, UserError> {
    let format = pairs.get("format").copied();
    let number = format.and_then(|format| format.strip_prefix(FORMAT));
    let Some(number) = number else {
        return Err(foreign(
            path,
            "it does not say so; if it was one, it is damaged: record it again",
        ));
    };
    match number.parse() {
        Ok(version @ 1..=VERSION) => Ok(version),
        _ => Err(UserError::new(format!(
            "{} is a log of version {number}, written by {}; this program reads versions 1 to {VERSION}: use that program, or record or emulate it again",
            path.display(),
            pairs.get("program").unwrap_or(&"another program")
        ))),
    }
}

fn header(path: &Path, pairs: &HashMap<&str, &str>) -> Result<Header, UserError> {
    let key = |key: &str| {
        let value = pairs.get(key).copied();
        value.ok_or_else(|| foreign(path, &format!("`{key}` is missing")))
    };
    let bytes = |name: &str| {
        unhex(key(name)?).ok_or_else(|| foreign(path, &format!("`{name}` is damaged")))
    };
    let older = |what| foreign(path, &format!("its {what} are of another version"));
    let settings = unpack(&bytes("settings_postcard")?).ok_or_else(|| older("settings"))?;
    let birth = unpack(&bytes("birth_postcard")?).ok_or_else(|| older("first conditions"))?;
    let block_ticks = key("block_ticks")?.parse();
    Ok(Header {
        source: key("source")?.to_owned(),
        settings,
        birth,
        block_ticks: block_ticks.map_err(|_| foreign(path, "`block_ticks` is damaged"))?,
        scenario: pairs.get("scenario").map(|text| (*text).to_owned()),
        made_from: pairs
            .get(files::made_from::KEY)
            .map(|text| (*text).to_owned()),
    })
}

fn unpack<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    match postcard::take_from_bytes(bytes) {
        Ok((value, [])) => Some(value),
        _ => None,
    }
}

fn unhex(text: &str) -> Option<Vec<u8>> {
    let digits: Option<Vec<u8>> = text
        .chars()
        .map(|c| u8::try_from(c.to_digit(16)?).ok())
        .collect();
    let pairs = digits?;
    let whole = pairs.len().is_multiple_of(2);
    whole.then(|| pairs.chunks(2).map(|p| p[0] << 4 | p[1]).collect())
}
