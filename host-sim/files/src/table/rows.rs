//! Rows turned into columns, by what they serialise to.

use std::fmt::Display;

use serde::ser::{self, Impossible, Serialize, SerializeMap, SerializeStruct, Serializer};

use crate::columns::{Column, Field, Kind, Packing, Value};

/// Why rows make no table; a fault of the program.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(super) struct NoTable(String);

impl ser::Error for NoTable {
    fn custom<T: Display>(what: T) -> Self {
        Self(what.to_string())
    }
}

/// One field over all rows.
#[derive(Debug)]
pub(super) struct Filled {
    name: String,
    /// Of any kind while it has no value, then of the first value's.
    pub column: Column,
}

/// The columns of `rows`; a row serialises as a struct or a map of plain values.
pub(super) fn columns<T: Serialize>(
    rows: impl IntoIterator<Item = T>,
) -> Result<Vec<Filled>, NoTable> {
    let mut table = Table::default();
    for row in rows {
        table.next = 0;
        row.serialize(&mut table)?;
        table.rows += 1;
        for column in &mut table.columns {
            column.fill(table.rows);
        }
    }
    Ok(table.columns)
}

#[derive(Default)]
struct Table {
    columns: Vec<Filled>,
    /// Whole rows so far.
    rows: usize,
    /// Where the next field of a row is expected.
    next: usize,
    /// The field whose value comes next.
    key: usize,
}

impl Table {
    /// The column `name`: where it stood in the row before, or wherever it is, or a new one.
    fn find(&mut self, name: &str) -> usize {
        let expected = self.columns.get(self.next);
        let at = if expected.is_some_and(|c| c.name == name) {
            self.next
        } else {
            let found = self.columns.iter().position(|c| c.name == name);
            found.unwrap_or_else(|| self.add(name))
        };
        self.next = at + 1;
        at
    }

    fn add(&mut self, name: &str) -> usize {
        let mut column = Filled {
            name: name.to_owned(),
            column: Column::of(Kind::Double, false),
        };
        column.fill(self.rows);
        self.columns.push(column);
        self.columns.len() - 1
    }
}

impl Filled {
    /// The column as a file has it.
    pub fn field(&self) -> Field {
        Field {
            name: self.name.clone().into(),
            kind: self.column.kind(),
            optional: self.column.optional(),
            packing: Packing::Dictionary,
        }
    }

    /// Rows up to `rows` that are not there yet get no value.
    fn fill(&mut self, rows: usize) {
        let missing = rows.saturating_sub(self.column.rows());
        if missing > 0 {
            self.absent(missing);
        }
    }

    fn absent(&mut self, rows: usize) {
        self.column.make_optional();
        self.column.absent(rows).expect("it is optional now");
    }

    fn push(&mut self, value: Value) -> Result<(), NoTable> {
        if self.column.values().is_empty() {
            let mut column = Column::of(value.kind(), self.column.optional());
            // Whatever rows there are lack a value.
            let _ = column.absent(self.column.rows());
            self.column = column;
        }
        let pushed = self.column.push(Some(value));
        pushed.map_err(|_| NoTable(format!("column {} mixes kinds of values", self.name)))
    }
}

/// Methods for what a serialiser here refuses.
macro_rules! refuse {
    ($what:expr; $($name:ident($($argument:ty),*) $(-> $out:ty)?;)*) => {$(
        fn $name(self $(, _: $argument)*) -> refuse!(@ $($out)?) {
            Err(NoTable($what(self)))
        }
    )*};
    (@ $out:ty) => { Result<$out, NoTable> };
    (@) => { Result<(), NoTable> };
}

macro_rules! push {
    ($($name:ident($from:ty) => $kind:ident $value:expr;)*) => {$(
        fn $name(self, value: $from) -> Result<(), NoTable> {
            self.push(Value::$kind($value(value)))
        }
    )*};
}

/// A value enters its column.
impl Serializer for &mut Filled {
    type Ok = ();
    type Error = NoTable;
    type SerializeSeq = Impossible<(), NoTable>;
    type SerializeTuple = Impossible<(), NoTable>;
    type SerializeTupleStruct = Impossible<(), NoTable>;
    type SerializeTupleVariant = Impossible<(), NoTable>;
    type SerializeMap = Impossible<(), NoTable>;
    type SerializeStruct = Impossible<(), NoTable>;
    type SerializeStructVariant = Impossible<(), NoTable>;

    push! {
        serialize_bool(bool) => Flag bool::from;
        serialize_i8(i8) => Long i64::from;
        serialize_i16(i16) => Long i64::from;
        serialize_i32(i32) => Long i64::from;
        serialize_i64(i64) => Long i64::from;
        serialize_u8(u8) => Long i64::from;
        serialize_u16(u16) => Long i64::from;
        serialize_u32(u32) => Long i64::from;
        serialize_f32(f32) => Double f64::from;
        serialize_f64(f64) => Double f64::from;
        serialize_str(&str) => Text std::convert::identity;
    }

