//! Reading a log back, block by block.

use std::borrow::Cow;
use std::collections::HashMap;
use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::reader::{FileReader, SerializedFileReader};
use serde::de::DeserializeOwned;
use shared::io::{AdcCode, DacCode, Frame, Output};

use super::columns::{COLUMNS, Col, Column, Values};
use super::status::STATUS;
use super::writer::FORMAT;
use super::{Cell, Header, Input, Samples, Tick, Truth};
use files::UserError;

/// A block as it was logged.
#[derive(Clone, Debug, PartialEq)]
pub struct Logged {
    /// The index of its first tick since the log's start.
    pub first_tick: u64,
    /// Told before the block, in order.
    pub inputs: Vec<Input>,
    /// How the samples came to the controller.
    pub samples: Samples,
    /// Whether a finished forecast was delivered just before the block, if that was recorded.
    pub forecast: Option<bool>,
    /// Slices of forecast after the block, if they were counted.
    pub slices: Option<u32>,
    /// The ticks.
    pub ticks: Vec<Tick>,
    /// The state after the block, if it was known.
    pub state: Option<String>,
    /// The cells of the status after the block, in the order of [`super::names`], if it was known.
    pub status: Option<Vec<Cell>>,
}

/// Reads a log.
pub struct Reader {
    path: PathBuf,
    file: SerializedFileReader<File>,
    header: Header,
    group: usize,
    rows: Option<Rows>,
    ticks: u64,
}

impl Reader {
    /// Opens the log `path`.
    ///
    /// # Errors
    /// One line: the file cannot be read, is cut short, or is no log.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, UserError> {
        let path = path.as_ref();
        let file = File::open(path).map_err(|e| {
            UserError::new(format!(
                "cannot read {}: {e}; check the path",
                path.display()
            ))
        })?;
        let file = guard(|| SerializedFileReader::new(file)).map_err(|e| broken(path, &e))?;
        let header = header(path, &file)?;
        let columns = file.metadata().file_metadata().schema_descr().columns();
        let fits = columns.len() == COLUMNS.len()
            && columns
                .iter()
                .zip(COLUMNS)
                .all(|(column, spec)| column.name() == spec.name);
        if !fits {
            return Err(foreign(path, "its columns are not those of a log"));
        }
        let ticks = file.metadata().file_metadata().num_rows();
        Ok(Self {
            path: path.to_owned(),
            file,
            header,
            group: 0,
            rows: None,
            ticks: u64::try_from(ticks).unwrap_or(0),
        })
    }

    /// What the log says of its making.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Ticks in the log.
    pub fn ticks(&self) -> u64 {
        self.ticks
    }

    /// The next block; none at the end.
    ///
    /// # Errors
    /// One line when the file is damaged.
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
            if self.group >= self.file.num_row_groups() {
                return Ok(None);
            }
            let (file, group) = (&self.file, self.group);
            let rows = guard(|| Rows::read(file, group)).map_err(|e| broken(&self.path, &e))?;
            self.rows = Some(rows);
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
        let there = match self.column.levels.get(self.row) {
            Some(level) => *level > 0,
            None => self.column.levels.is_empty(),
        };
        self.row += 1;
        let at = self.value;
        self.value += usize::from(there);
        there.then_some(at)
    }
}

impl Rows {
    fn read(file: &SerializedFileReader<File>, group: usize) -> ParquetResult<Self> {
        let reader = file.get_row_group(group)?;
        let count = usize::try_from(reader.metadata().num_rows())
            .map_err(|_| ParquetError::General("a negative number of rows".into()))?;
        let mut columns = Vec::with_capacity(COLUMNS.len());
        for (i, spec) in COLUMNS.iter().enumerate() {
            let mut column = Column::new(spec);
            column.read(reader.get_column_reader(i)?, count)?;
            columns.push(Cursor {
                column,
                row: 0,
                value: 0,
            });
        }
        Ok(Self {
            columns,
            count,
            at: 0,
        })
    }

