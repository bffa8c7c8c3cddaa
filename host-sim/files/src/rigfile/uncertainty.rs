//! The table `[uncertainty]` of a rig file: how well each measured parameter is known.

use numerics::uncertainty::Stated;
use toml::Value;

use super::keys::{NoRig, nearest};
use super::table::as_number;
use crate::UserError;
use crate::range::below;

/// A half-width that may be stated.
pub struct HalfWidth {
    /// Its key in a rig file; with dashes, the option of `pick`.
    pub key: &'static str,
    /// What it is the half-width of.
    pub meaning: &'static str,
    /// The value must be at least this.
    at_least: f64,
    /// The value must be less than this.
    pub below: f64,
    of: fn(&mut Stated) -> &mut Option<f64>,
}

/// Every half-width, in the order of a file.
pub const WIDTHS: [HalfWidth; 11] = [
    HalfWidth {
        key: "natural_frequency_percent",
        meaning: "natural frequency, % either way",
        at_least: 0.0,
        below: 50.0,
        of: |s| &mut s.natural_frequency_percent,
    },
    HalfWidth {
        key: "amplitude_percent",
        meaning: "cart amplitude, % either way",
        at_least: 0.0,
        below: 90.0,
        of: |s| &mut s.amplitude_percent,
    },
    HalfWidth {
        key: "contact_stiffness_percent",
        meaning: "contact stiffness, % either way",
        at_least: 0.0,
        below: 90.0,
        of: |s| &mut s.contact_stiffness_percent,
    },
    HalfWidth {
        key: "contact_stiffness_factor",
        meaning: "contact stiffness, largest factor up or down; instead of contact_stiffness_percent",
        at_least: 1.0,
        below: 1000.0,
        of: |s| &mut s.contact_stiffness_factor,
    },
    HalfWidth {
        key: "contact_damping_percent",
        meaning: "contact damping, % either way",
        at_least: 0.0,
        below: 100.0,
        of: |s| &mut s.contact_damping_percent,
    },
    HalfWidth {
        key: "contact_damping_ratio_percent",
        meaning: "contact's damping ratio, % either way; instead of contact_damping_percent",
        at_least: 0.0,
        below: 100.0,
        of: |s| &mut s.contact_damping_ratio_percent,
    },
    HalfWidth {
        key: "gap_tolerance_mm",
        meaning: "gap, mm either way",
        at_least: 0.0,
        below: 10.0,
        of: |s| &mut s.gap_mm,
    },
    HalfWidth {
        key: "mass_percent",
        meaning: "hammer mass, % either way",
        at_least: 0.0,
        below: 50.0,
        of: |s| &mut s.mass_percent,
    },
    HalfWidth {
        key: "cart_mass_percent",
        meaning: "cart mass, % either way",
        at_least: 0.0,
        below: 90.0,
        of: |s| &mut s.cart_mass_percent,
    },
    HalfWidth {
        key: "shaker_loop_percent",
        meaning: "natural frequency of the shaker's loop, % either way",
        at_least: 0.0,
        below: 90.0,
        of: |s| &mut s.shaker_loop_percent,
    },
    HalfWidth {
        key: "shaker_damping_percent",
        meaning: "damping ratio of the shaker's loop, % either way",
        at_least: 0.0,
        below: 90.0,
        of: |s| &mut s.shaker_damping_percent,
    },
];

/// What takes each other's place.
const ONE_OF: [[&str; 2]; 2] = [
    ["contact_stiffness_percent", "contact_stiffness_factor"],
    ["contact_damping_percent", "contact_damping_ratio_percent"],
];

impl HalfWidth {
    /// What `stated` has for it.
    pub fn get(&self, stated: &Stated) -> Option<f64> {
        *(self.of)(&mut stated.clone())
    }

    /// States `value` for it, which `name` gives.
    ///
    /// # Errors
    /// The value is out of range, or another width is stated that this one takes the place of.
    pub fn set(&self, stated: &mut Stated, name: &str, value: f64) -> Result<(), UserError> {
        *(self.of)(stated) = Some(below(name, value, self.at_least, self.below)?);
        for [one, other] in ONE_OF {
            let given = |key: &str| {
                let width = WIDTHS.iter().find(|width| width.key == key);
                width.is_some_and(|width| width.get(stated).is_some())
            };
            if given(one) && given(other) {
                return Err(UserError::new(format!(
                    "{name}: {one} and {other} are both given; give one of them"
                )));
            }
        }
        Ok(())
    }
}

/// What the table `[uncertainty]` states.
pub(super) fn stated(table: Option<Value>) -> Result<Stated, NoRig> {
    let mut stated = Stated::default();
    let table = match table {
        None => return Ok(stated),
        Some(Value::Table(table)) => table,
        Some(_) => {
            let line = "uncertainty must be a table: a line [uncertainty] with lines like natural_frequency_percent = 1 below it";
            return Err(NoRig::new("uncertainty", line.to_owned()));
        }
    };
    for (key, value) in table {
        let Some(width) = WIDTHS.iter().find(|width| width.key == key) else {
            let hint = nearest(&key, WIDTHS.iter().map(|width| width.key));
            let known: Vec<_> = WIDTHS.iter().map(|width| width.key).collect();
            let known = known.join(", ");
            let line = format!("[uncertainty] has no '{key}'{hint}; it may have {known}");
            return Err(NoRig::new(&key, line));
        };
        let number = as_number(&value)
            .ok_or_else(|| NoRig::new(&key, format!("{key} is {value}, must be a number")))?;
        let set = width.set(&mut stated, &key, number);
        set.map_err(|error| NoRig::new(&key, error.to_string()))?;
    }
    Ok(stated)
}

/// The lines of `[uncertainty]` that say what is stated; nothing if nothing is.
pub(super) fn lines(stated: &Stated) -> String {
    let present = WIDTHS.iter().filter_map(|width| {
        let value = width.get(stated)?;
        Some(format!("{} = {value:?}  # {}\n", width.key, width.meaning))
    });
    let lines: String = present.collect();
    if lines.is_empty() {
        return lines;
    }
    format!("\n[uncertainty]\n{lines}")
}
