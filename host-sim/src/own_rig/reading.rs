//! A measured value as a person writes it, with its unit and how well it is known.

use std::fmt;

/// Readings farther apart than this share of the smallest are doubted.
const DOUBTFUL: f64 = 0.2;

/// What can be measured: the units it may be written in, and its range.
pub struct ReadingQuantity {
    /// What one of each unit is in SI; a unit "" means that none is needed.
    units: &'static [(&'static str, f64)],
    /// Lowest and highest value, SI.
    range: (f64, f64),
    /// The range for a person.
    words: &'static str,
}

const fn quantity(
    units: &'static [(&'static str, f64)],
    range: (f64, f64),
    words: &'static str,
) -> ReadingQuantity {
    ReadingQuantity {
        units,
        range,
        words,
    }
}

/// Weight of a body.
pub const MASS: ReadingQuantity = quantity(
    &[("g", 1e-3), ("kg", 1.0)],
    (1e-4, 1e5),
    "0.1 g to 100000 kg",
);
/// Length of the wires.
pub const WIRE_LENGTH: ReadingQuantity = quantity(LENGTHS, (1e-3, 100.0), "1 mm to 100 m");
/// Stroke of the cart.
pub const STROKE: ReadingQuantity = quantity(LENGTHS, (2e-6, 0.2), "0.002 mm to 200 mm");
/// Clearance at rest; negative: the hammer is pressed against the surface.
pub const GAP: ReadingQuantity = quantity(LENGTHS, (-0.1, 0.1), "-100 mm to 100 mm");
/// Time of some swings.
pub const SWING_TIME: ReadingQuantity = quantity(TIMES, (0.1, 1e5), "0.1 s to 100000 s");
/// Time of one contact.
pub const CONTACT_TIME: ReadingQuantity = quantity(TIMES, (1e-6, 1.0), "0.001 ms to 1000 ms");
/// A natural frequency: of the hammer, or of the shaker's position loop.
pub const FREQUENCY: ReadingQuantity = quantity(&[("Hz", 1.0)], (0.01, 1e4), "0.01 Hz to 10000 Hz");
/// Largest force of the shaker.
pub const FORCE: ReadingQuantity = quantity(
    &[("N", 1.0), ("kN", 1e3)],
    (1e-3, 1e6),
    "0.001 N to 1000 kN",
);
/// A damping ratio of beams.
pub const DAMPING_RATIO: ReadingQuantity = quantity(RATIOS, (0.0, 0.99), "0 to 0.99");
/// The damping ratio of a shaker's position loop.
pub const LOOP_DAMPING: ReadingQuantity = quantity(RATIOS, (0.0, 100.0), "0 to 100");
/// A coefficient of restitution. At 0.14 a spring-dashpot is damped critically.
pub const RESTITUTION: ReadingQuantity = quantity(
    RATIOS,
    (0.14, 0.999),
    "0.14 (a contact damped critically) to 0.999",
);

const LENGTHS: &[(&str, f64)] = &[("mm", 1e-3), ("cm", 1e-2), ("m", 1.0)];
const TIMES: &[(&str, f64)] = &[("s", 1.0), ("ms", 1e-3)];
const RATIOS: &[(&str, f64)] = &[("", 1.0), ("%", 1e-2)];

/// A value and its half-width, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnReading {
    /// The value: the mean, where there are several readings.
    pub value: f64,
    /// The true value lies within this of it, at 95 % where there are several readings.
    pub half_width: f64,
    /// As it was written.
    pub text: String,
    /// Where the half-width comes from.
    pub from: From,
    /// What is doubtful about it, for a person.
    pub doubt: Option<String>,
}

/// Where a half-width comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum From {
    /// It was written: 298+-1 g.
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

impl OwnReading {
    /// A value that nobody measured.
    pub fn assumed(value: f64, half_width: f64) -> Self {
        Self {
            value,
            half_width,
            text: String::new(),
            from: From::Stated,
            doubt: None,
        }
    }

    /// The half-width, % of the value.
    pub fn percent(&self) -> f64 {
        100.0 * (self.half_width / self.value).abs()
    }
}

