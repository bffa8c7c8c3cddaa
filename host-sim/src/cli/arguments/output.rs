//! `--format`, `--out` and `--quiet`: how every command answers, on standard output and as files.

use std::io::{IsTerminal, stdout};
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use serde::Serialize;

use crate::cli::terminal::{print, print_bytes, say};
use files::table::{to_csv, to_parquet};
use files::{UserError, rigfile};
use numerics::NamedRig;

/// How to answer on standard output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For a person, with a small chart
    Text,
    /// For a program
    Json,
    /// For a spreadsheet
    Csv,
    /// For large tables: columns with their types, packed
    Parquet,
}

/// Files by name.
pub type Contents = Vec<(String, Vec<u8>)>;

/// How a command answers.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Output")]
pub struct OutputArgs {
    /// How to answer on standard output
    #[arg(long, value_enum, default_value = "text")]
    pub format: Format,

    /// Folder for pictures (SVG, PNG) and tables
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// No progress, no notes on standard error
    #[arg(long)]
    pub quiet: bool,
}

impl OutputArgs {
    /// The same; with `--format text` and without `--out`, files go into the folder `out`.
    #[must_use]
    pub fn with_usual_folder(&self) -> Self {
        let mut output = self.clone();
        if output.format == Format::Text {
            output.out.get_or_insert_with(|| "out".into());
        }
        output
    }

    /// Refuses an output folder that cannot be written to, and Parquet on a terminal, before any work is done.
    ///
    /// # Errors
    /// If the answer could not be written.
    pub fn check(&self) -> Result<(), UserError> {
        check_format(self.format, self.out.is_some())?;
        match &self.out {
            Some(dir) => check_folder(dir),
            None => Ok(()),
        }
    }

    /// Writes a note for a person on standard error.
    pub fn note(&self, text: &str) {
        note(self.quiet, text);
    }

    /// Says which values of `rig` look like ones in another unit.
    pub fn doubt(&self, rig: &NamedRig) {
        for line in rigfile::doubts(&rig.params) {
            self.note(&line);
        }
    }

    /// Writes files into `dir` and says so.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write(&self, dir: &Path, contents: &[(String, Vec<u8>)]) -> Result<(), UserError> {
        let paths = files::write::write_all(dir, contents)?;
        let names: Vec<_> = paths.iter().map(|p| p.display().to_string()).collect();
        self.note(&format!("wrote {}", names.join(", ")));
        Ok(())
    }

    /// Writes the answer on standard output; see [`emit`].
    ///
    /// # Errors
    /// If the answer has no form in this format.
    pub fn emit<A: Serialize + ?Sized, T: Serialize>(
        &self,
        answer: &A,
        rows: &[T],
        text: impl FnOnce() -> String,
    ) -> Result<(), UserError> {
        emit(self.format, answer, rows, text)
    }

    /// The files of an answer: `NAME.csv`, `NAME.json`, and with `--format parquet` also `NAME.parquet`.
    ///
    /// # Errors
    /// If the answer has no form as JSON or Parquet.
    pub fn tables<A: Serialize + ?Sized, T: Serialize>(
        &self,
        name: &str,
        answer: &A,
        rows: &[T],
    ) -> Result<Contents, UserError> {
        let mut files = vec![
            (format!("{name}.csv"), to_csv(rows)),
            (format!("{name}.json"), to_json(answer)?.into_bytes()),
        ];
        if self.format == Format::Parquet {
            files.push((format!("{name}.parquet"), to_parquet(rows)?));
        }
        Ok(files)
    }
}

/// Writes a note for a person on standard error, unless it is to be quiet.
pub fn note(quiet: bool, text: &str) {
    if !quiet {
        say(text);
    }
}

/// Writes the answer on standard output: `text` for a person, `answer` as JSON, or `rows` as CSV or Parquet.
/// Parquet goes to a file or a program only, never to a terminal ([`check_format`] has refused that unless there is
/// a folder to write into).
///
/// # Errors
/// If the answer has no form in this format.
pub fn emit<A: Serialize + ?Sized, T: Serialize>(
    format: Format,
    answer: &A,
    rows: &[T],
    text: impl FnOnce() -> String,
) -> Result<(), UserError> {
    match format {
        Format::Text => print(&text()),
        Format::Json => print(&to_json(answer)?),
        Format::Csv => print_bytes(&to_csv(rows)),
        Format::Parquet if stdout().is_terminal() => {}
        Format::Parquet => print_bytes(&to_parquet(rows)?),
    }
    Ok(())
}

/// Refuses Parquet on a terminal when there is no folder for it, before any work is done.
///
/// # Errors
/// If that is what was asked for.
pub fn check_format(format: Format, has_folder: bool) -> Result<(), UserError> {
    if format == Format::Parquet && !has_folder && stdout().is_terminal() {
        return Err(UserError::new(
            "Parquet is not for a terminal; add --out DIR, or redirect: > FILE.parquet",
        ));
    }
    Ok(())
}

/// Checks that `--out` can be a folder to write into.
///
/// # Errors
/// If it is a file, or nothing can be written there.
pub fn check_folder(dir: &Path) -> Result<(), UserError> {
    if dir.exists() && !dir.is_dir() {
        return Err(UserError::new(format!(
            "--out {} is a file; choose another folder",
            dir.display()
        )));
    }
    Ok(files::write::check_folder(dir)?)
}

/// Pretty JSON with a final newline.
///
/// # Errors
/// If the answer has no form as JSON.
pub fn to_json<T: Serialize + ?Sized>(answer: &T) -> Result<String, UserError> {
    let text = serde_json::to_string_pretty(answer);
    text.map(|text| text + "\n")
        .map_err(|e| UserError::new(format!("cannot write JSON: {e}")))
}
