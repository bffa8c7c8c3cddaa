//! The cells of a line, and the numbers in them.

/// How a number is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Decimal {
    Point,
    Comma,
}

impl Decimal {
    pub fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Comma => "comma",
        }
    }
}

/// The cells of a line, without the white space and the quotes around them. A separator within quotes does not count.
pub fn split(line: &str, separator: char) -> Vec<&str> {
    let mut cells = Vec::new();
    let (mut from, mut quoted) = (0, false);
    for (at, c) in line.char_indices() {
        if c == '"' {
            quoted = !quoted;
        } else if c == separator && !quoted {
            cells.push(bare(&line[from..at]));
            from = at + c.len_utf8();
        }
    }
    cells.push(bare(&line[from..]));
    cells
}

fn bare(cell: &str) -> &str {
    let cell = cell.trim().trim_start_matches('\u{feff}');
    let inner = cell.strip_prefix('"').and_then(|c| c.strip_suffix('"'));
    inner.unwrap_or(cell).trim()
}

/// The number in a cell, times `factor`, as the plain form has it.
pub fn number(cell: &str, decimal: Decimal, factor: f64) -> Option<String> {
    let text = match decimal {
        Decimal::Comma => cell.replacen(',', ".", 1),
        Decimal::Point => cell.to_owned(),
    };
    let value: f64 = text.parse().ok().filter(|value: &f64| value.is_finite())?;
    Some(if factor == 1.0 {
        text
    } else {
        format!("{:?}", value * factor)
    })
}

/// Whether the comma of a cell could stand between thousands: `1,820` and `12,345`, but not `0,820`, `1,82` or `1,820e3`.
pub fn like_thousands(cell: &str) -> bool {
    let mut groups = cell.trim_start_matches(['-', '+']).split(',');
    let digits = |group: &str| group.bytes().all(|byte| byte.is_ascii_digit());
    let first = groups.next().unwrap_or("");
    let leads = (1..=3).contains(&first.len()) && digits(first) && !first.starts_with('0');
    leads && groups.all(|group| group.len() == 3 && digits(group))
}
