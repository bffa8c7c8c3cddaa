//! What a sensor recorded over time: CSV with the columns `time_s` and any of [`COLUMNS`], or a log (Parquet) of
//! `host-sim link record` or `host-sim emulate`.

use std::path::Path;

use emulator::log::Reader;
use files::{UserError, read_table};
use numerics::signal::{FEWEST_SAMPLES, Signal};

/// The columns that are read beside `time_s`; others are passed over.
pub const COLUMNS: [&str; 3] = ["force_n", "displacement_mm", "cart_mm"];

/// No sensor of such a rig says more, in N or mm; nor does a record begin later, in s.
const LARGEST: f64 = 1e9;

/// Reads `path`: a log if it ends in `.parquet`, else CSV.
///
/// # Errors
/// One line naming file, line and mend.
pub fn read(path: &Path) -> Result<Signal, UserError> {
    let parquet = path.extension().is_some_and(|e| e == "parquet");
    if parquet {
        return from_log(path);
    }
    parse(&path.display().to_string(), &read_table(path)?)
}

/// From the text of a CSV called `name`.
///
/// # Errors
/// One line naming file, line and mend.
pub fn parse(name: &str, text: &str) -> Result<Signal, UserError> {
    let bad = |line: u64, what: String| UserError::new(format!("{name}, line {line}: {what}"));
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
    let headers = reader.headers().map_err(|e| bad(1, e.to_string()))?.clone();
    let find = |wanted: &str| headers.iter().position(|h| h == wanted);
    for wanted in ["time_s"].iter().chain(&COLUMNS) {
        if headers.iter().filter(|h| h == wanted).count() > 1 {
            return Err(bad(
                1,
                format!("two columns are called {wanted}; rename one"),
            ));
        }
    }
    let Some(time) = find("time_s") else {
        return Err(bad(
            1,
            format!(
                "there is no column time_s; the first line must name the columns, with commas between: time_s and any of {}",
                COLUMNS.join(", ")
            ),
        ));
    };
    let places = COLUMNS.map(find);
    if places.iter().all(Option::is_none) {
        let any = COLUMNS.join(", ");
        return Err(bad(1, format!("beside time_s there is none of {any}")));
    }
    let mut times: Vec<f64> = Vec::new();
    let mut values = places.map(|place| place.map(|_| Vec::new()));
    let mut record = csv::StringRecord::new();
    let mut twice = false;
    loop {
        match reader.read_record(&mut record) {
            Ok(true) => {}
            Ok(false) => break,
            Err(e) => {
                let line = e.position().map_or(0, csv::Position::line);
                return Err(bad(line, unequal(&e)));
            }
        }
        // The reader's position is after the record; none of these has a line break within.
        let line = line_of(&reader, &record);
        let number = |column: usize| {
            let cell = record.get(column).unwrap_or("");
            let value = cell.parse::<f64>().ok().filter(|x| x.abs() <= LARGEST);
            let what = headers.get(column).unwrap_or("");
            value.ok_or_else(|| {
                let must_be = format!("must be a number from -{LARGEST:e} to {LARGEST:e}");
                bad(line, format!("{what} is '{cell}', {must_be}"))
            })
        };
        let now = number(time)?;
        let again = times.last() == Some(&now) && !twice;
        twice = again;
        match times[..] {
            // At a jump, as where a contact begins, a history has its instant twice: the later values count.
            [..] if again => {
                times.pop();
                values.iter_mut().flatten().for_each(|column| {
                    column.pop();
                });
            }
            [.., last] if now <= last => {
                return Err(bad(
                    line,
                    format!("time_s is {now} after {last}; times must rise from line to line"),
                ));
            }
            _ => {}
        }
        times.push(now);
        for (place, column) in places.iter().zip(&mut values) {
            if let (Some(place), Some(column)) = (place, column) {
                column.push(number(*place)?);
            }
        }
    }
    if times.len() < FEWEST_SAMPLES {
        return Err(UserError::new(format!(
            "{name}: samples below the first line: {}, at least 16 are needed",
            times.len()
        )));
    }
    let [force_n, displacement_mm, cart_mm] = values;
    Ok(Signal {
        name: name.to_owned(),
        time_s: times,
        force_n,
        displacement_mm,
        cart_mm,
    })
}

/// What the controller's sensors showed, by the calibration the log begins with.
fn from_log(path: &Path) -> Result<Signal, UserError> {
    let mut reader = Reader::open(path)?;
    let settings = reader.header().settings;
    let (mut times, mut force, mut hammer, mut cart) = (vec![], vec![], vec![], vec![]);
    while let Some(block) = reader.block()? {
        for (i, tick) in block.ticks.iter().enumerate() {
            times.push((block.first_tick + i as u64) as f64 * shared::settings::TICK_S);
            force.push(f64::from(settings.force.value(tick.frame.force)));
            hammer.push(f64::from(settings.hammer.value(tick.frame.hammer)) * 1e3);
            cart.push(f64::from(settings.cart.value(tick.frame.cart)) * 1e3);
        }
    }
    if times.len() < FEWEST_SAMPLES {
        return Err(UserError::new(format!(
            "{}: there are {} ticks in it, at least 16 are needed",
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
        let signal = parse("f", &text).unwrap();
        assert_eq!(signal.time_s[3], 0.003);
        assert_eq!(signal.force_n.as_ref().unwrap()[3], 6.0);
        assert_eq!(signal.displacement_mm, None);
        assert!((signal.sample_s() - 1e-3).abs() < 1e-12);
        assert_eq!(signal.between(0.002, 0.0185).unwrap().time_s.len(), 17);
        assert!(signal.between(0.5, 0.6).is_err());
    }

    #[test]
    fn an_instant_that_stands_twice_counts_once() {
        let text = format!("time_s,force_n\n{}1,2\n1,3\n2,4\n", rows(20));
        let signal = parse("f.csv", &text).unwrap();
        let force = signal.force_n.unwrap();
        assert_eq!((signal.time_s.len(), force.len()), (22, 22));
        assert_eq!(force[20..], [3.0, 4.0]);
    }

    #[test]
    fn a_bad_line_is_named() {
        let complaint = |text: String| parse("f.csv", &text).unwrap_err().to_string();
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
            ("1,2\n1,3\n1,4\n", "line 24: time_s is 1 after 1"),
            ("1,inf", "line 22: force_n is 'inf'"),
        ] {
            let said = complaint(format!("time_s,force_n\n{good}{bad}"));
            assert!(said.starts_with("f.csv, ") && said.contains(says), "{said}");
        }
        assert!(complaint(format!("time_s,force_n\n{}", rows(3))).contains("first line: 3"));
    }
}
