//! `--ratio` and `--frequency`: the drive frequency of every command that has one, or goes over several. Whether
//! it may be left out is for the command to say.

use super::common::parse_range;
use files::UserError;
use numerics::row::tidy;

/// One drive frequency.
#[derive(Clone, Copy, Debug, clap::Args)]
#[group(skip)]
pub struct At {
    /// Drive frequency over the natural frequency, Ω/ω
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    ratio: Option<f64>,

    /// Drive frequency, Hz
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    frequency: Option<f64>,
}

impl At {
    /// Hz; none if it was left out.
    pub fn hz(&self, natural_hz: f64) -> Option<f64> {
        self.frequency.or(self.ratio.map(|r| r * natural_hz))
    }
}

/// Several drive frequencies.
#[derive(Clone, Debug, clap::Args)]
#[group(skip)]
pub struct Over {
    /// Drive frequencies over the natural frequency, Ω/ω: FROM:TO:STEP, or one value
    #[arg(long, value_name = "RANGE", allow_hyphen_values = true)]
    ratio: Option<String>,

    /// Drive frequencies, Hz: FROM:TO:STEP, or one value [where it may be left out: the chapter's, 1.41:7.28:0.01 on
    /// wires and the same Ω/ω for other rigs]
    #[arg(long, value_name = "RANGE", allow_hyphen_values = true)]
    frequency: Option<String>,
}

impl Over {
    /// Whether they were given in Hz.
    pub fn in_hz(&self) -> bool {
        self.frequency.is_some()
    }

    /// Hz, rising; none if they were left out.
    pub fn hz(&self, natural_hz: f64) -> Result<Option<Vec<f64>>, UserError> {
        let (option, text, unit) = match (&self.ratio, &self.frequency) {
            (Some(text), _) => ("--ratio", text, natural_hz),
            (None, Some(text)) => ("--frequency", text, 1.0),
            (None, None) => return Ok(None),
        };
        let wrong = |what: String| UserError::new(format!("{option} {text}: {what}"));
        let values = if text.contains(':') {
            parse_range(text).map_err(wrong)?
        } else {
            let value = text.trim().parse();
            vec![value.map_err(|_| wrong("write FROM:TO:STEP, or one number".to_owned()))?]
        };
        match values.iter().find(|v| !(**v > 0.0 && v.is_finite())) {
            Some(bad) if bad.is_infinite() => Err(wrong("write a finite number".to_owned())),
            Some(bad) => Err(wrong(format!("{bad} is not a positive value"))),
            None => Ok(Some(
                values.into_iter().map(|v| tidy(tidy(v) * unit)).collect(),
            )),
        }
    }
}
