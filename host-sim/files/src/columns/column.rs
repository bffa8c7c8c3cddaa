//! The values of a column.

use parquet::column::reader::ColumnReader;
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::{ParquetError, Result};

use super::{ColumnField, ColumnKind};

/// Values of one kind, without the rows that lack one.
#[derive(Clone, Debug, PartialEq)]
pub enum ColumnValues {
    /// Values of a [`ColumnKind::Flag`] column.
    Flag(Vec<bool>),
    /// Values of a [`ColumnKind::Int`] column.
    Int(Vec<i32>),
    /// Values of a [`ColumnKind::Long`] column.
    Long(Vec<i64>),
    /// Values of a [`ColumnKind::Float`] column.
    Float(Vec<f32>),
    /// Values of a [`ColumnKind::Text`] or [`ColumnKind::Bytes`] column; text is UTF-8.
    Bytes(Vec<ByteArray>),
}

/// Does the same with the vector of whatever kind.
macro_rules! each {
    ($values:expr, $all:ident => $done:expr) => {
        match $values {
            ColumnValues::Flag($all) => $done,
            ColumnValues::Int($all) => $done,
            ColumnValues::Long($all) => $done,
            ColumnValues::Float($all) => $done,
            ColumnValues::Bytes($all) => $done,
        }
    };
}

