//! Reading a measured table: a CSV whose first line names the columns.

use std::path::Path;
use std::sync::Arc;

use super::dialect::{Plain, plain};
use crate::decimal::hint;
use crate::{UserError, read_table};

/// A measured table in memory.
#[derive(Clone, Debug)]
pub struct Measurements {
    place: Arc<str>,
    text: String,
    columns: Vec<String>,
    said: Option<String>,
}

/// One line of a table: the fields asked for, and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct TableLine {
    /// Line in the file, counted from 1.
    pub number: usize,
    place: Arc<str>,
    fields: Vec<(&'static str, String)>,
}

impl Measurements {
    /// Reads the CSV file at `path`, as instruments and spreadsheets write it ([`plain`]).
    ///
    /// # Errors
    /// The file cannot be read, or its first line is no CSV.
    pub fn read(path: &Path) -> Result<Self, UserError> {
        Self::new(&path.display().to_string(), read_table(path)?)
    }

    /// The table in `text`; complaints begin with `place`.
    ///
    /// # Errors
    /// The first line is no CSV.
    pub fn new(place: &str, text: String) -> Result<Self, UserError> {
        let Plain { text, said } = plain(place, text)?;
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let names = reader.headers();
        let names = names.map_err(|e| UserError::new(format!("{place}, line 1: {e}")))?;
        let columns = names.iter().map(|name| name.trim().to_owned()).collect();
        Ok(Self {
            place: place.into(),
            text,
            columns,
            said,
        })
    }

    /// How the file was understood, if it was not in the plain form.
    pub fn said(&self) -> Option<&str> {
        self.said.as_deref()
    }

    /// Whether the first line names this column.
    pub fn has(&self, column: &str) -> bool {
        self.columns.iter().any(|name| name == column)
    }

    /// A complaint about the first line.
    pub fn complaint(&self, what: impl std::fmt::Display) -> UserError {
        self.bad(1, what)
    }

    /// The `columns` of every line, one after the other; other columns are passed over. White space around names and
    /// fields does not count, nor do blank lines. A line of another length than the first is an error.
    ///
    /// # Errors
    /// A column is missing, or there is no line below the first.
    pub fn lines<'a>(
        &'a self,
        columns: &[&'static str],
    ) -> Result<impl Iterator<Item = Result<TableLine, UserError>> + use<'a>, UserError> {
        let at = |name: &&'static str| {
            let found = self.columns.iter().position(|column| column == name);
            found.map(|at| (*name, at)).ok_or_else(|| {
                let all = columns.join(",");
                self.complaint(format!(
                    "there is no column {name}; the first line must be {all}"
                ))
            })
        };
        let wanted: Vec<_> = columns.iter().map(at).collect::<Result<_, _>>()?;
        let mut numbers = LineNumbers::new(&self.text);
        let records = csv::Reader::from_reader(self.text.as_bytes()).into_records();
        let mut records = records.peekable();
        if records.peek().is_none() {
            return Err(UserError::new(format!(
                "{}: there is no measurement below the first line",
                self.place
            )));
        }
        Ok(records.map(move |record| {
            let record = record.map_err(|e| self.bad(numbers.of(e.position()), short(&e)))?;
            let field = |(name, at): &(&'static str, usize)| {
                let text = record.get(*at).unwrap_or("").trim();
                (*name, text.to_owned())
            };
            Ok(TableLine {
                number: numbers.of(record.position()),
                place: Arc::clone(&self.place),
                fields: wanted.iter().map(field).collect(),
            })
        }))
    }

    fn bad(&self, line: usize, what: impl std::fmt::Display) -> UserError {
        UserError::new(format!("{}, line {line}: {what}", self.place))
    }
}

/// Numbers of lines for positions that rise, each byte of the text looked at once.
struct LineNumbers<'a> {
    text: &'a [u8],
    /// How far the lines are counted, and the number of the line there.
    at: usize,
    number: usize,
}

impl<'a> LineNumbers<'a> {
    fn new(text: &'a str) -> Self {
        Self {
            text: text.as_bytes(),
            at: 0,
            number: 1,
        }
    }

    /// The line of a record. Its position is where its search began: blank lines before it are passed over.
    fn of(&mut self, position: Option<&csv::Position>) -> usize {
        let from = position.map_or(0, |p| p.byte() as usize);
        while let Some(byte) = self.text.get(self.at) {
            if self.at >= from && !b"\r\n".contains(byte) {
                break;
            }
            // A line ends with CR, LF or both, as for the CSV reader.
            let ends = match byte {
                b'\n' => self.at == 0 || self.text[self.at - 1] != b'\r',
                byte => *byte == b'\r',
            };
            self.number += usize::from(ends);
            self.at += 1;
        }
        self.number
    }
}

impl TableLine {
    /// The field of a column; empty if it was not asked for.
    pub fn text(&self, column: &str) -> &str {
        let found = self.fields.iter().find(|(name, _)| *name == column);
        found.map_or("", |(_, text)| text)
    }

    /// The field of a column as a finite number.
    ///
    /// # Errors
    /// It is no number, or infinite.
    pub fn number(&self, column: &str) -> Result<f64, UserError> {
        let text = self.text(column);
        let value = text.parse::<f64>().ok().filter(|x| x.is_finite());
        value.ok_or_else(|| {
            let write = hint(text);
            self.complaint(format!("{column} is '{text}', must be a number{write}"))
        })
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

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str, columns: &[&'static str]) -> Result<Vec<TableLine>, UserError> {
        let table = Measurements::new("m.csv", text.to_owned()).unwrap();
        table.lines(columns)?.collect()
    }

    #[test]
    fn lines_are_counted_with_blank_ones_and_either_line_end() {
        let text = "a,b\n\n1,2\r\n\r\n3,\"4\n5\"\n\n\n6,7";
        let numbers = |text, column| {
            let lines = lines(text, &[column]).unwrap();
            lines.iter().map(|line| line.number).collect::<Vec<_>>()
        };
        assert_eq!(numbers(text, "b"), [3, 5, 9]);
        assert_eq!(numbers("a\r1\r\r2\n", "a"), [2, 4]);
        let line = lines("a\n1\n\n2,3\n", &["a"]).unwrap_err();
        assert!(
            line.to_string().starts_with("m.csv, line 4: 2 fields"),
            "{line}"
        );
    }

    #[test]
    fn a_field_with_a_decimal_comma_is_told_how_to_write_it() {
        let lines = lines("a,b\n1,\"1,6\"\n", &["b"]).unwrap();
        let why = lines[0].number("b").unwrap_err().to_string();
        let said = "m.csv, line 2: b is '1,6', must be a number; write 1.6 with a point";
        assert_eq!(why, said);
    }

    /// Fails by its time, an hour and more, if finding a line's number looks at all lines before it.
    #[test]
    fn a_long_table_is_read_in_one_pass() {
        const LINES: usize = 500_000;
        let text: String = std::iter::once("a,b\n")
            .chain(std::iter::repeat_n("0.25,0.5\n", LINES))
            .collect();
        let lines = lines(&text, &["a", "b"]).unwrap();
        assert_eq!(lines.len(), LINES);
        assert_eq!(lines.last().map(|line| line.number), Some(LINES + 1));
    }
}
