//! Tables: rows of any kind as CSV, and back.

mod dialect;
mod read;
mod selection;

use serde::Serialize;

pub use self::dialect::{Plain, plain};
pub use self::read::{Measurements, TableLine};
pub use self::selection::Selection;

/// Rows as CSV with a header line; none at all leave it empty.
pub fn to_csv<T: Serialize>(rows: &[T]) -> Vec<u8> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer
            .serialize(row)
            .expect("a row of plain values always serialises");
    }
    writer.into_inner().expect("writing to memory cannot fail")
}

/// Rows as CSV with a header line, which is there even without rows: then it is that of `like`.
pub fn to_csv_or_header<T: Serialize>(rows: &[T], like: T) -> Vec<u8> {
    if !rows.is_empty() {
        return to_csv(rows);
    }
    let mut header = to_csv(&[like]);
    header.truncate(header.iter().position(|b| *b == b'\n').map_or(0, |i| i + 1));
    header
}
