//! What is refused before anything is sent to a board.

use std::path::Path;

use super::super::arguments::output::check_format;
use super::What;
use super::sweep::frequencies;
use files::UserError;

/// Refuses numbers out of range before anything is sent to a board.
pub fn check(what: &What) -> Result<(), UserError> {
    let positive = |option: &str, value: f64| {
        if value > 0.0 && value.is_finite() {
            return Ok(());
        }
        Err(UserError::new(format!(
            "{option} is {value}, must be a positive number"
        )))
    };
    let given = |option: &str, value: Option<f64>| value.map_or(Ok(()), |v| positive(option, v));
    match what {
        What::Start(start) => {
            given("--frequency", start.frequency)?;
            given("--amplitude", start.amplitude)?;
            given("--for", start.duration_s)
        }
        What::Record(record) => {
            positive("--for", record.duration_s)?;
            unless_there([record.out.as_path()], record.replace)
        }
        What::Sweep(plan) => {
            positive("--from-hz", plan.from_hz)?;
            positive("--step-hz", plan.step_hz)?;
            positive("--settle", plan.settle)?;
            positive("--measure", plan.measure)?;
            given("--amplitude", plan.amplitude)?;
            frequencies(plan)?;
            unless_there([&plan.csv, &plan.csv.with_extension("json")], plan.replace)
        }
        What::Monitor { duration_s, rate } => {
            positive("--rate", *rate)?;
            given("--for", *duration_s)
        }
        What::Forecast { format } => check_format(*format, false),
        _ => Ok(()),
    }
}

/// Refuses to replace what was measured before.
fn unless_there<const N: usize>(files: [&Path; N], replace: bool) -> Result<(), UserError> {
    match files.into_iter().find(|file| file.exists()) {
        Some(file) if !replace => Err(UserError::new(format!(
            "{} is there already; give another name, or --replace to replace it",
            file.display()
        ))),
        _ => Ok(()),
    }
}
