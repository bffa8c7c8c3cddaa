//! Writing row groups into a Parquet file.

use std::io::Write;
use std::sync::Arc;

use parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as Physical};
use parquet::errors::Result;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{ColumnPath, Type};

use super::check::{KEY, Summed};
use super::{Column, ColumnField, ColumnKind, PROGRAM, Packing};

/// Writes a Parquet file, one row group after another, with a check sum over every byte. The same values give the same
/// bytes.
pub struct ParquetWriter<W: Write + Send> {
    file: SerializedFileWriter<Summed<W>>,
}

impl<W: Write + Send> ParquetWriter<W> {
    /// Begins a file in `sink`: the schema's name, the columns, and keys with values that stand in its footer.
    ///
    /// # Errors
    /// The sink refuses, or the fields make no schema (a name stands twice).
    pub fn new(
        sink: W,
        schema: &str,
        fields: &[ColumnField],
        pairs: Vec<(String, String)>,
    ) -> Result<Self> {
        let columns = fields.iter().map(|field| column_type(field).map(Arc::new));
        let schema = Type::group_type_builder(schema)
            .with_fields(columns.collect::<Result<_>>()?)
            .build()?;
        let properties = Arc::new(properties(fields, pairs));
        let file = SerializedFileWriter::new(Summed::new(sink), Arc::new(schema), properties)?;
        Ok(Self { file })
    }

    /// Appends a row group: a column for every field, in their order, with as many rows each.
    ///
    /// # Errors
    /// The sink refuses, or the columns are not those of the fields.
    pub fn group<'a>(&mut self, columns: impl IntoIterator<Item = &'a Column>) -> Result<()> {
        let mut group = self.file.next_row_group()?;
        for column in columns {
            if let Some(mut writer) = group.next_column()? {
                column.write(writer.untyped())?;
                writer.close()?;
            }
        }
        group.close()?;
        self.file.flush()?;
        self.file.inner_mut().cut();
        Ok(())
    }

    /// Writes the footer and gives the sink back.
    ///
    /// # Errors
    /// The sink refuses.
    pub fn finish(mut self) -> Result<W> {
        self.file.flush()?;
        let checks = self.file.inner_mut().hold_the_tail();
        let pair = KeyValue::new(KEY.to_owned(), checks);
        self.file.append_key_value_metadata(pair);
        Ok(self.file.into_inner()?.finish()?)
    }
}

pub(super) fn physical(kind: ColumnKind) -> Physical {
    match kind {
        ColumnKind::Flag => Physical::BOOLEAN,
        ColumnKind::Int => Physical::INT32,
        ColumnKind::Long => Physical::INT64,
        ColumnKind::Float => Physical::FLOAT,
        ColumnKind::Text | ColumnKind::Bytes => Physical::BYTE_ARRAY,
    }
}

fn column_type(field: &ColumnField) -> Result<Type> {
    Type::primitive_type_builder(&field.name, physical(field.kind))
        .with_logical_type((field.kind == ColumnKind::Text).then_some(LogicalType::String))
        .with_repetition(if field.optional {
            Repetition::OPTIONAL
        } else {
            Repetition::REQUIRED
        })
        .build()
}

fn properties(fields: &[ColumnField], pairs: Vec<(String, String)>) -> WriterProperties {
    let pairs: Vec<_> = pairs
        .into_iter()
        .map(|(key, value)| KeyValue::new(key, value))
        .collect();
    let mut builder = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_created_by(PROGRAM.to_owned())
        .set_key_value_metadata((!pairs.is_empty()).then_some(pairs));
    for field in fields {
        let encoding = match field.packing {
            Packing::Dictionary => continue,
            Packing::Differences => Encoding::DELTA_BINARY_PACKED,
            Packing::Split => Encoding::BYTE_STREAM_SPLIT,
        };
        let path = ColumnPath::from(field.name.as_ref());
        builder = builder
            .set_column_dictionary_enabled(path.clone(), false)
            .set_column_encoding(path, encoding);
    }
    builder.build()
}
