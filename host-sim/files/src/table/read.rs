//! Reading a measured table: a CSV whose first line names the columns.

use std::path::Path;

use crate::UserError;
use crate::read_text;

/// One line of a table: the fields asked for, and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Line in the file, counted from 1.
    pub number: usize,
    place: String,
    fields: Vec<(&'static str, String)>,
}

/// Reads the `columns` of the CSV file at `path`; others are passed over. White space around names and fields does
/// not count, nor do blank lines.
///
/// # Errors
/// One line naming file, line and mend: no such file, no UTF-8, a column that is missing, a line of another length
/// than the first, no line at all below the first.
pub fn read_columns(path: &Path, columns: &[&'static str]) -> Result<Vec<Line>, UserError> {
    let place = path.display().to_string();
    let bad = |line: usize, what: String| UserError::new(format!("{place}, line {line}: {what}"));
    let text = read_text(path)?;
    // A record's position is where its search began: blank lines before it are passed over.
    let line_of = |position: Option<&csv::Position>| {
        let from = position.map_or(0, |p| p.byte() as usize).min(text.len());
        let blank = text[from..].bytes().take_while(|b| b"\r\n".contains(b));
        let before = from + blank.count();
        text[..before].matches('\n').count() + 1
    };
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let headers = reader.headers().map_err(|e| bad(1, e.to_string()))?.clone();
    let at = |name: &&'static str| {
        let found = headers.iter().position(|h| h.trim() == *name);
        let what = || {
            let all = columns.join(",");
            bad(
                1,
                format!("there is no column {name}; the first line must be {all}"),
            )
        };
        found.map(|at| (*name, at)).ok_or_else(what)
    };
    let wanted: Vec<_> = columns.iter().map(at).collect::<Result<_, _>>()?;
    let mut lines = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| bad(line_of(e.position()), short(&e)))?;
        let field = |(name, at): &(&'static str, usize)| {
            let text = record.get(*at).unwrap_or("").trim();
            (*name, text.to_owned())
        };
        lines.push(Line {
            number: line_of(record.position()),
            place: place.clone(),
            fields: wanted.iter().map(field).collect(),
        });
    }
    if lines.is_empty() {
        return Err(UserError::new(format!(
            "{place}: there is no measurement below the first line"
        )));
    }
    Ok(lines)
}

impl Line {
    /// The field of a column asked for; empty if it was not.
    pub fn text(&self, column: &str) -> &str {
        let found = self.fields.iter().find(|(name, _)| *name == column);
        found.map_or("", |(_, text)| text)
    }

    /// The same as a finite number.
    ///
    /// # Errors
    /// One line when it is none.
    pub fn number(&self, column: &str) -> Result<f64, UserError> {
        let text = self.text(column);
        let value = text.parse::<f64>().ok().filter(|x| x.is_finite());
        value.ok_or_else(|| self.complaint(format!("{column} is '{text}', must be a number")))
    }

    /// A complaint about this line: file and line, then `what`.
    pub fn complaint(&self, what: impl std::fmt::Display) -> UserError {
        UserError::new(format!("{}, line {}: {what}", self.place, self.number))
    }
}

fn short(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths {
            expected_len, len, ..
        } => {
            format!("{len} fields where the first line has {expected_len}; give every line as many")
        }
        _ => error.to_string(),
    }
}