/// A number as it was written.
struct Number<'a> {
    value: f64,
    /// Half of the step of its last digit.
    digit: f64,
    /// Whether its last digits may only fill it up: 1700.
    round: bool,
    unit: Option<&'a (&'static str, f64)>,
}

impl ReadingQuantity {
    /// Reads `298g`, `298+-1 g` (or `298±1 g`), or several readings with blanks or semicolons between them:
    /// `298 299 297.5 g`.
    ///
    /// # Errors
    /// In words that name the mend.
    pub fn read(&self, text: &str) -> Result<OwnReading, String> {
        self.read_in("", text)
    }

    /// Reads as [`Self::read`] does, with numbers without a unit taken in `unit`.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_in(&self, unit: &str, text: &str) -> Result<OwnReading, String> {
        let unit = self.unit(unit);
        let trimmed = text.trim();
        let plain;
        let stated = trimmed.split_once("+-").or(trimmed.split_once('±'));
        let (value, half_width, from, doubt) = match stated {
            Some((value, half)) => {
                let (mut value, mut half) = (self.numbers(value)?, self.numbers(half)?);
                let ([value], [half]) = (&mut value[..], &mut half[..]) else {
                    return Err(format!("'{trimmed}': write one value and one uncertainty"));
                };
                value.unit = value.unit.or(half.unit);
                plain = value.unit.is_none();
                value.unit = value.unit.or(unit);
                half.unit = half.unit.or(value.unit);
                (self.si(value)?, self.si(half)?, From::Stated, None)
            }
            None => {
                let mut numbers = self.numbers(trimmed)?;
                plain = numbers.iter().all(|number| number.unit.is_none());
                for number in &mut numbers {
                    number.unit = number.unit.or(unit);
                }
                self.of_readings(&numbers)?
            }
        };
        if half_width < 0.0 {
            return Err(format!("the uncertainty in '{trimmed}' is negative"));
        }
        let (low, high) = self.range;
        // What rounding alone makes of a limit is within it.
        let within = |x: f64| x >= low - 1e-9 * low.abs() && x <= high * (1.0 + 1e-9);
        if !within(value) {
            let words = self.words;
            return Err(format!("{trimmed} is out of range: write {words}"));
        }
        Ok(OwnReading {
            value,
            half_width,
            text: match unit {
                Some((name, _)) if plain => format!("{trimmed} {name}"),
                _ => trimmed.to_owned(),
            },
            from,
            doubt,
        })
    }

    /// The numbers of `text`, each with the unit that stands after it, or after later ones.
    fn numbers(&self, text: &str) -> Result<Vec<Number<'_>>, String> {
        let mut numbers: Vec<Number> = Vec::new();
        let words = text.split(|c: char| c == ';' || c.is_whitespace());
        // "298, 299": a comma before a blank separates.
        let words = words.map(|word| word.trim_end_matches(','));
        for word in words.filter(|word| !word.is_empty()) {
            let (digits, after) = word.split_at(end_of_number(word));
            if self.unit(word).is_none() {
                let (value, digit) = number(digits).ok_or_else(|| self.wrong(word))?;
                let round = digits.ends_with("00") && !digits.contains(['.', 'e', 'E']);
                numbers.push(Number {
                    value,
                    digit,
                    round,
                    unit: None,
                });
            }
            if !after.is_empty() {
                let unit = self.unit(after).ok_or_else(|| self.wrong(word))?;
                let open = numbers.iter_mut().filter(|number| number.unit.is_none());
                open.for_each(|number| number.unit = Some(unit));
            }
        }
        if numbers.is_empty() {
            return Err(self.wrong(text.trim()));
        }
        Ok(numbers)
    }

    fn unit(&self, word: &str) -> Option<&(&'static str, f64)> {
        let named = |(name, _): &&(&str, f64)| !name.is_empty() && name.eq_ignore_ascii_case(word);
        self.units.iter().find(named)
    }

    /// What a unit must be one of: `g or kg`.
    fn names(&self) -> String {
        let names = self.units.iter().map(|(name, _)| *name);
        let names: Vec<_> = names.filter(|name| !name.is_empty()).collect();
        names.join(" or ")
    }

    fn wrong(&self, word: &str) -> String {
        let apart = "several readings are separated by blanks";
        if let Some(write) = files::decimal::comma(word) {
            return format!("'{word}' has a comma: {write}; {apart}");
        }
        if word.contains(',') {
            return format!("'{word}' has commas: {apart}");
        }
        let number = word.chars().take_while(|c| c.is_ascii_digit()).count() > 0;
        match (number, self.names()) {
            (true, units) => format!("'{word}' has no known unit; write {units}"),
            (false, units) if units.is_empty() => format!("'{word}' is no number; write one"),
            (false, units) => format!("'{word}' is no number; write one with its unit, {units}"),
        }
    }

    /// `number` in SI units.
    fn si(&self, number: &Number) -> Result<f64, String> {
        let none = self.units.iter().find(|(name, _)| name.is_empty());
        match number.unit.or(none) {
            Some((_, factor)) => Ok(number.value * factor),
            None if number.value == 0.0 => Ok(0.0),
            None => Err(format!(
                "{} has no unit; write {} after it",
                number.value,
                self.names()
            )),
        }
    }

    /// Value, half-width, where that comes from, and what is doubtful.
    fn of_readings(&self, numbers: &[Number]) -> Result<(f64, f64, From, Option<String>), String> {
        let values: Vec<f64> = numbers
            .iter()
            .map(|x| self.si(x))
            .collect::<Result<_, _>>()?;
        let factor = |x: &Number| x.unit.map_or(1.0, |(_, factor)| *factor);
        let digits = numbers.iter().map(|x| x.digit * factor(x));
        let digit = digits.fold(0.0, f64::max);
        if let ([value], [number]) = (&values[..], numbers) {
            let doubt = number.round.then(|| {
                let unit = number.unit.map_or("", |(name, _)| name);
                let (value, digit) = (number.value, number.digit);
                format!(
                    "{value} {unit}: the assumed error is {digit} {unit}; if the value is rounded, write its error: {value}+-50 {unit}"
                )
            });
            return Ok((*value, digit, From::LastDigit, doubt));
        }
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
        let of_mean = (squares / (n - 1.0) / n).sqrt() * student_95(values.len() - 1);
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let apart = 100.0 * (high / low - 1.0);
        let doubt = (low > 0.0 && high > low * (1.0 + DOUBTFUL))
            .then(|| format!("the readings differ by {apart:.0} %; is one of them wrong?"));
        let from = From::Repeats(values.len());
        Ok((mean, of_mean.hypot(digit), from, doubt))
    }
}

