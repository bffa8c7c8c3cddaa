//! Tables: rows of any kind as CSV or Parquet, and back from CSV.

mod dialect;
#[cfg(feature = "disk")]
mod parquet;
mod read;
#[cfg(feature = "disk")]
mod rows;

use serde::Serialize;

pub use self::dialect::{Plain, plain};
#[cfg(feature = "disk")]
pub use self::parquet::{parquet_with, to_parquet};
pub use self::read::{Line, Measurements};

/// Rows as CSV with a header line.
pub fn to_csv<T: Serialize>(rows: &[T]) -> Vec<u8> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer
            .serialize(row)
            .expect("a row of plain values always serialises");
    }
    writer.into_inner().expect("writing to memory cannot fail")
}
