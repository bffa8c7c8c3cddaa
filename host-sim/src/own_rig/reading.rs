//! A measured value as a person writes it, with how well it is known.

use std::fmt;

/// A value and its half-width, in the unit it was written in.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// The value: the mean, where there are several readings.
    pub value: f64,
    /// The true value lies within this of it, at 95 % where there are several readings.
    pub half_width: f64,
    /// As it was written.
    pub text: String,
    /// Where the half-width comes from.
    pub from: From,
}

/// Where a half-width comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum From {
    /// It was written: 298+-1.
    Stated,
    /// From the scatter of so many readings, and the last digit written.
    Repeats(usize),
    /// From the last digit written.
    LastDigit,
}

impl fmt::Display for From {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stated => f.write_str("as stated"),
            Self::Repeats(n) => write!(f, "from the scatter of {n} readings"),
            Self::LastDigit => f.write_str("from the last digit written"),
        }
    }
}

impl Reading {
    /// A value that nobody measured.
    pub fn assumed(value: f64, half_width: f64) -> Self {
        Self {
            value,
            half_width,
            text: String::new(),
            from: From::Stated,
        }
    }

    /// The half-width, % of the value.
    pub fn percent(&self) -> f64 {
        100.0 * (self.half_width / self.value).abs()
    }
}

/// Reads `298`, `298+-1` (or `298±1`), or several readings with commas between them: `298, 299, 297.5`.
///
/// # Errors
/// In words, for the end of a line that begins with what was asked for.
pub fn read(text: &str) -> Result<Reading, String> {
    let trimmed = text.trim();
    let stated = trimmed.split_once("+-").or(trimmed.split_once('±'));
    let (value, half_width, from) = match stated {
        Some((value, half)) => (number(value)?.0, number(half)?.0, From::Stated),
        None => {
            let numbers: Result<Vec<_>, _> = trimmed.split(',').map(number).collect();
            of_readings(&numbers?)
        }
    };
    if half_width < 0.0 {
        return Err(format!("the uncertainty in {trimmed} is negative"));
    }
    Ok(Reading {
        value,
        half_width,
        text: trimmed.to_owned(),
        from,
    })
}

/// A finite number, and half of the step of its last digit.
fn number(text: &str) -> Result<(f64, f64), String> {
    let text = text.trim();
    let wrong = || {
        format!("'{text}' is no number; write 298, or 298+-1, or several readings: 298,299,297.5")
    };
    let value: f64 = text.parse().map_err(|_| wrong())?;
    if !value.is_finite() {
        return Err(wrong());
    }
    let (digits, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
    let decimals = digits.split_once('.').map_or(0, |(_, after)| after.len());
    let exponent: i32 = exponent.parse().map_err(|_| wrong())?;
    let places = i32::try_from(decimals).map_err(|_| wrong())?;
    Ok((value, 0.5 * 10f64.powi(exponent - places)))
}

fn of_readings(numbers: &[(f64, f64)]) -> (f64, f64, From) {
    let digit = numbers.iter().map(|(_, half)| *half).fold(0.0, f64::max);
    if let [(value, _)] = numbers {
        return (*value, digit, From::LastDigit);
    }
    let n = numbers.len() as f64;
    let mean = numbers.iter().map(|(x, _)| x).sum::<f64>() / n;
    let squares: f64 = numbers.iter().map(|(x, _)| (x - mean).powi(2)).sum();
    let of_mean = (squares / (n - 1.0) / n).sqrt() * student_95(numbers.len() - 1);
    (mean, of_mean.hypot(digit), From::Repeats(numbers.len()))
}

/// The 97.5 % quantile of Student's distribution: the table up to 10 degrees of freedom, beyond it within 1 %.
fn student_95(degrees: usize) -> f64 {
    const TABLE: [f64; 10] = [
        12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228,
    ];
    let beyond = 1.96 + 2.5 / degrees as f64;
    TABLE
        .get(degrees.wrapping_sub(1))
        .copied()
        .unwrap_or(beyond)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_reading_is_known_to_half_its_last_digit() {
        for (text, value, half) in [
            ("298", 298.0, 0.5),
            (" 0.89 ", 0.89, 0.005),
            ("5.5e6", 5.5e6, 5e4),
            ("298+-2", 298.0, 2.0),
            ("298 ± 0.5", 298.0, 0.5),
        ] {
            let reading = read(text).unwrap();
            assert!((reading.value - value).abs() <= 1e-12 * value, "{text}");
            assert!((reading.half_width - half).abs() <= 1e-9 * half, "{text}");
        }
        for bad in ["", "heavy", "1,,2", "nan", "1+-", "1+--1", "1;2"] {
            assert!(read(bad).is_err(), "{bad}");
        }
    }

    /// Mean 298.167, standard deviation 0.764, of three: 0.764/√3 · 4.303 = 1.897; with the last digit's 0.5: 1.962.
    #[test]
    fn several_readings_scatter() {
        let reading = read("298, 299, 297.5").unwrap();
        assert!((reading.value - 298.1667).abs() < 1e-3);
        assert!((reading.half_width - 1.962).abs() < 2e-3, "{reading:?}");
        assert_eq!(reading.from, From::Repeats(3));
    }

    #[test]
    fn students_quantiles_beyond_the_table_are_close() {
        for (degrees, exact) in [
            (11, 2.201),
            (15, 2.131),
            (20, 2.086),
            (30, 2.042),
            (120, 1.980),
        ] {
            assert!(
                (student_95(degrees) / exact - 1.0).abs() < 0.01,
                "{degrees}"
            );
        }
    }
}
