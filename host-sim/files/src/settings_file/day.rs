//! A day in a settings file, such as the day of a calibration.

/// A day as its number: of "2026-11-23", 20261123. Whether there is such a day is checked with all settings.
pub fn number(text: &str) -> Option<u32> {
    if text == "never" {
        return Some(0);
    }
    let numbers: Vec<u32> = text
        .split('-')
        .map(|part| part.parse().ok())
        .collect::<Option<_>>()?;
    match numbers[..] {
        [year, month @ 0..100, date @ 0..100] if year < 10_000 => {
            Some(year * 10_000 + month * 100 + date)
        }
        _ => None,
    }
}

/// The day of a number, as a file has it.
pub fn text(day: u32) -> String {
    match day {
        0 => "never".into(),
        _ => format!(
            "{:04}-{:02}-{:02}",
            day / 10_000,
            day / 100 % 100,
            day % 100
        ),
    }
}
