//! Rows as a Parquet file.

use serde::Serialize;

use super::rows::{Filled, columns};
use crate::UserError;
use crate::columns::{Error, Field, Writer};

/// Rows as a Parquet file, one column per field: numbers as DOUBLE or INT64, truth as BOOLEAN, text as UTF-8, an
/// `Option` as an optional column. A column without a value in any row is an optional DOUBLE; no rows make a file
/// without columns. The same rows give the same bytes.
///
/// # Errors
/// Rows that are no table (a field that is a list or a struct, or whose kind changes): a fault of the program.
pub fn to_parquet<T: Serialize>(rows: impl IntoIterator<Item = T>) -> Result<Vec<u8>, UserError> {
    parquet_with(rows, Vec::new())
}

/// The same, with keys and values in the footer.
///
/// # Errors
/// As [`to_parquet`].
pub fn parquet_with<T: Serialize>(
    rows: impl IntoIterator<Item = T>,
    pairs: Vec<(String, String)>,
) -> Result<Vec<u8>, UserError> {
    let columns = columns(rows).map_err(|e| UserError::new(format!("cannot make Parquet: {e}")))?;
    write(&columns, pairs).map_err(|e| UserError::new(format!("cannot make Parquet: {e}")))
}

fn write(columns: &[Filled], pairs: Vec<(String, String)>) -> Result<Vec<u8>, Error> {
    let fields: Vec<Field> = columns.iter().map(Filled::field).collect();
    let mut file = Writer::new(Vec::new(), "table", &fields, pairs)?;
    if !columns.is_empty() {
        file.group(columns.iter().map(|filled| &filled.column))?;
    }
    file.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    use parquet::file::reader::{FileReader, SerializedFileReader};

    #[derive(Serialize)]
    struct Part {
        force_n: f64,
        periods: Option<u8>,
    }

    #[derive(Serialize)]
    #[serde(rename_all = "lowercase")]
    enum Side {
        Left,
    }

    #[derive(Serialize)]
    struct Line<'a> {
        name: &'a str,
        #[serde(flatten)]
        part: Part,
        never: Option<f64>,
        settled: bool,
        side: Side,
        small: f32,
        #[serde(skip_serializing_if = "Option::is_none")]
        late: Option<i64>,
    }

    fn line(name: &str, periods: Option<u8>, late: Option<i64>) -> Line<'_> {
        Line {
            name,
            part: Part {
                force_n: 0.1 + 0.2,
                periods,
            },
            never: None,
            settled: periods.is_some(),
            side: Side::Left,
            small: 0.5,
            late,
        }
    }

    fn read(bytes: Vec<u8>) -> (Vec<String>, Vec<String>) {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(&bytes).unwrap();
        let file = SerializedFileReader::new(file).unwrap();
        let schema = file.metadata().file_metadata().schema().clone();
        let fields = schema.get_fields().iter().map(|f| {
            let need = f.get_basic_info().repetition();
            format!("{} {need} {}", f.name(), f.get_physical_type())
        });
        let rows = file.get_row_iter(None).unwrap();
        (
            fields.collect(),
            rows.map(|r| r.unwrap().to_string()).collect(),
        )
    }

    #[test]
    fn every_kind_of_value_comes_back_and_what_lacks_is_null() {
        let rows = [line("a", Some(2), None), line("b", None, Some(-7))];
        let (fields, rows) = read(to_parquet(&rows).unwrap());
        let expected = [
            "name REQUIRED BYTE_ARRAY",
            "force_n REQUIRED DOUBLE",
            "periods OPTIONAL INT64",
            "never OPTIONAL DOUBLE",
            "settled REQUIRED BOOLEAN",
            "side REQUIRED BYTE_ARRAY",
            "small REQUIRED DOUBLE",
            "late OPTIONAL INT64",
        ];
        assert_eq!(fields, expected);
        assert!(rows[0].contains("force_n: 0.30000000000000004"), "{rows:?}");
        let [a, b] = rows.as_slice() else { panic!() };
        assert!(a.contains("periods: 2") && a.contains("late: null"), "{a}");
        assert!(b.contains("periods: null") && b.contains("late: -7"), "{b}");
        assert!(b.contains("never: null") && b.contains("settled: false"));
        assert!(b.contains("side: \"left\"") && b.contains("small: 0.5"));
    }

    #[test]
    fn what_is_no_table_is_refused_and_no_rows_are_a_file() {
        assert!(to_parquet([1.0]).is_err());
        assert!(to_parquet([serde_json::json!({"a": [1, 2]})]).is_err());
        assert!(to_parquet([serde_json::json!({"a": 1}), serde_json::json!({"a": "x"})]).is_err());
        let none: [Part; 0] = [];
        assert_eq!(read(to_parquet(none).unwrap()), (vec![], vec![]));
    }
}