    refuse! {
        |column: Self| format!("column {} holds more than a plain value", column.name);
        serialize_bytes(&[u8]);
        serialize_seq(Option<usize>) -> Self::SerializeSeq;
        serialize_tuple(usize) -> Self::SerializeTuple;
        serialize_tuple_struct(&'static str, usize) -> Self::SerializeTupleStruct;
        serialize_tuple_variant(&'static str, u32, &'static str, usize) -> Self::SerializeTupleVariant;
        serialize_map(Option<usize>) -> Self::SerializeMap;
        serialize_struct(&'static str, usize) -> Self::SerializeStruct;
        serialize_struct_variant(&'static str, u32, &'static str, usize) -> Self::SerializeStructVariant;
    }

    fn serialize_newtype_variant<T: ?Sized + Serialize>(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: &T,
    ) -> Result<(), NoTable> {
        self.serialize_bytes(&[])
    }

    fn serialize_u64(self, value: u64) -> Result<(), NoTable> {
        let signed = i64::try_from(value)
            .map_err(|_| NoTable(format!("column {}: {value} is too large", self.name)))?;
        self.serialize_i64(signed)
    }

    fn serialize_char(self, value: char) -> Result<(), NoTable> {
        self.serialize_str(value.encode_utf8(&mut [0; 4]))
    }

    fn serialize_none(self) -> Result<(), NoTable> {
        self.absent(1);
        Ok(())
    }

    fn serialize_some<T: ?Sized + Serialize>(self, value: &T) -> Result<(), NoTable> {
        self.column.make_optional();
        value.serialize(self)
    }

    fn serialize_unit(self) -> Result<(), NoTable> {
        self.serialize_none()
    }

    fn serialize_unit_struct(self, name: &'static str) -> Result<(), NoTable> {
        self.serialize_str(name)
    }

    fn serialize_unit_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
    ) -> Result<(), NoTable> {
        self.serialize_str(variant)
    }

    fn serialize_newtype_struct<T: ?Sized + Serialize>(
        self,
        _: &'static str,
        value: &T,
    ) -> Result<(), NoTable> {
        value.serialize(self)
    }
}

/// A row enters the table: a struct, or a map whose keys are names.
impl Serializer for &mut Table {
    type Ok = ();
    type Error = NoTable;
    type SerializeSeq = Impossible<(), NoTable>;
    type SerializeTuple = Impossible<(), NoTable>;
    type SerializeTupleStruct = Impossible<(), NoTable>;
    type SerializeTupleVariant = Impossible<(), NoTable>;
    type SerializeMap = Self;
    type SerializeStruct = Self;
    type SerializeStructVariant = Impossible<(), NoTable>;

    refuse! {
        |_| "a row must have named fields".to_owned();
        serialize_bool(bool);
        serialize_i8(i8);
        serialize_i16(i16);
        serialize_i32(i32);
        serialize_i64(i64);
        serialize_u8(u8);
        serialize_u16(u16);
        serialize_u32(u32);
        serialize_u64(u64);
        serialize_f32(f32);
        serialize_f64(f64);
        serialize_char(char);
        serialize_bytes(&[u8]);
        serialize_none();
        serialize_unit();
        serialize_unit_struct(&'static str);
        serialize_unit_variant(&'static str, u32, &'static str);
        serialize_seq(Option<usize>) -> Self::SerializeSeq;
        serialize_tuple(usize) -> Self::SerializeTuple;
        serialize_tuple_struct(&'static str, usize) -> Self::SerializeTupleStruct;
        serialize_tuple_variant(&'static str, u32, &'static str, usize) -> Self::SerializeTupleVariant;
        serialize_struct_variant(&'static str, u32, &'static str, usize) -> Self::SerializeStructVariant;
    }

    /// A name on its own: the key of a map.
    fn serialize_str(self, name: &str) -> Result<(), NoTable> {
        self.key = self.find(name);
        Ok(())
    }

    fn serialize_some<T: ?Sized + Serialize>(self, row: &T) -> Result<(), NoTable> {
        row.serialize(self)
    }

    fn serialize_newtype_struct<T: ?Sized + Serialize>(
        self,
        _: &'static str,
        row: &T,
    ) -> Result<(), NoTable> {
        row.serialize(self)
    }

    fn serialize_newtype_variant<T: ?Sized + Serialize>(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        row: &T,
    ) -> Result<(), NoTable> {
        row.serialize(self)
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Self, NoTable> {
        Ok(self)
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Self, NoTable> {
        Ok(self)
    }
}

impl SerializeStruct for &mut Table {
    type Ok = ();
    type Error = NoTable;

    fn serialize_field<T: ?Sized + Serialize>(
        &mut self,
        name: &'static str,
        value: &T,
    ) -> Result<(), NoTable> {
        let at = self.find(name);
        value.serialize(&mut self.columns[at])
    }

    fn end(self) -> Result<(), NoTable> {
        Ok(())
    }
}

impl SerializeMap for &mut Table {
    type Ok = ();
    type Error = NoTable;

    fn serialize_key<T: ?Sized + Serialize>(&mut self, key: &T) -> Result<(), NoTable> {
        key.serialize(&mut **self)
    }

    fn serialize_value<T: ?Sized + Serialize>(&mut self, value: &T) -> Result<(), NoTable> {
        let at = self.key;
        value.serialize(&mut self.columns[at])
    }

    fn end(self) -> Result<(), NoTable> {
        Ok(())
    }
}
