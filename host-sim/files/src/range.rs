//! The range that a number must be in, and the line that refuses one which is not.

use std::fmt::Display;

use crate::UserError;

/// The value of `name` if it is from `low` to `high`.
///
/// # Errors
/// If it is not.
pub fn within<T: PartialOrd + Display>(
    name: &str,
    value: T,
    low: T,
    high: T,
) -> Result<T, UserError> {
    let must_be = || format!("from {low} to {high}");
    only_if(value >= low && value <= high, name, value, must_be)
}

/// The value of `name` if it is from `low` to below `end`.
///
/// # Errors
/// If it is not.
pub fn below(name: &str, value: f64, low: f64, end: f64) -> Result<f64, UserError> {
    let must_be = || format!("from {low} to below {end}");
    only_if(value >= low && value < end, name, value, must_be)
}

/// The value of `name` if it is no more than `most`.
///
/// # Errors
/// If it is more.
pub fn at_most(name: &str, value: u32, most: u32) -> Result<u32, UserError> {
    only_if(value <= most, name, value, || format!("at most {most}"))
}

/// The value of `name` if it is positive and finite.
///
/// # Errors
/// If it is not.
pub fn positive(name: &str, value: f64) -> Result<f64, UserError> {
    let is = value > 0.0 && value.is_finite();
    only_if(is, name, value, || "a positive number".to_owned())
}

fn only_if<T: Display>(
    allowed: bool,
    name: &str,
    value: T,
    must_be: impl FnOnce() -> String,
) -> Result<T, UserError> {
    if allowed {
        return Ok(value);
    }
    let must_be = must_be();
    Err(UserError::new(format!(
        "{name} is {value}, must be {must_be}"
    )))
}
