//! `FROM:TO:STEP`.

use files::decimal::hint;

/// A range has at most so many values.
const MOST: f64 = 1e6;

/// The values of `FROM:TO:STEP`, both ends included.
///
/// # Errors
/// If it is not three finite numbers, FROM is above TO, STEP is not positive, or there are more than a million values.
pub fn parse_range(text: &str) -> Result<Vec<f64>, String> {
    let parts: Vec<_> = text.split(':').map(|t| t.trim().parse::<f64>()).collect();
    let [Ok(from), Ok(to), Ok(step)] = parts.as_slice() else {
        let write = hint(text);
        return Err(format!(
            "write FROM:TO:STEP, for example 1.0:3.0:0.01{write}"
        ));
    };
    let (from, to, step) = (*from, *to, *step);
    if !(from.is_finite() && to.is_finite() && step.is_finite()) {
        return Err("every part must be a finite number".to_owned());
    }
    if from != to {
        rising(from, to)?;
    }
    if step <= 0.0 {
        return Err(format!("STEP is {step}, must be positive"));
    }
    let count = ((to - from) / step + 1e-9).floor() + 1.0;
    if count > MOST {
        return Err(format!(
            "that is {count:.0} values, more than {MOST:.0}; use a larger STEP"
        ));
    }
    Ok((0..count as u64).map(|i| from + i as f64 * step).collect())
}

/// The values of `FROM:TO:STEP`, both ends included, or the one number that `text` is.
///
/// # Errors
/// If it is neither.
pub fn range_or_value(text: &str) -> Result<Vec<f64>, String> {
    if text.contains(':') {
        return parse_range(text);
    }
    let value = text.trim().parse();
    value.map_or_else(
        |_| Err(format!("write FROM:TO:STEP, or one number{}", hint(text))),
        |value| Ok(vec![value]),
    )
}

/// Refuses a range that does not rise.
///
/// # Errors
/// If it does not.
pub fn rising(from: f64, to: f64) -> Result<(), String> {
    if from > to {
        return Err(format!("FROM ({from}) is above TO ({to}); swap them"));
    }
    if from == to {
        return Err(format!("FROM and TO are both {from}; widen the range"));
    }
    Ok(())
}

/// Values of a parameter, and whether they are spaced by factors.
#[derive(Clone, Debug, PartialEq)]
pub struct RangeValues {
    /// In the order given.
    pub list: Vec<f64>,
    /// Whether they are spaced by even factors.
    pub log: bool,
}

/// The values of `FROM:TO:STEP`, `FROM:TO:linN`, `FROM:TO:logN`, or with commas between them.
///
/// # Errors
/// If they cannot be read, N is not from 2 to a million, or FROM and TO of `logN` are not positive.
pub fn parse_values(text: &str) -> Result<RangeValues, String> {
    let number = |text: &str| {
        parse_finite(text).ok_or_else(|| format!("'{}' is no finite number", text.trim()))
    };
    let parts: Vec<&str> = text.split(':').map(str::trim).collect();
    let [from, to, spacing] = parts.as_slice() else {
        if let Some(doubt) = doubtful(text) {
            return Err(doubt);
        }
        let list: Result<Vec<f64>, _> = text.split(',').map(number).collect();
        let list = list.map_err(|why| {
            format!("{why}; write FROM:TO:STEP, FROM:TO:linN, FROM:TO:logN, or values with commas")
        })?;
        return Ok(RangeValues { list, log: false });
    };
    let (log, count) = match (spacing.strip_prefix("log"), spacing.strip_prefix("lin")) {
        (Some(count), _) => (true, count),
        (None, Some(count)) => (false, count),
        (None, None) => {
            return parse_range(text).map(|list| RangeValues { list, log: false });
        }
    };
    let (from, to) = (number(from)?, number(to)?);
    let count: u32 = count.parse().map_err(|_| {
        format!("{spacing}: write the number of values after it, for example log20")
    })?;
    if !(2..=MOST as u32).contains(&count) {
        return Err(format!(
            "{spacing}: there must be from 2 to {MOST:.0} values"
        ));
    }
    rising(from, to)?;
    if log && from <= 0.0 {
        return Err(format!("FROM is {from}, must be positive for {spacing}"));
    }
    let last = f64::from(count - 1);
    let at = |i: u32| match i {
        // The ends as they were written.
        0 => from,
        i if i == count - 1 => to,
        i if log => from * (to / from).powf(f64::from(i) / last),
        i => from + (to - from) * f64::from(i) / last,
    };
    let list = (0..count).map(at).collect();
    Ok(RangeValues { list, log })
}

