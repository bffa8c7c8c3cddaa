//! What a sensor recorded over time: CSV with the columns `time_s` and any of [`COLUMNS`], or a log (Parquet) of
//! `host-sim link record` or `host-sim emulate`.

use std::path::Path;

use emulator::log::LogReader;
use files::decimal::hint;
use files::table::{Plain, plain};
use files::{UserError, read_table};
use numerics::signal::{FEWEST_SAMPLES, Signal};

/// The columns that are read beside `time_s`; others are passed over.
pub const COLUMNS: [&str; 3] = ["force_n", "displacement_mm", "cart_mm"];

/// Largest value of a sensor, in N or mm, and latest time of a record, in s.
const LARGEST: f64 = 1e9;

/// Bytes of a CSV between two reports of how far the reading has come.
const PORTION: u64 = 1 << 20;

/// Reads `path`: a log if it ends in `.parquet`, else CSV. `say` is told how the file was understood, if it was not in the
/// plain form; `advance` each further share of the file that has been read.
///
/// # Errors
/// One line naming file, line and mend.
pub fn read(path: &Path, say: impl Fn(&str), advance: impl Fn(f64)) -> Result<Signal, UserError> {
    let parquet = path.extension().is_some_and(|e| e == "parquet");
    if parquet {
        return from_log(path, advance);
    }
    let name = path.display().to_string();
    let Plain { text, said } = plain(&name, read_table(path)?)?;
    let signal = parse(&name, &text, advance)?;
    said.iter().for_each(|line| say(line));
    Ok(signal)
}

/// From the text of a CSV in the plain form, called `name`; `advance` as in [`read`].
///
/// # Errors
/// One line naming file, line and mend.
pub fn parse(name: &str, text: &str, advance: impl Fn(f64)) -> Result<Signal, UserError> {
    let whole = text.len() as f64;
    let mut told = 0;
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
    let headers = reader.headers().map_err(|e| bad(name, 1, e))?.clone();
    let mut samples = Samples::new(name, headers)?;
    let mut record = csv::StringRecord::new();
    loop {
        match reader.read_record(&mut record) {
            // The reader's position is after the record; none of these has a line break within.
            Ok(true) => {
                samples.push(&record, line_of(&reader, &record))?;
                let read = reader.position().byte();
                if read - told >= PORTION {
                    advance((read - told) as f64 / whole);
                    told = read;
                }
            }
            Ok(false) => break,
            Err(e) => {
                let line = e.position().map_or(0, csv::Position::line);
                return Err(bad(name, line, unequal(&e)));
            }
        }
    }
    advance((text.len() as u64 - told) as f64 / whole);
    samples.into_signal()
}

fn bad(name: &str, line: u64, what: impl std::fmt::Display) -> UserError {
    UserError::new(format!("{name}, line {line}: {what}"))
}

/// The samples of a CSV, line by line.
struct Samples<'a> {
    name: &'a str,
    headers: csv::StringRecord,
    /// Where the column `time_s` is, and those of [`COLUMNS`].
    time: usize,
    places: [Option<usize>; 3],
    times: Vec<f64>,
    values: [Option<Vec<f64>>; 3],
    /// Whether the last instant has stood twice already.
    repeated: bool,
}

impl<'a> Samples<'a> {
    /// Finds the columns by the first line.
    fn new(name: &'a str, headers: csv::StringRecord) -> Result<Self, UserError> {
        for wanted in ["time_s"].iter().chain(&COLUMNS) {
            if headers.iter().filter(|h| h == wanted).count() > 1 {
                let what = format!("two columns are called {wanted}; rename one");
                return Err(bad(name, 1, what));
            }
        }
        let find = |wanted: &str| headers.iter().position(|h| h == wanted);
        let any = COLUMNS.join(", ");
        let Some(time) = find("time_s") else {
            let what = format!(
                "there is no column time_s; the first line must name the columns, with commas between: time_s and any of {any}"
            );
            return Err(bad(name, 1, what));
        };
        let places = COLUMNS.map(find);
        if places.iter().all(Option::is_none) {
            let what = format!("beside time_s there is none of {any}");
            return Err(bad(name, 1, what));
        }
        Ok(Self {
            name,
            headers,
            time,
            places,
            times: Vec::new(),
            values: places.map(|place| place.map(|_| Vec::new())),
            repeated: false,
        })
    }

    fn number(
        &self,
        record: &csv::StringRecord,
        line: u64,
        column: usize,
    ) -> Result<f64, UserError> {
        let cell = record.get(column).unwrap_or("");
        let value = cell.parse::<f64>().ok().filter(|x| x.abs() <= LARGEST);
        value.ok_or_else(|| {
            let what = self.headers.get(column).unwrap_or("");
            let write = hint(cell);
            let must_be = format!("must be a number from -{LARGEST:e} to {LARGEST:e}");
            bad(
                self.name,
                line,
                format!("{what} is '{cell}', {must_be}{write}"),
            )
        })
    }

    fn push(&mut self, record: &csv::StringRecord, line: u64) -> Result<(), UserError> {
        let now = self.number(record, line, self.time)?;
        // At a jump, as where a contact begins, a history has its instant twice: the later values count.
        self.repeated = self.times.last() == Some(&now) && !self.repeated;
        if self.repeated {
            self.times.pop();
            self.values.iter_mut().flatten().for_each(|column| {
                column.pop();
            });
        } else if let Some(last) = self.times.last()
            && now <= *last
        {
            let what = format!("time_s is {now} after {last}; times must rise from line to line");
            return Err(bad(self.name, line, what));
        }
        self.times.push(now);
        for (i, place) in self.places.into_iter().enumerate() {
            let Some(place) = place else {
                continue;
            };
            let value = self.number(record, line, place)?;
            if let Some(column) = &mut self.values[i] {
                column.push(value);
            }
        }
        Ok(())
    }

