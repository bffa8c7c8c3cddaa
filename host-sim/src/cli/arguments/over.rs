//! `--over KEY=VALUES`: a parameter of the rig, and the values it takes.

use super::range::{RangeValues, parse_values};
use super::rig::RigArgs;
use files::{UserError, rigfile};

/// Values at most: each is a rig, and a simulation at least.
const MOST: usize = 100_000;

/// `KEY=VALUES` as an option.
#[derive(Clone, Debug)]
pub struct OverOption {
    /// The parameter, as rig files name it.
    pub key: String,
    /// The values that it takes.
    pub values: RangeValues,
}

impl OverOption {
    /// A value as a setting on top of the rig.
    pub fn setting(&self, value: f64) -> [String; 1] {
        [format!("{}={value:?}", self.key)]
    }

    /// Refuses another option that says what the parameter is.
    ///
    /// # Errors
    /// If there is one.
    pub fn check(&self, rig: &RigArgs) -> Result<(), UserError> {
        let other = if rig.name.overrides(&self.key) {
            format!("--set {}", self.key)
        } else if self.key == "gap_mm" && rig.has_gap_option() {
            "--gap".to_owned()
        } else {
            return Ok(());
        };
        Err(UserError::new(format!(
            "{other} and --over {} both set it; leave one of them out",
            self.key
        )))
    }

    /// The error of a rig that cannot be, with the option it comes from.
    pub fn at(&self, error: UserError) -> UserError {
        error.at_setting(format!("--over {}", self.key))
    }

    /// The label of a chart's axis over it; see [`Self::along`].
    pub fn axis(&self) -> String {
        match self.values.log {
            true => format!("log10 of {}", self.key),
            false => self.key.clone(),
        }
    }

    /// Where a value lies on a chart's axis: a chart has no logarithmic one.
    pub fn along(&self, value: f64) -> f64 {
        match self.values.log {
            true => value.log10(),
            false => value,
        }
    }
}

/// Reads `KEY=VALUES`.
///
/// # Errors
/// In words: there is no such parameter, it is no number, or the values cannot be read.
pub fn parse_over(text: &str) -> Result<OverOption, String> {
    let (key, values) = text
        .split_once('=')
        .ok_or("write KEY=VALUES, for example contact_stiffness_n_per_m=1e5:1e7:log20")?;
    let key = key.trim();
    let keys = rigfile::KEYS.iter().map(|(known, _)| *known);
    if !keys.clone().any(|known| known == key) {
        let hint = rigfile::nearest(key, keys);
        return Err(format!(
            "there is no parameter '{key}'{hint}; `host-sim rigs wires` prints them all"
        ));
    }
    let values = parse_values(values)?;
    if values.list.len() > MOST {
        return Err(format!(
            "that is {} values, more than {MOST}; use fewer",
            values.list.len()
        ));
    }
    Ok(OverOption {
        key: key.to_owned(),
        values,
    })
}
