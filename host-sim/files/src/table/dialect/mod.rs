//! Measured tables as instruments and spreadsheets write them: lines above the names, semicolons or tabs between the columns,
//! decimal commas, a row of units, other units than those used here. Such a table is written again in the plain form, each line
//! on the line where it was; a table in the plain form is left as it is.

mod cells;
mod quantity;
#[cfg(test)]
mod tests;

use crate::UserError;
use cells::{Decimal, number, split};
use quantity::{NamedColumn, Unit, of_name};

/// A table in the plain form.
#[derive(Clone, Debug, PartialEq)]
pub struct Plain {
    /// Commas, decimal points, the names and units used here.
    pub text: String,
    /// How the file was understood, if it was not in that form: one line.
    pub said: Option<String>,
}

/// How many lines may stand above the names.
const MOST_ABOVE: usize = 100;

/// Brings `text` into the plain form. A table in which no line names two known columns is left to its reader.
///
/// # Errors
/// One line that begins with `place`: a unit is missing or not known, or commas and points contradict each other.
pub fn plain(place: &str, text: String) -> Result<Plain, UserError> {
    let Some(header) = Header::find(&text) else {
        return Ok(Plain { text, said: None });
    };
    header.refuse_commas_for_both(place, &text)?;
    let units = header.units_line(&text);
    if units.is_none() && header.is_plain() {
        return Ok(Plain { text, said: None });
    }
    let columns = header.columns(place, units.as_ref())?;
    let first = units.as_ref().map_or(header.line, |(line, _)| *line);
    let decimal = decimal(place, &text, &header, &columns, first)?;
    let said = words(
        place,
        &header,
        units.map(|(line, _)| line),
        &columns,
        decimal,
    );
    let text = rewritten(place, &text, &header, &columns, first, decimal)?;
    Ok(Plain {
        text,
        said: Some(said),
    })
}

/// The line that names the columns.
struct Header<'a> {
    /// Number of that line in the file, counted from 1.
    line: usize,
    separator: char,
    names: Vec<&'a str>,
    known: Vec<Option<NamedColumn>>,
}

/// A column that is read: where it is, and by what it is multiplied.
struct Column {
    at: usize,
    named: NamedColumn,
    unit: Option<Unit>,
}

impl<'a> Header<'a> {
    /// The first line that names two known columns.
    fn find(text: &'a str) -> Option<Self> {
        let lines = text.trim_start_matches('\u{feff}').lines().enumerate();
        for (i, line) in lines.take(MOST_ABOVE) {
            for separator in [',', ';', '\t'] {
                let names = split(line, separator);
                let mut known: Vec<_> = names.iter().map(|name| of_name(name)).collect();
                // Of two columns of one quantity, the one that is called as here is read.
                for i in 0..known.len() {
                    let twin = |other: &Option<NamedColumn>| {
                        other.is_some_and(|other| {
                            other.plain
                                && known[i].is_some_and(|own| {
                                    !own.plain && own.quantity.column == other.quantity.column
                                })
                        })
                    };
                    if known.iter().any(twin) {
                        known[i] = None;
                    }
                }
                if known.iter().flatten().count() >= 2 {
                    return Some(Self {
                        line: i + 1,
                        separator,
                        names,
                        known,
                    });
                }
            }
        }
        None
    }

    /// Whether the table needs no change but for a row of units.
    fn is_plain(&self) -> bool {
        self.separator == ',' && self.line == 1 && self.known.iter().flatten().all(|n| n.plain)
    }

