//! The columns of the Parquet file: their names, kinds and encodings, and a row group's worth of each.

use parquet::basic::{Compression, Encoding};
use parquet::data_type::ByteArray;
use parquet::errors::Result;
use parquet::file::properties::{EnabledStatistics, WriterProperties, WriterPropertiesBuilder};
use parquet::schema::types::ColumnPath;

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Flag,
    Int,
    Long,
    Float,
    Text,
    Bytes,
}

/// Where a column has values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fill {
    /// At every tick.
    Tick,
    /// At every tick of an emulated run, nowhere in a board's recording.
    Truth,
    /// At every tick whose block has a status.
    State,
    /// At a block's first tick.
    Block,
}

/// A column: name with unit, kind, where it has values.
pub(super) struct Spec {
    pub name: &'static str,
    pub kind: Kind,
    pub fill: Fill,
}

macro_rules! columns {
    ($($id:ident $name:literal $kind:ident $fill:ident;)*) => {
        /// Every column, in the order of the file.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(super) enum Col { $($id),* }

        pub(super) const COLUMNS: &[Spec] = &[
            $(Spec { name: $name, kind: Kind::$kind, fill: Fill::$fill }),*
        ];
    };
}

columns! {
    Tick "tick" Long Tick;
    TimeUs "time_us" Long Tick;
    Force "force_code" Int Tick;
    Hammer "hammer_code" Int Tick;
    Cart "cart_code" Int Tick;
    Emergency "emergency" Flag Tick;
    Dac "dac_code" Int Tick;
    FrequencySet "frequency_set_hz" Float Tick;
    Enable "enable" Flag Tick;
    TrueForce "true_force_n" Float Truth;
    TrueHammer "true_hammer_mm" Float Truth;
    TrueCart "true_cart_mm" Float Truth;
    State "state" Text State;
    BlockTicks "block_ticks" Int Block;
    Slices "slices" Int Block;
    Samples "samples" Text Block;
    Forecast "forecast_delivered" Flag Block;
    Inputs "inputs" Text Block;
    InputsPostcard "inputs_postcard" Bytes Block;
    StatusTick "status_tick" Long Block;
    Fault "fault" Text Block;
    FaultOrigin "fault_origin" Text Block;
    FaultTick "fault_tick" Long Block;
    FaultValue "fault_value" Float Block;
    FaultFrequency "fault_frequency_hz" Float Block;
    Limits "limits" Long Block;
    Frequency "frequency_hz" Float Block;
    Amplitude "amplitude_m" Float Block;
    MeasuredAmplitude "measured_amplitude_m" Float Block;
    Lag "lag_rad" Float Block;
    Regime "regime" Text Block;
    Peak "peak_n" Float Block;
    Impulse "impulse_n_s" Float Block;
    Target "target_hz" Float Block;
    TargetForce "target_n" Float Block;
    Basin "basin" Text Block;
    Reseeks "reseeks" Long Block;
    Overruns "overruns" Long Block;
}

impl Spec {
    fn optional(&self) -> bool {
        self.fill != Fill::Tick
    }
}

/// The schema in Parquet's notation.
pub(super) fn schema() -> String {
    let field = |spec: &Spec| {
        let need = if spec.optional() {
            "OPTIONAL"
        } else {
            "REQUIRED"
        };
        let (kind, note) = match spec.kind {
            Kind::Flag => ("BOOLEAN", ""),
            Kind::Int => ("INT32", ""),
            Kind::Long => ("INT64", ""),
            Kind::Float => ("FLOAT", ""),
            Kind::Text => ("BYTE_ARRAY", " (UTF8)"),
            Kind::Bytes => ("BYTE_ARRAY", ""),
        };
        format!("{need} {kind} {}{note};", spec.name)
    };
    let fields: Vec<_> = COLUMNS.iter().map(field).collect();
    format!("message run {{ {} }}", fields.join(" "))
}

/// How the columns are packed: counters and codes as differences, what is measured or true as split
/// floats, all else (which repeats) by dictionary; everything through snappy.
pub(super) fn properties() -> WriterPropertiesBuilder {
    let mut builder = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_created_by(super::writer::PROGRAM.to_owned());
    for spec in COLUMNS {
        let path = ColumnPath::from(spec.name);
        let encoding = match (spec.kind, spec.fill) {
            (Kind::Int | Kind::Long, Fill::Tick) | (Kind::Long, _) => Encoding::DELTA_BINARY_PACKED,
            (Kind::Float, Fill::Truth) => Encoding::BYTE_STREAM_SPLIT,
            _ => continue,
        };
        builder = builder
            .set_column_dictionary_enabled(path.clone(), false)
            .set_column_encoding(path, encoding);
    }
    builder
}

