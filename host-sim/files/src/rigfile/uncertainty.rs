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

macro_rules! widths {
    ($($key:ident ($field:ident): $meaning:literal, $at_least:literal..$below:literal;)*) => {
        [$(HalfWidth {
            key: stringify!($key),
            meaning: $meaning,
            at_least: $at_least,
            below: $below,
            of: |stated| &mut stated.$field,
        }),*]
    };
}

/// Every half-width, in the order of a file: its key, its field, its meaning, and its range.
pub const WIDTHS: [HalfWidth; 11] = widths! {
    natural_frequency_percent (natural_frequency_percent): "natural frequency, % either way", 0.0..50.0;
    amplitude_percent (amplitude_percent): "cart amplitude, % either way", 0.0..90.0;
    contact_stiffness_percent (contact_stiffness_percent): "contact stiffness, % either way", 0.0..90.0;
    contact_stiffness_factor (contact_stiffness_factor): "contact stiffness, largest factor up or down; instead of contact_stiffness_percent", 1.0..1000.0;
    contact_damping_percent (contact_damping_percent): "contact damping, % either way", 0.0..100.0;
    contact_damping_ratio_percent (contact_damping_ratio_percent): "contact's damping ratio, % either way; instead of contact_damping_percent", 0.0..100.0;
    gap_tolerance_mm (gap_mm): "gap, mm either way", 0.0..10.0;
    mass_percent (mass_percent): "hammer mass, % either way", 0.0..50.0;
    cart_mass_percent (cart_mass_percent): "cart mass, % either way", 0.0..90.0;
    shaker_loop_percent (shaker_loop_percent): "natural frequency of the shaker's loop, % either way", 0.0..90.0;
    shaker_damping_percent (shaker_damping_percent): "damping ratio of the shaker's loop, % either way", 0.0..90.0;
};

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
