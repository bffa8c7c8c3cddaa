//! The error of everything that a person can mend: one line that says what is wrong, where, and what to do.

use std::fmt;

use numerics::error::{Error, MapError, MotionError, StartError};
use shared::model::drive::DriveError;
use shared::model::params::ParamError;

/// One clear line. The command line prints it and exits with code 2.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UserError(String);

impl UserError {
    /// From the line itself.
    pub fn new(line: impl Into<String>) -> Self {
        Self(line.into())
    }

    /// Puts the place that the line is about (a file, a line of it, an option) and a colon before it.
    #[must_use]
    pub fn at(self, place: impl fmt::Display) -> Self {
        Self(format!("{place}: {}", self.0))
    }

    /// Puts `place` before a line about a setting that nobody wrote as --set: a leading `--set: ` is dropped.
    #[must_use]
    pub fn at_setting(self, place: impl fmt::Display) -> Self {
        let line = self.0.strip_prefix("--set: ").unwrap_or(&self.0);
        Self::new(line).at(place)
    }
}

impl fmt::Display for UserError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for UserError {}

macro_rules! from {
    ($($error:ty),*) => {$(
        impl From<$error> for UserError {
            fn from(error: $error) -> Self {
                Self(error.to_string())
            }
        }
    )*};
}

from!(
    ParamError,
    DriveError,
    Error,
    MapError,
    StartError,
    MotionError
);
