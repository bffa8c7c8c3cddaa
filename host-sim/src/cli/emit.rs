//! How every command answers: on standard output in the format asked for, and as files beside pictures.

use std::io::{IsTerminal, stdout};

use serde::Serialize;

use super::common::Format;
use files::UserError;
use files::table::{to_csv, to_parquet};

/// Writes the answer on standard output: `text` for a person, `answer` as JSON, or `rows` as CSV or Parquet.
/// Parquet goes to a file or a program alone, never to a terminal ([`check_format`] has refused that unless there is
/// a folder to write into).
pub fn emit<A: Serialize + ?Sized, T: Serialize>(
    format: Format,
    answer: &A,
    rows: &[T],
    text: impl FnOnce() -> String,
) -> Result<(), UserError> {
    match format {
        Format::Text => super::print(&text()),
        Format::Json => super::print(&super::to_json(answer)?),
        Format::Csv => {
            super::still_read_bytes(&to_csv(rows));
        }
        Format::Parquet if stdout().is_terminal() => {}
        Format::Parquet => {
            super::still_read_bytes(&to_parquet(rows)?);
        }
    }
    Ok(())
}

/// Refuses Parquet on a terminal when there is no folder for it, before any work is done.
pub fn check_format(format: Format, has_folder: bool) -> Result<(), UserError> {
    if format == Format::Parquet && !has_folder && stdout().is_terminal() {
        return Err(UserError::new(
            "Parquet is not for a terminal; add --out DIR, or redirect: > FILE.parquet",
        ));
    }
    Ok(())
}

/// The files of an answer: `NAME.csv`, `NAME.json`, and with `--format parquet` also `NAME.parquet`.
pub fn tables<A: Serialize + ?Sized, T: Serialize>(
    name: &str,
    format: Format,
    answer: &A,
    rows: &[T],
) -> Result<Vec<(String, Vec<u8>)>, UserError> {
    let mut files = vec![
        (format!("{name}.csv"), to_csv(rows)),
        (format!("{name}.json"), super::to_json(answer)?.into_bytes()),
    ];
    if format == Format::Parquet {
        files.push((format!("{name}.parquet"), to_parquet(rows)?));
    }
    Ok(files)
}
