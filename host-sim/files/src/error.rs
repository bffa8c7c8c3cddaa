//! What is told to a person whose input cannot be used: one line that says what, where and the mend.

use std::fmt;

/// One clear line. The command line prints it and exits with code 2.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UserError(String);

impl UserError {
    /// From the line itself.
    pub fn new(line: impl Into<String>) -> Self {
        Self(line.into())
    }

    /// The same line, said to come from `place`.
    #[must_use]
    pub fn at(self, place: impl fmt::Display) -> Self {
        Self(format!("{place}: {}", self.0))
    }
}

impl fmt::Display for UserError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for UserError {}

macro_rules! from_line {
    ($($error:ty),*) => {$(
        impl From<$error> for UserError {
            fn from(error: $error) -> Self {
                Self(error.to_string())
            }
        }
    )*};
}

from_line!(
    shared::model::params::ParamError,
    shared::model::drive::DriveError,
    crate::write::WriteError
);
