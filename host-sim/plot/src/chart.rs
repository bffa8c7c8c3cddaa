//! Charts drawn with letters, for a terminal.

use std::io::{IsTerminal, stdout};

use crate::Range;
use crate::ticks::{Ticks, axis_range, is_drawable};

#[cfg(test)]
mod tests;

/// Columns of the terminal on standard output, between 40 and 160; 80 when it
/// is not a terminal or does not say.
pub fn terminal_width() -> usize {
    let columns = terminal_size::terminal_size_of(stdout()).map(|(width, _)| usize::from(width.0));
    columns.unwrap_or(80).clamp(40, 160)
}

/// Whether standard output takes colours: it is a terminal and the environment
/// variable `NO_COLOR` is unset or empty.
pub fn wants_color() -> bool {
    stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty())
}

/// A chart of letters.
///
/// A single joined series is drawn in fine braille dots; several series each
/// get a mark of their own.
///
/// ```
/// use plot::chart::Chart;
/// let sweep = (0..100).map(|i| (f64::from(i), f64::from(i * i))).collect();
/// let text = Chart::new("frequency, Hz", "force, N")
///     .size(60, 12)
///     .series("force", sweep)
///     .marker("doubling", 42.0)
///     .render();
/// assert!(text.contains("a: doubling, 42"));
/// ```
#[derive(Debug, Clone)]
pub struct Chart {
    x_label: String,
    y_label: String,
    series: Vec<Series>,
    markers: Vec<(String, f64)>,
    width: usize,
    height: usize,
    color: bool,
}

#[derive(Debug, Clone)]
struct Series {
    label: String,
    points: Vec<(f64, f64)>,
    joined: bool,
}

/// Marks and ANSI colours of the series, in turn.
const MARKS: [(char, u8); 6] = [
    ('●', 34),
    ('×', 31),
    ('▲', 32),
    ('+', 35),
    ('◆', 33),
    ('○', 36),
];

impl Chart {
    /// An empty chart as wide as the terminal and 16 rows high; labels carry units.
    pub fn new(x_label: impl Into<String>, y_label: impl Into<String>) -> Self {
        Self {
            x_label: x_label.into(),
            y_label: y_label.into(),
            series: Vec::new(),
            markers: Vec::new(),
            width: terminal_width(),
            height: 16,
            color: wants_color(),
        }
    }

    /// Sets the width of the whole chart in columns (at least 30) and the
    /// height of the plot in rows (at least 4).
    pub fn size(mut self, columns: usize, rows: usize) -> Self {
        self.width = columns.max(30);
        self.height = rows.max(4);
        self
    }

    /// Sets whether ANSI colours are written; [`Chart::new`] asks [`wants_color`].
    pub fn color(mut self, color: bool) -> Self {
        self.color = color;
        self
    }

    /// Adds joined points `(x, y)`; one that is not finite interrupts the line.
    pub fn series(self, label: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        self.add(label.into(), points, true)
    }

    /// Adds separate points `(x, y)`.
    pub fn points(self, label: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        self.add(label.into(), points, false)
    }

    fn add(mut self, label: String, points: Vec<(f64, f64)>, joined: bool) -> Self {
        self.series.push(Series {
            label,
            points,
            joined,
        });
        self
    }

    /// Adds a vertical line at `x` (x units), named below the chart.
    pub fn marker(mut self, label: impl Into<String>, x: f64) -> Self {
        self.markers.push((label.into(), x));
        self
    }

