//! `--ratio` and `--frequency`: one drive frequency or several. Each command says whether they may be left out.

use files::UserError;
use numerics::row::tidy;

use super::range::range_or_value;

/// One drive frequency.
#[derive(Clone, Copy, Debug, clap::Args)]
#[group(skip)]
pub struct OneFrequency {
    /// Drive frequency over the natural frequency, Ω/ω
    #[arg(long, value_name = "R")]
    ratio: Option<f64>,

    /// Drive frequency, Hz
    #[arg(long, value_name = "HZ")]
    frequency: Option<f64>,
}

impl OneFrequency {
    /// Hz; none if both options were left out.
    pub fn hz(&self, natural_hz: f64) -> Option<f64> {
        self.frequency.or(self.ratio.map(|r| r * natural_hz))
    }

    /// Hz, for a command that needs a frequency.
    ///
    /// # Errors
    /// If both options were left out.
    pub fn needed_hz(&self, natural_hz: f64) -> Result<f64, UserError> {
        self.hz(natural_hz).ok_or_else(missing)
    }
}

/// Several drive frequencies.
#[derive(Clone, Debug, clap::Args)]
#[group(skip)]
pub struct Drives {
    /// Drive frequencies over the natural frequency, Ω/ω: FROM:TO:STEP, or one value
    #[arg(long, value_name = "RANGE", allow_hyphen_values = true)]
    ratio: Option<String>,

    /// Drive frequencies, Hz: FROM:TO:STEP, or one value
    #[arg(long, value_name = "RANGE", allow_hyphen_values = true)]
    frequency: Option<String>,
}

/// The help of `--frequency` in a command whose default are the chapter's frequencies.
pub fn chapters(frequency: clap::Arg) -> clap::Arg {
    frequency.help(
        "Drive frequencies, Hz: FROM:TO:STEP, or one value [default: the chapter's, 1.41:7.28:0.01 on wires and the same Ω/ω for other rigs]",
    )
}

impl Drives {
    /// Whether they were given in Hz.
    pub fn in_hz(&self) -> bool {
        self.frequency.is_some()
    }

    /// Hz, rising; none if both options were left out.
    ///
    /// # Errors
    /// If a value is not a positive number.
    pub fn hz(&self, natural_hz: f64) -> Result<Option<Vec<f64>>, UserError> {
        let (option, text, unit) = match (&self.ratio, &self.frequency) {
            (Some(text), _) => ("--ratio", text, natural_hz),
            (None, Some(text)) => ("--frequency", text, 1.0),
            (None, None) => return Ok(None),
        };
        let wrong = |what: String| UserError::new(format!("{option} {text}: {what}"));
        let values = range_or_value(text).map_err(wrong)?;
        match values.iter().find(|v| !(**v > 0.0 && v.is_finite())) {
            Some(bad) if bad.is_infinite() => Err(wrong("write a finite number".to_owned())),
            Some(bad) => Err(wrong(format!("{bad} is not a positive value"))),
            None => Ok(Some(
                values.into_iter().map(|v| tidy(tidy(v) * unit)).collect(),
            )),
        }
    }

    /// Hz, rising, for a command that needs frequencies.
    ///
    /// # Errors
    /// If a value is not a positive number, or both options were left out.
    pub fn needed_hz(&self, natural_hz: f64) -> Result<Vec<f64>, UserError> {
        self.hz(natural_hz)?.ok_or_else(missing)
    }
}

fn missing() -> UserError {
    UserError::new("there is no drive frequency; add --ratio or --frequency")
}
