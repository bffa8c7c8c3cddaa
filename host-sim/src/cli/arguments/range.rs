//! `FROM:TO:STEP`.

/// Values at most.
const MOST: f64 = 1e6;

/// The values of `FROM:TO:STEP`, both ends included.
///
/// # Errors
/// If it is not three finite numbers, FROM is above TO, STEP is not positive, or there are more than a million values.
pub fn parse_range(text: &str) -> Result<Vec<f64>, String> {
    let parts: Vec<_> = text.split(':').map(|t| t.trim().parse::<f64>()).collect();
    let [Ok(from), Ok(to), Ok(step)] = parts.as_slice() else {
        return Err("write FROM:TO:STEP, for example 1.0:3.0:0.01".to_owned());
    };
    let (from, to, step) = (*from, *to, *step);
    if !(from.is_finite() && to.is_finite() && step.is_finite()) {
        return Err("every part must be a finite number".to_owned());
    }
    if from > to {
        return Err(format!("FROM ({from}) is above TO ({to}); swap them"));
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

/// A finite number.
pub fn parse_finite(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|x: &f64| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

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