    /// The chart as lines of text, each ended by a newline.
    pub fn render(&self) -> String {
        let points = || self.series.iter().flat_map(|s| &s.points);
        let whole = || points().filter(|(x, y)| is_drawable(*x) && is_drawable(*y));
        if whole().next().is_none() {
            return format!("{} over {}: no data\n", self.y_label, self.x_label);
        }
        let marked = self.markers.iter().map(|m| m.1);
        let x = axis_range(Range::Auto, whole().map(|p| p.0).chain(marked), 0.0);
        let y = axis_range(Range::Auto, whole().map(|p| p.1), 0.0);
        let (x_end, y_end) = (end_labels(x), end_labels(y));

        let gutter = y_end.iter().map(|l| l.chars().count()).max().unwrap_or(0);
        let columns = self.width.saturating_sub(gutter + 2).max(10);
        let mut grid = Grid::new(columns, self.height, x, y);
        let letters = self.draw_markers(&mut grid);
        let braille = self.series.len() == 1 && self.series[0].joined;
        for (i, series) in self.series.iter().enumerate() {
            grid.draw(series, i, braille);
        }

        let mut out = format!("{:gutter$}  {}\n", "", self.y_label);
        if !self.markers.is_empty() {
            out += &format!("{:gutter$}  {}\n", "", letters.trim_end());
        }
        for row in 0..self.height {
            let label = match row {
                0 => &y_end[1],
                _ if row + 1 == self.height => &y_end[0],
                _ => "",
            };
            let tick = if label.is_empty() { '│' } else { '┤' };
            out += &format!("{label:>gutter$} {tick}{}\n", grid.row(row, self.color));
        }
        out += &format!("{:gutter$} └{}\n", "", "─".repeat(columns));
        let ends = x_end[0].chars().count() + x_end[1].chars().count();
        let between = columns.saturating_sub(ends).max(1);
        let middle: String = self
            .x_label
            .chars()
            .take(between.saturating_sub(2))
            .collect();
        out += &format!(
            "{:gutter$}  {}{middle:^between$}{}\n",
            "", x_end[0], x_end[1]
        );
        self.add_names(&mut out, gutter, braille);
        out
    }

    /// Draws the marker lines; returns the row of their letters.
    fn draw_markers(&self, grid: &mut Grid) -> String {
        let mut letters = vec![' '; grid.columns];
        for (i, (_, x)) in self.markers.iter().enumerate() {
            let Some(at) = grid.column(*x) else { continue };
            for row in 0..grid.rows {
                grid.cells[row * grid.columns + at] = Cell {
                    letter: '┊',
                    series: None,
                };
            }
            // The next free column, so that every marker shows its letter.
            let columns = (at..letters.len()).chain((0..at).rev());
            if let Some(free) = columns.into_iter().find(|c| letters[*c] == ' ') {
                letters[free] = marker_letter(i);
            }
        }
        letters.into_iter().collect()
    }

    /// Lists series and markers below the chart.
    fn add_names(&self, out: &mut String, gutter: usize, braille: bool) {
        for (i, series) in self.series.iter().enumerate() {
            if series.label.is_empty() {
                continue;
            }
            let mark = if braille {
                '⣀'
            } else {
                MARKS[i % MARKS.len()].0
            };
            let mark = paint(&mark.to_string(), Some(i), self.color);
            *out += &format!("{:gutter$}  {mark} {}\n", "", series.label);
        }
        for (i, (label, x)) in self.markers.iter().enumerate() {
            let value = rounded(*x);
            *out += &format!("{:gutter$}  {}: {label}, {value}\n", "", marker_letter(i));
        }
    }
}

/// `a` to `z`, then over again.
fn marker_letter(index: usize) -> char {
    char::from(b'a' + (index % 26) as u8)
}

/// Both ends of an axis, with the same number of digits and no needless zeros.
fn end_labels((lo, hi): (f64, f64)) -> [String; 2] {
    let ticks = Ticks::new(lo, hi, 100);
    let mut ends = [lo, hi].map(|end| ticks.label(end));
    while ends
        .iter()
        .all(|end| end.contains('.') && end.ends_with(['0', '.']))
    {
        for end in &mut ends {
            end.pop();
        }
    }
    match ticks.exponent {
        0 => ends,
        power => ends.map(|end| format!("{end}e{power}")),
    }
}