    fn flag(&mut self, col: Col) -> Option<bool> {
        let cursor = &mut self.columns[col as usize];
        let at = cursor.step()?;
        match &cursor.column.values {
            Values::Flag(all) => all.get(at).copied(),
            _ => None,
        }
    }

    fn int(&mut self, col: Col) -> Option<i64> {
        let cursor = &mut self.columns[col as usize];
        let at = cursor.step()?;
        match &cursor.column.values {
            Values::Int(all) => all.get(at).map(|v| i64::from(*v)),
            Values::Long(all) => all.get(at).copied(),
            _ => None,
        }
    }

    fn float(&mut self, col: Col) -> Option<f32> {
        let cursor = &mut self.columns[col as usize];
        let at = cursor.step()?;
        match &cursor.column.values {
            Values::Float(all) => all.get(at).copied(),
            _ => None,
        }
    }

    fn bytes(&mut self, col: Col) -> Option<Vec<u8>> {
        let cursor = &mut self.columns[col as usize];
        let at = cursor.step()?;
        match &cursor.column.values {
            Values::Bytes(all) => all.get(at).map(|v| v.data().to_vec()),
            _ => None,
        }
    }

    fn cell(&mut self, col: Col) -> Cell {
        let cursor = &mut self.columns[col as usize];
        let Some(at) = cursor.step() else {
            return Cell::Null;
        };
        let cell = match &cursor.column.values {
            Values::Flag(_) => None,
            Values::Int(all) => all.get(at).map(|v| Cell::Int(i64::from(*v))),
            Values::Long(all) => all.get(at).map(|v| Cell::Int(*v)),
            Values::Float(all) => all.get(at).map(|v| Cell::Float(*v)),
            Values::Bytes(all) => all.get(at).map(|v| {
                let text = String::from_utf8_lossy(v.data()).into_owned();
                Cell::Text(Cow::Owned(text))
            }),
        };
        cell.unwrap_or(Cell::Null)
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
        let rest: Vec<_> = STATUS[1..].iter().map(|col| self.cell(*col)).collect();
        let per_block = (Col::BlockTicks as usize)..=(Col::Overruns as usize);
        for cursor in &mut self.columns[per_block] {
            // Within the block these columns must be empty.
            for _ in 1..length {
                if cursor.step().is_some() {
                    return None;
                }
            }
        }
        let mut state = Cell::Null;
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
            Cell::Text(name) => Some(name.to_string()),
            _ => None,
        };
        // A status has a tick; a recording may know the state alone.
        let status = (rest.first() != Some(&Cell::Null))
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

    fn tick(&mut self) -> Option<Tick> {
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
        Some(Tick {
            frame,
            output,
            truth,
        })
    }
}

/// Reading what may be damaged: a panic of the library is one more way to say so.
fn guard<T>(read: impl FnOnce() -> ParquetResult<T>) -> ParquetResult<T> {
    catch_unwind(AssertUnwindSafe(read))
        .unwrap_or_else(|_| Err(ParquetError::General("its pages are damaged".into())))
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

fn header(path: &Path, file: &SerializedFileReader<File>) -> Result<Header, UserError> {
    let metadata = file.metadata().file_metadata().key_value_metadata();
    let pairs: HashMap<&str, &str> = metadata
        .into_iter()
        .flatten()
        .filter_map(|pair| Some((pair.key.as_str(), pair.value.as_deref()?)))
        .collect();
    match pairs.get("format") {
        Some(format) if *format == FORMAT => {}
        Some(format) if format.starts_with("vibro-impact run ") => {
            return Err(UserError::new(format!(
                "{} is a log of another version ({format}, this program reads {FORMAT}); record or emulate it again",
                path.display()
            )));
        }
        _ => return Err(foreign(path, "it does not say so")),
    }
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