/// What is doubtful about a list whose commas may all separate, or every other one be decimal: 1,8 or 1,7,2,5.
fn doubtful(text: &str) -> Option<String> {
    /// Values shown of either meaning.
    const SHOWN: usize = 8;
    let whole = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
    let parts: Vec<&str> = text.split(',').collect();
    let pairs: Vec<&[&str]> = parts.chunks(2).collect();
    let may_be_one = |pair: &&[&str]| match pair {
        [first, second] => whole(first.trim_start_matches(['+', '-'])) && whole(second),
        _ => false,
    };
    if !pairs.iter().all(may_be_one) {
        return None;
    }
    if let [first, second] = parts[..] {
        return Some(format!(
            "'{text}' may be one value or two: write {first}.{second} with a point, or {first}.0,{second} for two"
        ));
    }
    let joined = |all: Vec<String>| {
        let more = if parts.len() > SHOWN { ",..." } else { "" };
        all.join(",") + more
    };
    let pointed = joined(pairs.iter().take(SHOWN / 2).map(|p| p.join(".")).collect());
    let apart = joined(parts.iter().take(SHOWN).map(|p| format!("{p}.0")).collect());
    let (few, many) = (pairs.len(), parts.len());
    Some(format!(
        "'{text}' may be {few} values or {many}: write {pointed} with a point each, or {apart} for {many}"
    ))
}

/// The number that `text` is, blanks around it aside; none if it is not a finite number.
pub fn parse_finite(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|x: &f64| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_spaced_as_asked() {
        let list = |text: &str| parse_values(text).unwrap().list;
        assert_eq!(list("1:3:lin5"), [1.0, 1.5, 2.0, 2.5, 3.0]);
        assert_eq!(list("0:1:0.5"), [0.0, 0.5, 1.0]);
        assert_eq!(list("5,2,2.5"), [5.0, 2.0, 2.5]);
        assert_eq!(list("1.0,8"), [1.0, 8.0]);
        assert_eq!(list("-0.1"), [-0.1]);
        assert_eq!(list("1,2,5"), [1.0, 2.0, 5.0]);
        assert_eq!(list("1, 7, 2, 5"), [1.0, 7.0, 2.0, 5.0]);
        assert_eq!(list("1.0,7,2,5"), [1.0, 7.0, 2.0, 5.0]);
        assert_eq!(list("1,-7"), [1.0, -7.0]);
        let log = parse_values("1e5:1e7:log3").unwrap();
        assert!(log.log && log.list.len() == 3);
        assert_eq!((log.list[0], log.list[2]), (1e5, 1e7));
        assert!((log.list[1] / 1e6 - 1.0).abs() < 1e-12);
        for bad in [
            "",
            "1:2",
            "1:2:log",
            "1:2:log1",
            "0:1:log5",
            "2:1:lin5",
            "1,a",
            "1:2:cube5",
            "1:nan:lin3",
            "1,8",
            "1,7,2,5",
            "-1,7,+2,5,3,0",
            "0,5:1,5:lin3",
        ] {
            assert!(parse_values(bad).is_err(), "{bad}");
        }
        assert!(
            parse_values("1:0.1:lin5")
                .unwrap_err()
                .contains("swap them")
        );
    }

    #[test]
    fn commas_that_may_be_decimal_are_doubted_and_either_mend_is_read() {
        let doubt = |text: &str| parse_values(text).unwrap_err();
        assert_eq!(
            doubt("1,8"),
            "'1,8' may be one value or two: write 1.8 with a point, or 1.0,8 for two"
        );
        assert_eq!(
            doubt("1,7,2,5"),
            "'1,7,2,5' may be 2 values or 4: write 1.7,2.5 with a point each, or 1.0,7.0,2.0,5.0 for 4"
        );
        assert_eq!(parse_values("1.7,2.5").unwrap().list, [1.7, 2.5]);
        assert_eq!(parse_values("1.0,7.0,2.0,5.0").unwrap().list.len(), 4);
        let long = ["1"; 20].join(",");
        let short = "write 1.1,1.1,1.1,1.1,... with a point each";
        assert!(doubt(&long).contains(short), "{}", doubt(&long));
        for (bad, said) in [
            (parse_range("0:1,5:0.5"), "; write 1.5 with a point"),
            (
                range_or_value("1,7"),
                "or one number; write 1.7 with a point",
            ),
        ] {
            assert!(bad.unwrap_err().ends_with(said), "{said}");
        }
    }

    #[test]
    fn ranges_include_both_ends_and_a_single_value_is_allowed() {
        assert_eq!(
            parse_range("1:2:0.25").unwrap(),
            [1.0, 1.25, 1.5, 1.75, 2.0]
        );
        assert_eq!(parse_range("1.5:1.5:1").unwrap(), [1.5]);
        assert_eq!(parse_range("0:0.3:0.1").unwrap().len(), 4);
        for bad in [
            "", "1:2", "2:1:0.1", "1:2:0", "1:2:-1", "a:b:c", "1:inf:1", "0:1e9:1",
        ] {
            assert!(parse_range(bad).is_err(), "{bad}");
        }
    }
}
