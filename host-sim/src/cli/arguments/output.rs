//! `--format`, `--out` and `--quiet`: how every command answers, on standard output and as files.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use plot::Figure;
use serde::Serialize;

use super::request::CommandRequest;
use crate::cli::terminal::{print, print_bytes, say};
use crate::pictures::drawn;
use files::made_from::{self, MadeFrom, file_name, refuse_others};
use files::table::to_csv;
use files::write::Written;
use files::{UserError, rigfile};
use numerics::NamedRig;
use numerics::uncertainty::Stated;
use serde_json::{Map, Value};

/// Form of the answer on standard output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For a person, with a small chart
    Text,
    /// For a program
    Json,
    /// For a spreadsheet
    Csv,
}

/// Files to write: the name and the content of each.
pub type Contents = Vec<(String, Vec<u8>)>;

/// The folder that commands write into when they answer a person and no other is given.
pub const USUAL_FOLDER: &str = "out";

/// How a command answers.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Output")]
pub struct OutputArgs {
    /// Form of the answer on standard output
    #[arg(long, value_enum, default_value = "text")]
    pub format: Format,

    /// Folder for pictures (SVG, PNG) and tables [default: out with --format text, none otherwise]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,

    /// No progress and no notes on standard error; warnings and errors stay
    #[arg(long)]
    pub quiet: bool,

    /// What is asked for, as the answer carries it.
    #[arg(skip)]
    request: CommandRequest,

    /// How the names of the files begin.
    #[arg(skip)]
    stem: String,
}

impl OutputArgs {
    /// Takes the request of the whole command line, and the folder that goes with it.
    pub fn asked(&mut self, request: CommandRequest) {
        self.stem = request.command.clone();
        self.request = request;
        if self.format == Format::Text {
            self.out.get_or_insert_with(|| USUAL_FOLDER.into());
        }
    }

