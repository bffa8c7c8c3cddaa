//! The table `[uncertainty]` of a rig file: how well each measured parameter is known.

use numerics::pick::uncertainty::Stated;
use toml::Value;

use super::keys::{NoRig, nearest};
use super::table::as_number;
use crate::UserError;

/// A half-width that may be stated.
pub struct Width {
    /// Its key in a rig file; with dashes, the option of `pick`.
    pub key: &'static str,
    /// What it is the half-width of.
    pub meaning: &'static str,
    /// It is at least 0 and below this.
    pub below: f64,
    of: fn(&mut Stated) -> &mut Option<f64>,
}

/// Every half-width, in the order of a file.
pub const WIDTHS: [Width; 10] = [
    Width {
        key: "natural_frequency_percent",
        meaning: "natural frequency, % either way",
        below: 50.0,
        of: |s| &mut s.natural_frequency_percent,
    },
    Width {
        key: "amplitude_percent",
        meaning: "cart amplitude, % either way",
        below: 90.0,
        of: |s| &mut s.amplitude_percent,
    },
    Width {
        key: "contact_stiffness_percent",
        meaning: "contact stiffness, % either way",
        below: 90.0,
        of: |s| &mut s.contact_stiffness_percent,
    },
    Width {
        key: "contact_damping_percent",
        meaning: "contact damping, % either way",
        below: 100.0,
        of: |s| &mut s.contact_damping_percent,
    },
    Width {
        key: "contact_damping_ratio_percent",
        meaning: "contact's damping ratio, % either way: the damping goes with the stiffness; instead of contact_damping_percent",
        below: 100.0,
        of: |s| &mut s.contact_damping_ratio_percent,
    },
    Width {
        key: "gap_tolerance_mm",
        meaning: "gap, mm either way",
        below: 10.0,
        of: |s| &mut s.gap_mm,
    },
    Width {
        key: "mass_percent",
        meaning: "hammer mass, % either way",
        below: 50.0,
        of: |s| &mut s.mass_percent,
    },
    Width {
        key: "cart_mass_percent",
        meaning: "cart mass, % either way",
        below: 90.0,
        of: |s| &mut s.cart_mass_percent,
    },
    Width {
        key: "shaker_loop_percent",
        meaning: "natural frequency of the shaker's loop, % either way",
        below: 90.0,
        of: |s| &mut s.shaker_loop_percent,
    },
    Width {
        key: "shaker_damping_percent",
        meaning: "damping ratio of the shaker's loop, % either way",
        below: 90.0,
        of: |s| &mut s.shaker_damping_percent,
    },
];

impl Width {
    /// What `stated` has for it.
    pub fn get(&self, stated: &Stated) -> Option<f64> {
        *(self.of)(&mut stated.clone())
    }

    /// States `value` for it, which `name` gives.
    ///
    /// # Errors
    /// The value is out of range, or another width is stated that this one takes the place of.
    pub fn set(&self, stated: &mut Stated, name: &str, value: f64) -> Result<(), UserError> {
        let below = self.below;
        if !(0.0..below).contains(&value) {
            return Err(UserError::new(format!(
                "{name} is {value}, must be from 0 to below {below}"
            )));
        }
        *(self.of)(stated) = Some(value);
        if stated.contact_damping_percent.is_some()
            && stated.contact_damping_ratio_percent.is_some()
        {
            return Err(UserError::new(format!(
                "{name}: contact_damping_percent and contact_damping_ratio_percent are both given; give one of them"
            )));
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