    /// Commas between the columns and in the numbers cannot be told apart.
    fn refuse_commas_for_both(&self, place: &str, text: &str) -> Result<(), UserError> {
        let Some((line, first)) = rows(text, self.line).next() else {
            return Ok(());
        };
        let whole = |cell: &str| {
            let digits = cell.trim_start_matches(['-', '+']);
            !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit())
        };
        let cells = split(first, ',');
        let both = self.separator == ','
            && cells.len() == 2 * self.names.len()
            && cells.iter().all(|cell| whole(cell));
        if both {
            let what = "there are twice as many numbers as names: decimal commas cannot be told from commas between the columns; export with semicolons or with decimal points";
            return Err(bad(place, line, what));
        }
        Ok(())
    }

    /// The row of units below the names, if there is one: none of the columns known holds a number there.
    fn units_line(&self, text: &'a str) -> Option<(usize, Vec<&'a str>)> {
        let (line, row) = rows(text, self.line).next()?;
        let cells = split(row, self.separator);
        let mut any = false;
        for (i, named) in self.known.iter().enumerate() {
            let cell = *cells.get(i)?;
            if named.is_some_and(|named| named.quantity.is_number()) {
                let word = cell.chars().any(char::is_alphabetic)
                    && !cell.chars().any(|c| c.is_ascii_digit())
                    && !["nan", "inf", "-inf"].contains(&cell.to_lowercase().as_str());
                if !word && !cell.is_empty() {
                    return None;
                }
                any |= word;
            }
        }
        any.then_some((line, cells))
    }

    fn columns(
        &self,
        place: &str,
        units: Option<&(usize, Vec<&str>)>,
    ) -> Result<Vec<Column>, UserError> {
        let mut columns: Vec<Column> = Vec::new();
        for (at, named) in self.known.iter().enumerate() {
            let Some(named) = *named else { continue };
            let name = self.names[at];
            if columns
                .iter()
                .any(|c| c.named.quantity.column == named.quantity.column)
            {
                let what = format!("two columns are '{}'; rename one", named.quantity.column);
                return Err(bad(place, self.line, what));
            }
            let below = units.map(|(line, cells)| (*line, cells[at]));
            let below = below.filter(|(_, cell)| !cell.is_empty());
            let unit = unit_of(place, self.line, name, named, below)?;
            columns.push(Column { at, named, unit });
        }
        Ok(columns)
    }
}

/// The unit of a column, from its name or the row of units.
fn unit_of(
    place: &str,
    line: usize,
    name: &str,
    named: NamedColumn,
    below: Option<(usize, &str)>,
) -> Result<Option<Unit>, UserError> {
    let quantity = named.quantity;
    if !quantity.is_number() {
        return Ok(None);
    }
    let Some((units_line, cell)) = below else {
        return named.unit.map(Some).ok_or_else(|| {
            let what = format!(
                "the column '{name}' has no unit; call it {} if that is its unit, or name one of {} in brackets behind it",
                quantity.column,
                quantity.units()
            );
            bad(place, line, what)
        });
    };
    let unit = quantity.unit(cell).ok_or_else(|| {
        let what = format!(
            "the unit of '{name}' is '{cell}', must be one of {}; a voltage must be multiplied by the sensor's calibration first",
            quantity.units()
        );
        bad(place, units_line, what)
    })?;
    if named.unit.is_some_and(|other| other.factor != unit.factor) {
        let what = format!("the unit of '{name}' is '{cell}' here and another in its name");
        return Err(bad(place, units_line, what));
    }
    Ok(Some(unit))
}

fn bad(place: &str, line: usize, what: impl std::fmt::Display) -> UserError {
    UserError::new(format!("{place}, line {line}: {what}"))
}

/// The lines below `line` with anything in them, with their numbers.
fn rows(text: &str, line: usize) -> impl Iterator<Item = (usize, &str)> {
    let lines = text.lines().enumerate().skip(line);
    lines
        .map(|(i, row)| (i + 1, row))
        .filter(|(_, row)| !row.trim().is_empty())
}

