//! What is refused before anything is sent to a board.

use std::path::Path;

use shared::settings::TICK_RATE_HZ;

use super::What;
use super::sweep::frequencies;
use files::UserError;
use files::range::positive;

/// Refuses numbers out of range before anything is sent to a board.
pub fn check(what: &What) -> Result<(), UserError> {
    let between = |option: &str, value: f64, least: f64, most: f64| {
        if (least..=most).contains(&value) {
            return Ok(());
        }
        Err(UserError::new(format!(
            "{option} is {value:?}, must be a number from {least} to {most}"
        )))
    };
    let given =
        |option: &str, value: Option<f64>| value.map_or(Ok(()), |v| positive(option, v).map(drop));
    let day = |option: &str, seconds: f64| between(option, seconds, 1e-3, 86_400.0);
    let for_so_long = |value: Option<f64>| value.map_or(Ok(()), |v| day("--for", v));
    match what {
        What::Start(start) => {
            given("--frequency", start.frequency)?;
            given("--amplitude", start.amplitude)?;
            for_so_long(start.duration_s)
        }
        What::SetBrownOut(set) if !set.yes => Err(UserError::new(
            "this writes the processor's option bytes, and a power cut in that second can lock the processor; leave the board on its plug and say --yes",
        )),
        What::Record(record) => {
            day("--for", record.duration_s)?;
            unless_there([record.out.as_path()])
        }
        What::Sweep(plan) => {
            positive("--from-hz", plan.from_hz)?;
            positive("--step-hz", plan.step_hz)?;
            day("--settle", plan.settle)?;
            day("--measure", plan.measure)?;
            given("--amplitude", plan.amplitude)?;
            frequencies(plan)?;
            unless_there([&plan.csv, &plan.csv.with_extension("json")])
        }
        What::Monitor { duration_s, rate } => {
            between("--rate", *rate, 1e-3, f64::from(TICK_RATE_HZ))?;
            for_so_long(*duration_s)
        }
        _ => Ok(()),
    }
}

/// Refuses to replace what was measured before: the same command does not measure the same again.
fn unless_there<const N: usize>(files: [&Path; N]) -> Result<(), UserError> {
    let mut files = files.into_iter();
    match files.find(|file| file.symlink_metadata().is_ok()) {
        Some(file) => Err(UserError::new(format!(
            "{} exists already, and a measurement is not replaced; choose another name or remove it",
            file.display()
        ))),
        None => Ok(()),
    }
}
