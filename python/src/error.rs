//! Errors as Python exceptions: what cannot be used is a `ValueError` that names the argument, and Ctrl-C is
//! `KeyboardInterrupt`.

use files::UserError;
use numerics::Error;
use pyo3::PyErr;
use pyo3::exceptions::{PyKeyboardInterrupt, PyValueError};

/// Options of the command line whose arguments are called otherwise here.
const RENAMED: [(&str, &str); 9] = [
    ("--gap-tolerance-mm", "gap_tolerance_mm"),
    ("--gap-ratio", "gap_ratio"),
    ("--gap", "gap_mm"),
    ("--frequency", "frequency_hz"),
    ("--displacement", "displacement_mm"),
    ("--velocity", "velocity_m_per_s"),
    ("--initial", "start"),
    ("--phase", "phases_turns"),
    ("--engine event", "engine=\"event\""),
];

/// A mistake of the caller's.
pub fn wrong(what: impl Into<String>) -> PyErr {
    PyValueError::new_err(as_arguments(&what.into()))
}

/// The exception for an error of the rig files or the analyses.
pub fn from_user(error: UserError) -> PyErr {
    wrong(error.to_string())
}

/// The exception for an error of the analyses.
pub fn from_numerics(error: Error) -> PyErr {
    match error {
        Error::Interrupted => PyKeyboardInterrupt::new_err(()),
        other => from_user(other.into()),
    }
}

/// A sentence of the command line with its options named as arguments: `--max-force-n` becomes `max_force_n`.
fn as_arguments(line: &str) -> String {
    let mut line = line.strip_prefix("--set: ").unwrap_or(line).to_owned();
    for (option, argument) in RENAMED {
        // Only the whole option: --gap must not change --gap-ratio.
        let whole = |rest: &str| !rest.starts_with(|c: char| c == '-' || c.is_alphanumeric());
        let mut from = 0;
        while let Some(at) = line[from..].find(option).map(|i| i + from) {
            let end = at + option.len();
            if whole(&line[end..]) {
                line.replace_range(at..end, argument);
            }
            from = at + 1;
        }
    }
    let mut text = String::with_capacity(line.len());
    let mut rest = line.as_str();
    while let Some(at) = rest.find("--") {
        let (before, option) = (&rest[..at], &rest[at + 2..]);
        let named = option.starts_with(|c: char| c.is_ascii_lowercase());
        let length = match named {
            true => option
                .find(|c: char| !(c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-'))
                .unwrap_or(option.len()),
            false => 0,
        };
        text += before;
        match named {
            true => text += &option[..length].replace('-', "_"),
            false => text += "--",
        }
        rest = &option[length..];
    }
    text + rest
}
