//! `host-sim identify --coverage`: how often the intervals hold the truth.

use serde_json::json;

use super::arguments::output::OutputArgs;
use crate::progress::ProgressLine;
use files::UserError;
use files::range::within;
use numerics::identify::Misfit;
use numerics::identify::coverage::{CoverageCase, CoverageRow, cases, table};

/// Most drop tests of a case.
const MOST: usize = 10_000;

#[derive(Debug, clap::Args)]
pub struct CoverageArgs {
    /// Instead of a file: make drop tests with faulty sensors from the model, identify each, and count the 95 % intervals
    /// that contain the true value
    #[arg(long, conflicts_with_all = [
        "file", "law", "all_laws", "release_mm", "seek_release", "seek_exponent", "impacts", "rig", "set", "gap",
    ])]
    coverage: bool,

    /// Drop tests of each case of the coverage
    #[arg(long, value_name = "N", default_value_t = 50, requires = "coverage")]
    tests: usize,

    /// Only this case of the coverage; may be given several times
    #[arg(long, value_name = "NAME", requires = "coverage")]
    case: Vec<String>,

    /// Seed of the random numbers of the coverage
    #[arg(long, value_name = "N", default_value_t = 1, requires = "coverage")]
    seed: u64,
}

impl CoverageArgs {
    /// Whether the coverage is wanted.
    pub fn wanted(&self) -> bool {
        self.coverage
    }

    /// The cases asked for.
    fn cases(&self) -> Result<Vec<CoverageCase>, UserError> {
        let all = cases();
        let known = |name: &&String| all.iter().any(|case| case.name == **name);
        if let Some(unknown) = self.case.iter().find(|name| !known(name)) {
            let names: Vec<_> = all.iter().map(|case| case.name).collect();
            return Err(UserError::new(format!(
                "--case {unknown} is none of {}",
                names.join(", ")
            )));
        }
        let chosen =
            |case: &CoverageCase| self.case.is_empty() || self.case.iter().any(|n| n == case.name);
        Ok(all.into_iter().filter(chosen).collect())
    }

    /// Simulates and identifies the drop tests, and answers with a row for each parameter of each case.
    pub fn run(&self, misfit: Option<Misfit>, output: &OutputArgs) -> Result<(), UserError> {
        within("--tests", self.tests, 1, MOST)?;
        let output = &output.about(None)?;
        let cases = self.cases()?;
        let misfits = misfit.map_or(vec![Misfit::Force, Misfit::Peaks], |m| vec![m]);
        let work = cases.len() * misfits.len() * self.tests;
        let progress = ProgressLine::new("drop tests", work as u64, output.quiet);
        let rows = table(&cases, &misfits, self.tests, self.seed, &progress)?;
        progress.finish();
        let answer = json!({ "tests": self.tests, "seed": self.seed, "rows": rows });
        output.answer(&answer, &rows, || Ok(Vec::new()), || self.text(&rows))
    }

    fn text(&self, rows: &[CoverageRow]) -> String {
        let mut text = format!(
            "{} drop tests of each case, seed {}: how often the answer is right (the 95 % interval holds the truth, or a law\n\
             that is not the record's is refused)\n\n{:<24} {:<6} {:<30} {:>5} {:>7} {:>9} {:>6} {:>9} {:>11}\n",
            self.tests,
            self.seed,
            "case",
            "misfit",
            "parameter",
            "right",
            "refused",
            "unbounded",
            "failed",
            "error, %",
            "interval, %"
        );
        let number = |value: Option<f64>, sign: &str| {
            value.map_or("-".to_owned(), |value| format!("{sign}{:.2}", value.abs()))
        };
        for row in rows {
            let sign = row
                .median_error_percent
                .map_or("", |e| if e < 0.0 { "-" } else { "+" });
            text += &format!(
                "{:<24} {:<6} {:<30} {:>5} {:>7} {:>9} {:>6} {:>9} {:>11}\n",
                row.case,
                row.misfit.name(),
                row.parameter,
                row.right,
                row.refused,
                row.unbounded,
                row.failed,
                number(row.median_error_percent, sign),
                number(row.median_half_width_percent, "±"),
            );
        }
        text + "\nError and half the interval's width are medians.\n"
    }
}