    /// A copy for an answer about `rigs`: its files are named after the command, the first rig and the options given,
    /// and carry the rigs. What stands in the way and is no answer of this program is refused here, before any work is
    /// done.
    ///
    /// # Errors
    /// If the answer could not be written.
    pub fn about<'a>(
        &self,
        rigs: impl IntoIterator<Item = &'a NamedRig>,
    ) -> Result<Self, UserError> {
        let rigs: Vec<&NamedRig> = rigs.into_iter().collect();
        let first = rigs.first().map(|rig| rig.name.as_str());
        let first = first.filter(|_| !self.gives("all"));
        let options = self.options(&[]);
        let parts = [self.request.command.as_str()].into_iter();
        let stem = file_name(parts.chain(first).chain([options.as_str()]));
        self.named(stem, rigs)
    }

    /// As [`Self::about`], with file names that begin with `stem`.
    ///
    /// # Errors
    /// As [`Self::about`].
    pub fn named<'a>(
        &self,
        stem: String,
        rigs: impl IntoIterator<Item = &'a NamedRig>,
    ) -> Result<Self, UserError> {
        let mut output = self.clone();
        output.stem = stem;
        let made_from = std::mem::take(&mut output.request.made_from);
        output.request.made_from = made_from.with_rigs(rigs);
        output.check()?;
        let usual = [".json", ".svg", ".png", ".csv", ".parquet", ".mcap"];
        let usual = usual.map(|end| output.name(end));
        output.refuse_others(usual.iter().map(String::as_str))?;
        Ok(output)
    }

    /// Makes every file say which uncertainty of the parameters was used.
    #[must_use]
    pub fn with_uncertainty(mut self, uncertainty: Option<Map<String, Value>>) -> Self {
        self.request.made_from.uncertainty = uncertainty;
        self
    }

    fn gives(&self, option: &str) -> bool {
        let mut given = self.request.given.iter();
        given.any(|(name, _)| name == option)
    }

    /// The options given, as they stand in file names: without the rig's and without `aside`.
    pub fn options(&self, aside: &[&str]) -> String {
        let given = self.request.given.iter();
        let given = given.filter(|(name, _)| {
            !["rig", "set"].contains(&name.as_str()) && !aside.contains(&name.as_str())
        });
        let parts = given.flat_map(|(name, values)| {
            let values = values.iter().map(|value| match Path::new(value).is_file() {
                true => Path::new(value)
                    .file_stem()
                    .unwrap_or_default()
                    .to_string_lossy(),
                false => value.as_str().into(),
            });
            std::iter::once(name.as_str().into()).chain(values)
        });
        let parts: Vec<_> = parts.collect();
        file_name(parts.iter().map(AsRef::as_ref))
    }

    /// The name of a file of this answer: that of the request, and `end`.
    pub fn name(&self, end: &str) -> String {
        format!("{}{end}", self.stem)
    }

    /// What the answer is made from.
    pub fn made_from(&self) -> &MadeFrom {
        &self.request.made_from
    }

    fn refuse_others<'a>(
        &self,
        names: impl IntoIterator<Item = &'a str> + Clone,
    ) -> Result<(), UserError> {
        match &self.out {
            Some(dir) => refuse_others(dir, names),
            None => Ok(()),
        }
    }

    /// Refuses an output folder that cannot be written to, before any work is done.
    ///
    /// # Errors
    /// If the answer could not be written.
    pub fn check(&self) -> Result<(), UserError> {
        match &self.out {
            Some(dir) => check_folder(dir),
            None => Ok(()),
        }
    }

    /// Writes a note for a person on standard error.
    pub fn note(&self, text: &str) {
        note(self.quiet, text);
    }

    /// Says which values of `rig` look like ones in another unit, also where no notes are wanted: the answer may be for
    /// another rig than the one meant.
    pub fn doubt(&self, rig: &NamedRig) {
        for line in rigfile::doubts(&rig.params) {
            say(&line);
        }
    }

    /// What to know of `rig` where an answer is for its values alone: those that look like ones in another unit, and that
    /// its file states an uncertainty which the answer does not carry.
    pub fn doubt_without_uncertainty(&self, rig: &NamedRig) {
        self.doubt(rig);
        if rig.stated != Stated::default() {
            self.note(&format!(
                "note: rig {} states an uncertainty; this answer is for its values alone (pick takes the uncertainty into account)",
                rig.name
            ));
        }
    }

    /// Writes files into `dir`, each with what it was made from, and says so.
    ///
    /// # Errors
    /// If a file cannot be written, or would replace what is no answer of this program.
    pub fn write(&self, dir: &Path, contents: Contents) -> Result<(), UserError> {
        let written = files::write::write_all(dir, &self.stamped(contents)?)?;
        self.note_written(&written);
        Ok(())
    }

    /// Says which files were written, and whether others of these names are gone. Of names that begin alike, the
    /// beginning stands once.
    pub fn note_written(&self, written: &Written) {
        let mut words: Vec<String> = Vec::with_capacity(written.paths.len());
        for path in &written.paths {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            match name.strip_prefix(&self.stem) {
                Some(end) if !words.is_empty() => words.push(end.to_owned()),
                _ => words.push(path.display().to_string()),
            }
        }
        let list = words.join(", ");
        self.note(&format!("wrote {list}{}", replaced(written.replaced)));
    }

    /// Files, each with what it was made from.
    ///
    /// # Errors
    /// If one would replace what is no answer of this program.
    pub fn stamped(&self, contents: Contents) -> Result<Contents, UserError> {
        let names: Vec<_> = contents.iter().map(|(name, _)| name.as_str()).collect();
        self.refuse_others(names.iter().copied())?;
        let stamp = |(name, bytes): (String, Vec<u8>)| {
            let bytes = made_from::stamped(&name, bytes, self.made_from());
            (name, bytes)
        };
        Ok(contents.into_iter().map(stamp).collect())
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
        emit(self.format, Some(self.made_from()), answer, rows, text)
    }

    /// The whole answer: where a folder was asked for, the files of `pictures`, `NAME.csv` and `NAME.json`; then what
    /// [`emit`] writes.
    ///
    /// # Errors
    /// If a picture cannot be made, a file not be written, or the answer has no form in this format.
    pub fn answer<A: Serialize + ?Sized, T: Serialize>(
        &self,
        answer: &A,
        rows: &[T],
        pictures: impl FnOnce() -> Result<Contents, UserError>,
        text: impl FnOnce() -> String,
    ) -> Result<(), UserError> {
        if let Some(dir) = &self.out {
            let mut contents = pictures()?;
            contents.extend(self.tables(&self.name(""), answer, rows)?);
            self.write(dir, contents)?;
        }
        self.emit(answer, rows, text)
    }

    /// The files of the answer's picture.
    ///
    /// # Errors
    /// If it cannot be made.
    pub fn picture(&self, figure: &Figure) -> Result<Contents, UserError> {
        drawn(&self.name(""), figure)
    }

    /// The files of an answer: `NAME.csv` and `NAME.json`.
    ///
    /// # Errors
    /// If the answer has no form as JSON.
    pub fn tables<A: Serialize + ?Sized, T: Serialize>(
        &self,
        name: &str,
        answer: &A,
        rows: &[T],
    ) -> Result<Contents, UserError> {
        Ok(vec![
            (format!("{name}.csv"), to_csv(rows)),
            (format!("{name}.json"), to_json(answer)?.into_bytes()),
        ])
    }
}

/// What the line that names written files ends with.
pub fn replaced(replaced: bool) -> &'static str {
    if replaced { " (replaced)" } else { "" }
}

/// Writes a note for a person on standard error, unless it is to be quiet.
pub fn note(quiet: bool, text: &str) {
    if !quiet {
        say(text);
    }
}

/// Writes the answer on standard output: `text` for a person, `answer` as JSON, or `rows` as CSV; JSON says what it
/// was made from.
///
/// # Errors
/// If the answer has no form in this format.
pub fn emit<A: Serialize + ?Sized, T: Serialize>(
    format: Format,
    made: Option<&MadeFrom>,
    answer: &A,
    rows: &[T],
    text: impl FnOnce() -> String,
) -> Result<(), UserError> {
    match format {
        Format::Text => print(&text()),
        Format::Json => {
            let json = to_json(answer)?;
            print(&match made {
                Some(made) => made_from::into_json(json, made),
                None => json,
            });
        }
        Format::Csv => print_bytes(&match made {
            Some(made) => made_from::into_csv(to_csv(rows), made),
            None => to_csv(rows),
        }),
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
    text.map(|text| text + "\n").map_err(no_json)
}

/// An answer has no form as JSON.
pub fn no_json(error: serde_json::Error) -> UserError {
    UserError::new(format!("cannot write JSON: {error}"))
}