/// A number with about five digits and no needless zeros.
fn rounded(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e6).contains(&size) {
        return format!("{value:.4e}");
    }
    let decimals = (4 - size.max(1e-3).log10().floor() as i32).clamp(0, 7) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

fn paint(text: &str, series: Option<usize>, color: bool) -> String {
    match series {
        Some(i) if color => format!("\u{1b}[{}m{text}\u{1b}[0m", MARKS[i % MARKS.len()].1),
        _ => text.to_owned(),
    }
}

#[derive(Debug, Clone, Copy)]
struct Cell {
    letter: char,
    series: Option<usize>,
}

/// The cells of the plot and the ranges they span.
struct Grid {
    columns: usize,
    rows: usize,
    x: (f64, f64),
    y: (f64, f64),
    cells: Vec<Cell>,
}

impl Grid {
    fn new(columns: usize, rows: usize, x: (f64, f64), y: (f64, f64)) -> Self {
        let blank = Cell {
            letter: ' ',
            series: None,
        };
        Self {
            columns,
            rows,
            x,
            y,
            cells: vec![blank; columns * rows],
        }
    }

    /// The column of `x`, if it is on the chart.
    fn column(&self, x: f64) -> Option<usize> {
        let inside = (self.x.0..=self.x.1).contains(&x);
        inside.then(|| step(x, self.x, self.columns))
    }

    /// Draws a series, in braille (2 x 4 dots a cell) or with the marks of `index`.
    fn draw(&mut self, series: &Series, index: usize, braille: bool) {
        let (fine_x, fine_y) = if braille { (2, 4) } else { (1, 1) };
        let (columns, rows) = (self.columns * fine_x, self.rows * fine_y);
        let mut last: Option<(usize, usize)> = None;
        for (x, y) in &series.points {
            if !is_drawable(*x) || !is_drawable(*y) {
                last = None;
                continue;
            }
            let at = (step(*x, self.x, columns), rows - 1 - step(*y, self.y, rows));
            let from = if series.joined {
                last.unwrap_or(at)
            } else {
                at
            };
            let far = from.0.abs_diff(at.0).max(from.1.abs_diff(at.1)).max(1);
            for k in 0..=far {
                let between = |a: usize, b: usize| (a * (far - k) + b * k + far / 2) / far;
                let (cx, cy) = (between(from.0, at.0), between(from.1, at.1));
                let cell = &mut self.cells[cy / fine_y * self.columns + cx / fine_x];
                cell.letter = if braille {
                    with_dot(cell.letter, cx % 2, cy % 4)
                } else {
                    MARKS[index % MARKS.len()].0
                };
                cell.series = Some(index);
            }
            last = Some(at);
        }
    }

    /// One row of text; neighbours of one series share their colour codes.
    fn row(&self, row: usize, color: bool) -> String {
        let cells = &self.cells[row * self.columns..(row + 1) * self.columns];
        let text: String = cells
            .chunk_by(|a, b| a.series == b.series)
            .map(|run| {
                let letters: String = run.iter().map(|cell| cell.letter).collect();
                paint(&letters, run[0].series, color)
            })
            .collect();
        text.trim_end().to_owned()
    }
}

/// Which of `count` equal steps of the range holds `value`.
fn step(value: f64, (lo, hi): (f64, f64), count: usize) -> usize {
    let share = (value - lo) / (hi - lo);
    ((share * count as f64) as usize).min(count - 1)
}

/// A braille letter with one more dot (column 0 or 1, row 0 to 3 from the top).
fn with_dot(letter: char, column: usize, row: usize) -> char {
    const DOTS: [[u32; 4]; 2] = [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]];
    let old = u32::from(letter);
    let dots = if (0x2800..0x2900).contains(&old) {
        old
    } else {
        0x2800
    };
    char::from_u32(dots | DOTS[column][row]).unwrap_or(letter)
}