impl ColumnValues {
    fn new(kind: ColumnKind) -> Self {
        match kind {
            ColumnKind::Flag => Self::Flag(Vec::new()),
            ColumnKind::Int => Self::Int(Vec::new()),
            ColumnKind::Long => Self::Long(Vec::new()),
            ColumnKind::Float => Self::Float(Vec::new()),
            ColumnKind::Text | ColumnKind::Bytes => Self::Bytes(Vec::new()),
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        each!(self, all => all.len())
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A value on its way into a column.
#[derive(Clone, Copy, Debug)]
pub enum ColumnValue<'a> {
    /// A value of a [`ColumnKind::Flag`] column.
    Flag(bool),
    /// A value of a [`ColumnKind::Int`] column.
    Int(i32),
    /// A value of a [`ColumnKind::Long`] column.
    Long(i64),
    /// A value of a [`ColumnKind::Float`] column.
    Float(f32),
    /// A value of a [`ColumnKind::Text`] column.
    Text(&'a str),
    /// A value of a [`ColumnKind::Bytes`] column.
    Bytes(&'a [u8]),
}

/// A value of one kind was put into a column of another, or no value into one that must have it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WrongKind;

/// A column for the rows of one row group.
#[derive(Clone, Debug)]
pub struct Column {
    kind: ColumnKind,
    optional: bool,
    values: ColumnValues,
    /// 1 for each row that has a value, 0 for each that lacks it.
    present: Vec<i16>,
}

impl Column {
    /// A column of `field` without rows.
    pub fn new(field: &ColumnField) -> Self {
        Self {
            kind: field.kind,
            optional: field.optional,
            values: ColumnValues::new(field.kind),
            present: Vec::new(),
        }
    }

    /// Kind of the column's values.
    pub fn kind(&self) -> ColumnKind {
        self.kind
    }

    /// Whether a row may lack a value.
    pub fn optional(&self) -> bool {
        self.optional
    }

    /// The values, without the rows that lack one.
    pub fn values(&self) -> &ColumnValues {
        &self.values
    }

    /// How many rows it has.
    pub fn rows(&self) -> usize {
        self.present.len()
    }

    /// Whether the row has a value; no row has one beyond the last.
    pub fn has(&self, row: usize) -> bool {
        self.present.get(row).is_some_and(|level| *level > 0)
    }

    /// Appends a row.
    ///
    /// # Errors
    /// The value is of another kind, or absent where there must be one; nothing is appended then.
    pub fn push(&mut self, value: Option<ColumnValue>) -> std::result::Result<(), WrongKind> {
        let Some(value) = value else {
            return self.absent(1);
        };
        let text = self.kind == ColumnKind::Text;
        match (&mut self.values, value) {
            (ColumnValues::Flag(all), ColumnValue::Flag(one)) => all.push(one),
            (ColumnValues::Int(all), ColumnValue::Int(one)) => all.push(one),
            (ColumnValues::Long(all), ColumnValue::Long(one)) => all.push(one),
            (ColumnValues::Float(all), ColumnValue::Float(one)) => all.push(one),
            (ColumnValues::Bytes(all), ColumnValue::Text(one)) if text => {
                push_bytes(all, one.as_bytes());
            }
            (ColumnValues::Bytes(all), ColumnValue::Bytes(one)) if !text => push_bytes(all, one),
            _ => return Err(WrongKind),
        }
        self.present.push(1);
        Ok(())
    }

    /// Appends `rows` rows without a value.
    ///
    /// # Errors
    /// Every row must have one.
    pub fn absent(&mut self, rows: usize) -> std::result::Result<(), WrongKind> {
        if !self.optional && rows > 0 {
            return Err(WrongKind);
        }
        self.present.resize(self.present.len() + rows, 0);
        Ok(())
    }

    /// Removes all rows, so that those of the next row group can be put in.
    pub fn clear(&mut self) {
        self.present.clear();
        each!(&mut self.values, all => all.clear());
    }

    pub(super) fn write(&self, writer: &mut ColumnWriter) -> Result<()> {
        use ColumnWriter as W;
        let levels = self.optional.then_some(self.present.as_slice());
        match (writer, &self.values) {
            (W::BoolColumnWriter(w), ColumnValues::Flag(all)) => w.write_batch(all, levels, None),
            (W::Int32ColumnWriter(w), ColumnValues::Int(all)) => w.write_batch(all, levels, None),
            (W::Int64ColumnWriter(w), ColumnValues::Long(all)) => w.write_batch(all, levels, None),
            (W::FloatColumnWriter(w), ColumnValues::Float(all)) => w.write_batch(all, levels, None),
            (W::ByteArrayColumnWriter(w), ColumnValues::Bytes(all)) => {
                w.write_batch(all, levels, None)
            }
            _ => return Err(ParquetError::General("a column of another kind".into())),
        }
        .map(drop)
    }

    /// Reads `rows` rows of `field`.
    pub(super) fn read(field: &ColumnField, reader: ColumnReader, rows: usize) -> Result<Self> {
        use ColumnReader as R;
        let mut column = Self::new(field);
        let levels = field.optional.then_some(&mut column.present);
        macro_rules! all {
            ($reader:ident, $values:ident) => {{
                let mut reader = $reader;
                let (records, ..) = reader.read_records(rows, levels, None, $values)?;
                records
            }};
        }
        let records = match (reader, &mut column.values) {
            (R::BoolColumnReader(r), ColumnValues::Flag(v)) => all!(r, v),
            (R::Int32ColumnReader(r), ColumnValues::Int(v)) => all!(r, v),
            (R::Int64ColumnReader(r), ColumnValues::Long(v)) => all!(r, v),
            (R::FloatColumnReader(r), ColumnValues::Float(v)) => all!(r, v),
            (R::ByteArrayColumnReader(r), ColumnValues::Bytes(v)) => all!(r, v),
            _ => return Err(ParquetError::General("a column of another kind".into())),
        };
        if !field.optional {
            column.present.resize(records, 1);
        }
        let there = column.present.iter().filter(|level| **level > 0).count();
        if records != rows || column.present.len() != rows || column.values.len() != there {
            return Err(ParquetError::General(format!(
                "column {} has {records} rows of {rows}",
                field.name
            )));
        }
        Ok(column)
    }
}

/// Text repeats from row to row: the bytes are shared with the value before.
fn push_bytes(all: &mut Vec<ByteArray>, one: &[u8]) {
    match all.last() {
        Some(last) if last.data() == one => all.push(last.clone()),
        _ => all.push(ByteArray::from(one.to_vec())),
    }
}
