//! Columns of values as a Parquet file: what the log of a run stands on.
//!
//! A [`ColumnField`] is the name, kind and packing of a column; a [`Column`] holds its values for the rows of one row
//! group. [`ParquetWriter`] writes row groups one after another, so a file may be larger than the memory; [`ParquetReader`] gives
//! them back and answers damage with an error, never with a panic. Every byte is under a check sum.

mod check;
mod column;
mod reader;
#[cfg(test)]
mod tests;
mod writer;

pub use column::{Column, ColumnValue, ColumnValues, WrongKind};
pub use parquet::data_type::ByteArray;
pub use parquet::errors::ParquetError as Error;
pub use reader::ParquetReader;
pub use writer::ParquetWriter;

use std::borrow::Cow;

/// The program and its version, as every file names its writer.
pub const PROGRAM: &str = concat!("host-sim ", env!("CARGO_PKG_VERSION"));

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnKind {
    /// Yes or no: Parquet's BOOLEAN.
    Flag,
    /// Integers of 32 bits: Parquet's INT32.
    Int,
    /// Integers of 64 bits: Parquet's INT64.
    Long,
    /// Numbers of single precision (f32): Parquet's FLOAT.
    Float,
    /// BYTE_ARRAY that is UTF-8.
    Text,
    /// Bytes without a meaning of their own: Parquet's BYTE_ARRAY.
    Bytes,
}

/// How the values of a column are packed, before all is compressed by snappy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Packing {
    /// By dictionary: for values that repeat.
    Dictionary,
    /// As differences: for counters and codes, integers only.
    Differences,
    /// Byte by byte: for measured numbers.
    Split,
}

/// A column of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ColumnField {
    /// Its name, with the unit.
    pub name: Cow<'static, str>,
    /// Kind of its values.
    pub kind: ColumnKind,
    /// Whether a row may lack a value.
    pub optional: bool,
    /// How it is packed.
    pub packing: Packing,
}