/// How the numbers below `first` are written. Without a comma between the columns, a comma can only be a decimal one, or
/// one between thousands.
fn decimal(
    place: &str,
    text: &str,
    header: &Header,
    columns: &[Column],
    first: usize,
) -> Result<Decimal, UserError> {
    if header.separator == ',' {
        return Ok(Decimal::Point);
    }
    let mut found: Option<(Decimal, usize)> = None;
    let mut thousands = None;
    for (line, row) in rows(text, first) {
        let cells = split(row, header.separator);
        for column in columns.iter().filter(|c| c.named.quantity.is_number()) {
            let cell = cells.get(column.at).copied().unwrap_or("");
            let here = match (cell.contains(','), cell.contains('.')) {
                (true, true) => {
                    let what = format!(
                        "'{cell}' has a comma and a point; export without a separator between thousands"
                    );
                    return Err(bad(place, line, what));
                }
                (true, false) => Decimal::Comma,
                (false, true) => Decimal::Point,
                (false, false) => continue,
            };
            match found {
                Some((other, other_line)) if other != here => {
                    let what = format!(
                        "'{cell}' has a decimal {}, and line {other_line} a decimal {}; export the whole table with one of them",
                        here.name(),
                        other.name()
                    );
                    return Err(bad(place, line, what));
                }
                None => found = Some((here, line)),
                _ => {}
            }
            if here == Decimal::Comma {
                let so_far = thousands.unwrap_or(Some((line, cell)));
                thousands = Some(so_far.filter(|_| cells::like_thousands(cell)));
            }
        }
    }
    // A table with semicolons comes from where the comma is decimal; one with tabs may come from anywhere.
    if let (Some(Some((line, cell))), '\t') = (thousands, header.separator) {
        let what = format!(
            "'{cell}' may have a decimal comma or one between thousands, like all the others; export with decimal points"
        );
        return Err(bad(place, line, what));
    }
    Ok(found.map_or(Decimal::Point, |(decimal, _)| decimal))
}

/// One line on what was understood.
fn words(
    place: &str,
    header: &Header,
    units: Option<usize>,
    columns: &[Column],
    decimal: Decimal,
) -> String {
    let between = match header.separator {
        ';' => "semicolons",
        '\t' => "tabs",
        _ => "commas",
    };
    let mut parts = vec![format!("{between} between the columns")];
    if decimal == Decimal::Comma {
        parts.push("decimal commas".into());
    }
    if header.line > 1 {
        parts.push(format!("names on line {}", header.line));
    }
    if let Some(line) = units {
        parts.push(format!("units on line {line}"));
    }
    let of = |column: &Column| {
        let name = header.names[column.at];
        match column.unit {
            Some(unit) => format!("'{name}' in {}", unit.name),
            None => format!("'{name}'"),
        }
    };
    let columns: Vec<_> = columns.iter().map(of).collect();
    format!(
        "{place}: read with {}; {}",
        parts.join(", "),
        columns.join(", ")
    )
}

/// The table in the plain form; lines that are not read are blank.
fn rewritten(
    place: &str,
    text: &str,
    header: &Header,
    columns: &[Column],
    first: usize,
    decimal: Decimal,
) -> Result<String, UserError> {
    let mut plain = String::with_capacity(text.len());
    let names: Vec<_> = columns.iter().map(|c| c.named.quantity.column).collect();
    // The names come first, as their reader expects; as many line ends keep the lines below on their numbers.
    plain += &names.join(",");
    plain += &"\n".repeat(first);
    let mut next = first + 1;
    for (line, row) in rows(text, first) {
        plain += &"\n".repeat(line - next);
        next = line + 1;
        let cells = split(row, header.separator);
        let more = cells.len() > header.names.len();
        let blank = cells.iter().skip(header.names.len()).all(|c| c.is_empty());
        if cells.len() < header.names.len() || (more && !blank) {
            let what = format!(
                "{} fields where line {} has {}; give every line as many (is the file cut short?)",
                cells.len(),
                header.line,
                header.names.len()
            );
            return Err(bad(place, line, what));
        }
        for (i, column) in columns.iter().enumerate() {
            if i > 0 {
                plain.push(',');
            }
            let cell = cells[column.at];
            match column
                .unit
                .and_then(|unit| number(cell, decimal, unit.factor))
            {
                Some(number) => plain += &number,
                // Its reader complains of it in its own words.
                None => plain += &format!("\"{}\"", cell.replace('"', "\"\"")),
            }
        }
        plain.push('\n');
    }
    Ok(plain)
}
