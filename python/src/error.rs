//! Errors as Python exceptions: what cannot be used is a `ValueError` that names the argument, and Ctrl-C is
//! `KeyboardInterrupt`.

use files::UserError;
use numerics::Error;
use pyo3::PyErr;
use pyo3::exceptions::{PyKeyboardInterrupt, PyValueError};

/// Options of the command line whose arguments are called otherwise here.
const RENAMED: [(&str, &str); 8] = [
    ("gap-tolerance-mm", "gap_tolerance_mm"),
    ("gap-ratio", "gap_ratio"),
    ("gap", "gap_mm"),
    ("frequency", "frequency_hz"),
    ("displacement", "displacement_mm"),
    ("velocity", "velocity_m_per_s"),
    ("initial", "start"),
    ("phase", "phases_turns"),
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
    let line = line.strip_prefix("--set: ").unwrap_or(line);
    let line = line.replace("--engine event", "engine=\"event\"");
    let mut parts = line.split("--");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let of_a_name = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        let end = part.find(|c| !of_a_name(c)).unwrap_or(part.len());
        let (option, rest) = part.split_at(end);
        text += &match RENAMED.iter().find(|(known, _)| *known == option) {
            Some((_, argument)) => (*argument).to_owned(),
            None if option.starts_with(|c: char| c.is_ascii_lowercase()) => {
                option.replace('-', "_")
            }
            None => format!("--{option}"),
        };
        text += rest;
    }
    text
}