/// The values of a column in a row group; those that are absent are not among them.
#[derive(Debug)]
pub(super) enum Values {
    Flag(Vec<bool>),
    Int(Vec<i32>),
    Long(Vec<i64>),
    Float(Vec<f32>),
    Bytes(Vec<ByteArray>),
}

/// A column of a row group.
#[derive(Debug)]
pub(super) struct Column {
    pub values: Values,
    /// 1 where there is a value, 0 where not; empty for a column that always has one.
    pub levels: Vec<i16>,
    optional: bool,
}

/// A value on its way into a column.
pub(super) enum Value<'a> {
    Flag(bool),
    Int(i32),
    Long(i64),
    Float(f32),
    Bytes(&'a [u8]),
}

impl Column {
    pub fn new(spec: &Spec) -> Self {
        let values = match spec.kind {
            Kind::Flag => Values::Flag(Vec::new()),
            Kind::Int => Values::Int(Vec::new()),
            Kind::Long => Values::Long(Vec::new()),
            Kind::Float => Values::Float(Vec::new()),
            Kind::Text | Kind::Bytes => Values::Bytes(Vec::new()),
        };
        Self {
            values,
            levels: Vec::new(),
            optional: spec.optional(),
        }
    }

    /// Appends a value of the column's own kind, or its absence.
    pub fn push(&mut self, value: Option<Value>) {
        if self.optional {
            self.levels.push(i16::from(value.is_some()));
        }
        let Some(value) = value else {
            assert!(self.optional, "a column that always has a value");
            return;
        };
        match (&mut self.values, value) {
            (Values::Flag(all), Value::Flag(one)) => all.push(one),
            (Values::Int(all), Value::Int(one)) => all.push(one),
            (Values::Long(all), Value::Long(one)) => all.push(one),
            (Values::Float(all), Value::Float(one)) => all.push(one),
            // Text repeats from tick to tick: the bytes are shared with the one before.
            (Values::Bytes(all), Value::Bytes(one)) => match all.last() {
                Some(last) if last.data() == one => all.push(last.clone()),
                _ => all.push(ByteArray::from(one.to_vec())),
            },
            _ => unreachable!("a column holds one kind"),
        }
    }

    /// Appends `rows` rows without a value.
    pub fn absent(&mut self, rows: usize) {
        self.levels.resize(self.levels.len() + rows, 0);
    }

    pub fn clear(&mut self) {
        self.levels.clear();
        match &mut self.values {
            Values::Flag(all) => all.clear(),
            Values::Int(all) => all.clear(),
            Values::Long(all) => all.clear(),
            Values::Float(all) => all.clear(),
            Values::Bytes(all) => all.clear(),
        }
    }

    /// Writes the column into `writer`, which must be of its kind.
    pub fn write(&self, writer: &mut parquet::column::writer::ColumnWriter) -> Result<()> {
        use parquet::column::writer::ColumnWriter as W;
        use parquet::errors::ParquetError;
        let levels = self.optional.then_some(self.levels.as_slice());
        match (writer, &self.values) {
            (W::BoolColumnWriter(w), Values::Flag(all)) => w.write_batch(all, levels, None),
            (W::Int32ColumnWriter(w), Values::Int(all)) => w.write_batch(all, levels, None),
            (W::Int64ColumnWriter(w), Values::Long(all)) => w.write_batch(all, levels, None),
            (W::FloatColumnWriter(w), Values::Float(all)) => w.write_batch(all, levels, None),
            (W::ByteArrayColumnWriter(w), Values::Bytes(all)) => w.write_batch(all, levels, None),
            _ => return Err(ParquetError::General("a column of another kind".into())),
        }
        .map(drop)
    }

    /// Reads `rows` rows from `reader`.
    pub fn read(
        &mut self,
        reader: parquet::column::reader::ColumnReader,
        rows: usize,
    ) -> Result<()> {
        use parquet::column::reader::ColumnReader as R;
        use parquet::errors::ParquetError;
        self.clear();
        let levels = self.optional.then_some(&mut self.levels);
        macro_rules! all {
            ($reader:ident, $values:ident) => {{
                let mut reader = $reader;
                let (records, ..) = reader.read_records(rows, levels, None, $values)?;
                records
            }};
        }
        let records = match (reader, &mut self.values) {
            (R::BoolColumnReader(r), Values::Flag(v)) => all!(r, v),
            (R::Int32ColumnReader(r), Values::Int(v)) => all!(r, v),
            (R::Int64ColumnReader(r), Values::Long(v)) => all!(r, v),
            (R::FloatColumnReader(r), Values::Float(v)) => all!(r, v),
            (R::ByteArrayColumnReader(r), Values::Bytes(v)) => all!(r, v),
            _ => return Err(ParquetError::General("a column of another kind".into())),
        };
        if records == rows {
            return Ok(());
        }
        Err(ParquetError::General(format!(
            "a column has {records} rows of {rows}"
        )))
    }
}
