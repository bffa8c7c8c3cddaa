//! Reading row groups of a Parquet file that may be damaged.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::{ColumnChunkMetaData, RowGroupMetaData};
use parquet::file::reader::{FileReader, SerializedFileReader};

use super::check::{Checks, KEY};
use super::writer::physical;
use super::{Column, ColumnField};
use crate::quiet;

/// Most rows of a row group: twenty times what a log has. A damaged count must not ask for all memory.
const MOST_ROWS: i64 = 1 << 22;

/// Most bytes of a column in a row group, unpacked.
const MOST_BYTES: i64 = 1 << 30;

/// Reads a Parquet file.
pub struct ParquetReader {
    file: SerializedFileReader<File>,
    /// A second handle of the file, from which its check sums are computed.
    raw: File,
    checks: Option<Checks>,
    bytes: u64,
}

impl ParquetReader {
    /// Reads the footer of `file`.
    ///
    /// # Errors
    /// It cannot be read, is cut short, damaged or no Parquet.
    pub fn open(file: File) -> Result<Self> {
        let bytes = file.metadata()?.len();
        let raw = file.try_clone()?;
        let file = guard(|| SerializedFileReader::new(file))?;
        let mut reader = Self {
            file,
            raw,
            checks: None,
            bytes,
        };
        if let Some(text) = reader.checks() {
            let damaged = || ParquetError::General("its footer is damaged".into());
            let checks = Checks::parse(text).ok_or_else(damaged)?;
            let tail = reader.range(checks.tail_from(), bytes)?;
            if !Checks::tail_is_whole(tail) {
                return Err(damaged());
            }
            reader.checks = Some(checks);
        }
        Ok(reader)
    }

    /// Whether every byte is under a check sum, as all are that this program writes; those of the footer are checked
    /// already.
    pub fn is_checked(&self) -> bool {
        self.checks.is_some()
    }

    /// The bytes `from..end` of the file.
    fn range(&self, from: u64, end: u64) -> Result<Vec<u8>> {
        let damaged = || ParquetError::General("its parts are not within the file".into());
        let length = end.checked_sub(from).filter(|_| end <= self.bytes);
        let length = length.and_then(|n| usize::try_from(n).ok());
        let mut bytes = vec![0; length.ok_or_else(damaged)?];
        let mut raw = &self.raw;
        raw.seek(SeekFrom::Start(from))?;
        raw.read_exact(&mut bytes)?;
        Ok(bytes)
    }

    /// Rows before row group `index`, and in it.
    pub fn rows_of(&self, index: usize) -> (u64, u64) {
        let groups = self.file.metadata().row_groups();
        let rows = |g: &RowGroupMetaData| u64::try_from(g.num_rows()).unwrap_or(0);
        let before = groups.iter().take(index).map(rows).sum();
        (before, groups.get(index).map_or(0, rows))
    }

    /// The keys of the footer, with their values; the check sums are not among them.
    pub fn pairs(&self) -> impl Iterator<Item = (&str, &str)> {
        self.all_pairs().filter(|(key, _)| *key != KEY)
    }

    /// The check sums as they stand in the footer.
    pub(super) fn checks(&self) -> Option<&str> {
        let found = self.all_pairs().find(|(key, _)| *key == KEY);
        found.map(|(_, text)| text)
    }

    fn all_pairs(&self) -> impl Iterator<Item = (&str, &str)> {
        let pairs = self.file.metadata().file_metadata().key_value_metadata();
        let pairs = pairs.into_iter().flatten();
        pairs.filter_map(|pair| Some((pair.key.as_str(), pair.value.as_deref()?)))
    }

    /// How many rows the footer states.
    pub fn rows(&self) -> u64 {
        u64::try_from(self.file.metadata().file_metadata().num_rows()).unwrap_or(0)
    }

    /// How many row groups there are.
    pub fn groups(&self) -> usize {
        self.file.num_row_groups()
    }

    /// Whether the columns are those of `fields`: the same names and kinds in the same order.
    pub fn has(&self, fields: &[ColumnField]) -> bool {
        let columns = self.file.metadata().file_metadata().schema_descr();
        columns.num_columns() == fields.len()
            && columns.columns().iter().zip(fields).all(|(column, field)| {
                column.path().parts() == [field.name.as_ref()]
                    && column.physical_type() == physical(field.kind)
                    && column.max_def_level() == i16::from(field.optional)
                    && column.max_rep_level() == 0
            })
    }

    /// The columns of row group `index`, which must be those of `fields`.
    ///
    /// # Errors
    /// The group is damaged.
    pub fn group(&self, index: usize, fields: &[ColumnField]) -> Result<Vec<Column>> {
        if let Some(checks) = &self.checks {
            let damaged =
                || ParquetError::General("its bytes are not those that were written".into());
            let (from, end, sum) = checks.group(index).ok_or_else(damaged)?;
            if crc32fast::hash(&self.range(from, end)?) != sum {
                return Err(damaged());
            }
        }
        guard(|| {
            let reader = self.file.get_row_group(index)?;
            let rows = self.check(reader.metadata(), fields)?;
            let column = |(i, field)| Column::read(field, reader.get_column_reader(i)?, rows);
            fields.iter().enumerate().map(column).collect()
        })
    }

    /// Whether what the footer says of a group can be; how many rows it has.
    fn check(&self, group: &RowGroupMetaData, fields: &[ColumnField]) -> Result<usize> {
        let damaged = |what: &str| ParquetError::General(what.to_owned());
        let rows = group.num_rows();
        if !(0..=MOST_ROWS).contains(&rows) || group.num_columns() != fields.len() {
            return Err(damaged("a row group of impossible size"));
        }
        let fits = |chunk: &ColumnChunkMetaData| {
            let (from, length) = chunk.byte_range();
            let end = from.checked_add(length);
            chunk.num_values() == rows
                && (0..=MOST_BYTES).contains(&chunk.uncompressed_size())
                && end.is_some_and(|end| end <= self.bytes)
        };
        if !group.columns().iter().all(fits) {
            return Err(damaged("a column that is not within the file"));
        }
        usize::try_from(rows).map_err(|_| damaged("a negative number of rows"))
    }
}

/// Runs the library on bytes that may be damaged: its panic is one more way to say so.
fn guard<T>(read: impl FnOnce() -> Result<T>) -> Result<T> {
    quiet::catch(read).unwrap_or_else(|| Err(ParquetError::General("its pages are damaged".into())))
}