/// Where the number ends that `word` begins with.
fn end_of_number(word: &str) -> usize {
    let mut ends = word.char_indices().map(|(at, c)| at + c.len_utf8());
    ends.rfind(|end| number(&word[..*end]).is_some())
        .unwrap_or(0)
}

/// A finite number, and half of the step of its last digit.
fn number(text: &str) -> Option<(f64, f64)> {
    let value: f64 = text.parse().ok().filter(|x: &f64| x.is_finite())?;
    let (digits, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
    let decimals = digits.split_once('.').map_or(0, |(_, after)| after.len());
    let exponent: i32 = exponent.parse().ok()?;
    let places = i32::try_from(decimals).ok()?;
    Some((value, 0.5 * 10f64.powi(exponent - places)))
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
    fn a_reading_has_its_unit_and_is_known_to_half_its_last_digit() {
        for (quantity, text, value, half) in [
            (&MASS, "298g", 0.298, 0.5e-3),
            (&MASS, "1.7kg", 1.7, 0.05),
            (&MASS, " 1700 g ", 1.7, 0.5e-3),
            (&MASS, "1.7e3g", 1.7, 0.05),
            (&MASS, "298+-2g", 0.298, 2e-3),
            (&MASS, "298 g ± 0.5 g", 0.298, 0.5e-3),
            (&MASS, "0.298kg+-1g", 0.298, 1e-3),
            (&WIRE_LENGTH, "31cm", 0.31, 5e-3),
            (&WIRE_LENGTH, "0.31 M", 0.31, 5e-3),
            (&STROKE, "4mm", 4e-3, 0.5e-3),
            (&GAP, "0", 0.0, 0.5),
            (&GAP, "0+-0.05mm", 0.0, 0.05e-3),
            (&CONTACT_TIME, "0.57ms", 0.57e-3, 0.005e-3),
            (&RESTITUTION, "0.32", 0.32, 0.005),
            (&RESTITUTION, "32%", 0.32, 0.005),
            (&FORCE, "0.06kN", 60.0, 5.0),
        ] {
            let reading = quantity.read(text).unwrap();
            assert!((reading.value - value).abs() <= 1e-12, "{text}");
            assert!((reading.half_width - half).abs() <= 1e-9, "{text}");
        }
    }

    #[test]
    fn a_number_without_a_unit_is_in_the_one_that_was_asked_for() {
        for (quantity, unit, text, value, half, shown) in [
            (&FREQUENCY, "Hz", "30", 30.0, 0.5, "30 Hz"),
            (
                &STROKE,
                "mm",
                "1.78+-0.05",
                1.78e-3,
                0.05e-3,
                "1.78+-0.05 mm",
            ),
            (&STROKE, "mm", "0.2cm", 2e-3, 0.5e-3, "0.2cm"),
            (&STROKE, "mm", "0.2+-0.1cm", 2e-3, 1e-3, "0.2+-0.1cm"),
            (&GAP, "mm", "0", 0.0, 0.5e-3, "0 mm"),
        ] {
            let reading = quantity.read_in(unit, text).unwrap();
            assert!((reading.value - value).abs() <= 1e-12, "{text}");
            assert!((reading.half_width - half).abs() <= 1e-9, "{text}");
            assert_eq!(reading.text, shown);
        }
        let time = SWING_TIME.read_in("s", "10.99 11.02").unwrap();
        assert_eq!(time.text, "10.99 11.02 s");
        assert!((time.value - 11.005).abs() < 1e-9, "{time:?}");
    }

    #[test]
    fn a_mistake_is_named_with_its_mend() {
        for (quantity, text, said) in [
            (&SWING_TIME, "10,99s", "write 10.99 with a point"),
            (&MASS, "1,7 kg", "write 1.7 with a point"),
            (&MASS, "298,299,297.5 g", "separated by blanks"),
            (&MASS, "298 299,5 g", "write 299.5 with a point"),
            (&MASS, "298", "298 has no unit; write g or kg after it"),
            (&MASS, "298 lb", "write one with its unit, g or kg"),
            (&MASS, "298lb", "no known unit; write g or kg"),
            (&MASS, "heavy", "is no number"),
            (&MASS, "", "is no number"),
            (&MASS, "nan g", "is no number"),
            (&MASS, "1+-", "is no number"),
            (&MASS, "1kg+--1kg", "is negative"),
            (&MASS, "-1kg", "0.1 g to 100000 kg"),
            (&WIRE_LENGTH, "0.04mm", "out of range: write 1 mm to 100 m"),
            (&STROKE, "1800mm", "0.002 mm to 200 mm"),
            (&RESTITUTION, "0.1", "0.14 (a contact damped critically)"),
        ] {
            let why = quantity.read(text).unwrap_err();
            assert!(why.contains(said), "{text}: {why}");
        }
    }

    /// Mean 298.167, standard deviation 0.764, of three: 0.764/√3 · 4.303 = 1.897; with the last digit's 0.5: 1.962.
    #[test]
    fn several_readings_scatter() {
        for text in [
            "298 299 297.5 g",
            "298;299;297.5g",
            "298g; 299g; 297.5g",
            "298, 299, 297.5 g",
        ] {
            let reading = MASS.read(text).unwrap();
            assert!((reading.value - 0.298_166_7).abs() < 1e-6, "{text}");
            assert!((reading.half_width - 1.962e-3).abs() < 2e-6, "{reading:?}");
            assert_eq!((reading.from, reading.doubt), (From::Repeats(3), None));
        }
    }

    #[test]
    fn what_is_doubtful_is_said() {
        let doubt = |text| MASS.read(text).unwrap().doubt.unwrap_or_default();
        assert!(doubt("298 360 g").contains("differ by 21 %"));
        assert!(doubt("1700g").contains("error is 0.5 g"));
        for text in ["298 355 g", "310g", "1.7kg", "1700+-50g"] {
            assert_eq!(doubt(text), "", "{text}");
        }
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