    fn into_signal(self) -> Result<Signal, UserError> {
        let (name, count) = (self.name, self.times.len());
        if count < FEWEST_SAMPLES {
            return Err(UserError::new(format!(
                "{name}: samples below the first line: {count}, at least {FEWEST_SAMPLES} are needed"
            )));
        }
        let [force_n, displacement_mm, cart_mm] = self.values;
        Ok(Signal {
            name: name.to_owned(),
            time_s: self.times,
            force_n,
            displacement_mm,
            cart_mm,
        })
    }
}

/// What the controller's sensors showed, by the calibration the log begins with.
fn from_log(path: &Path, advance: impl Fn(f64)) -> Result<Signal, UserError> {
    let mut reader = LogReader::open(path)?;
    let settings = reader.header().settings;
    let whole = reader.ticks() as f64;
    let (mut times, mut force, mut hammer, mut cart) = (vec![], vec![], vec![], vec![]);
    while let Some(block) = reader.block()? {
        for (i, tick) in block.ticks.iter().enumerate() {
            times.push((block.first_tick + i as u64) as f64 * shared::settings::TICK_S);
            force.push(f64::from(settings.force.value(tick.frame.force)));
            hammer.push(f64::from(settings.hammer.value(tick.frame.hammer)) * 1e3);
            cart.push(f64::from(settings.cart.value(tick.frame.cart)) * 1e3);
        }
        advance(block.ticks.len() as f64 / whole);
    }
    if times.len() < FEWEST_SAMPLES {
        return Err(UserError::new(format!(
            "{}: there are {} ticks in it, at least {FEWEST_SAMPLES} are needed",
            path.display(),
            times.len()
        )));
    }
    Ok(Signal {
        name: path.display().to_string(),
        time_s: times,
        force_n: Some(force),
        displacement_mm: Some(hammer),
        cart_mm: Some(cart),
    })
}

/// The line a record stands on. A record's own position is where its search began, with the blank lines before it.
fn line_of<R: std::io::Read>(reader: &csv::Reader<R>, record: &csv::StringRecord) -> u64 {
    let after = reader.position().line();
    let began = record.position().map_or(1, csv::Position::line);
    if reader.is_done() {
        after.max(began)
    } else {
        after.saturating_sub(1).max(began)
    }
}

fn unequal(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths {
            expected_len, len, ..
        } => format!(
            "{len} fields where the first line has {expected_len}; give every line as many (is the file cut short?)"
        ),
        _ => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(count: usize) -> String {
        (0..count).map(|i| format!("{i}e-5,0.5\n")).collect()
    }

    #[test]
    fn columns_come_in_any_order_and_others_are_passed_over() {
        let text = format!(
            "note,force_n, time_s\n{}",
            (0..20)
                .map(|i| format!("x,{}, 0.{i:03}\n", i * 2))
                .collect::<String>()
        );
        let signal = parse("f", &text, |_| ()).unwrap();
        assert_eq!(signal.time_s[3], 0.003);
        assert_eq!(signal.force_n.as_ref().unwrap()[3], 6.0);
        assert_eq!(signal.displacement_mm, None);
        assert!((signal.sample_s() - 1e-3).abs() < 1e-12);
        assert_eq!(signal.between(0.002, 0.0185).unwrap().time_s.len(), 17);
        assert!(signal.between(0.5, 0.6).is_err());
    }

    #[test]
    fn the_shares_read_of_a_long_record_come_one_by_one_and_are_the_whole() {
        let text = format!("time_s,force_n\n{}", rows(300_000));
        let shares = std::cell::RefCell::new(Vec::new());
        parse("f.csv", &text, |share| shares.borrow_mut().push(share)).unwrap();
        let shares = shares.into_inner();
        let portions = (text.len() as u64 / PORTION) as usize;
        assert!(shares.len() > 2 && shares.len().abs_diff(portions) < 2);
        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn an_instant_that_stands_twice_counts_once() {
        let text = format!("time_s,force_n\n{}1,2\n1,3\n2,4\n", rows(20));
        let signal = parse("f.csv", &text, |_| ()).unwrap();
        let force = signal.force_n.unwrap();
        assert_eq!((signal.time_s.len(), force.len()), (22, 22));
        assert_eq!(force[20..], [3.0, 4.0]);
    }

    #[test]
    fn a_bad_line_is_named() {
        let complaint = |text: String| parse("f.csv", &text, |_| ()).unwrap_err().to_string();
        let good = rows(20);
        assert!(
            complaint(format!("time,force_n\n{good}"))
                .contains("line 1: there is no column time_s")
        );
        assert!(complaint(format!("time_s,x\n{good}")).contains("line 1: beside time_s"));
        for (bad, says) in [
            ("1,abc\n", "line 22: force_n is 'abc'"),
            ("\n\n1,nan\n", "line 24: force_n is 'nan'"),
            ("1\n", "line 22: 1 fields"),
            ("1e-5,2\n", "line 22: time_s is 0.00001 after"),
            (
                "1,1e10\n",
                "line 22: force_n is '1e10', must be a number from -1e9",
            ),
            ("1,\"1,6\"\n", "to 1e9; write 1.6 with a point"),
            ("1,2\n1,3\n1,4\n", "line 24: time_s is 1 after 1"),
            ("1,inf", "line 22: force_n is 'inf'"),
        ] {
            let said = complaint(format!("time_s,force_n\n{good}{bad}"));
            assert!(said.starts_with("f.csv, ") && said.contains(says), "{said}");
        }
        assert!(complaint(format!("time_s,force_n\n{}", rows(3))).contains("first line: 3"));
    }
}
