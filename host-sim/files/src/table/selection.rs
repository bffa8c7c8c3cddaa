//! A line of a table as a selection of what an answer has.

use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};
use serde_json::{Map, Value};

/// The columns of an answer that its line in a table has. A part of an answer counts by the names of its own; a pair
/// `band_hz` is there as `band_low_hz` and `band_high_hz`. A column that this answer lacks is empty.
pub struct Selection {
    columns: &'static [&'static str],
    values: Map<String, Value>,
}

impl Selection {
    /// The `columns` of `answer`, whose JSON is an object.
    pub fn of<T: Serialize>(answer: &T, columns: &'static [&'static str]) -> Self {
        let mut values = Map::new();
        let answer = serde_json::to_value(answer).expect("an answer always serialises");
        flatten(answer, &mut values);
        Self { columns, values }
    }
}

/// Puts what `answer` has into `flat`; what stands further out in the answer keeps its name.
fn flatten(answer: Value, flat: &mut Map<String, Value>) {
    let Value::Object(members) = answer else {
        return;
    };
    let (parts, own): (Vec<_>, Vec<_>) = members.into_iter().partition(|(_, v)| v.is_object());
    for (name, value) in own {
        match (value, name.rsplit_once('_')) {
            (Value::Array(pair), Some((what, unit))) if pair.len() == 2 => {
                for (end, value) in ["low", "high"].iter().zip(pair) {
                    flat.entry(format!("{what}_{end}_{unit}")).or_insert(value);
                }
            }
            (value, _) => {
                flat.entry(name).or_insert(value);
            }
        }
    }
    for (_, part) in parts {
        flatten(part, flat);
    }
}

impl Serialize for Selection {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut line = serializer.serialize_struct("Selection", self.columns.len())?;
        for column in self.columns {
            line.serialize_field(column, self.values.get(*column).unwrap_or(&Value::Null))?;
        }
        line.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::to_csv;
    use serde_json::json;

    #[test]
    fn a_line_has_its_columns_in_their_order_and_an_empty_place_for_what_is_lacking() {
        let answer = json!({
            "rig": "wires",
            "shaker": { "force_n": 2.0, "loop_force_n": null, "stroke_mm": 1.5 },
            "band_hz": [3.25, 4.0],
            "force_n": 1.0,
            "jump_free": true,
        });
        const COLUMNS: &[&str] = &[
            "rig",
            "force_n",
            "band_low_hz",
            "band_high_hz",
            "jump_free",
            "stroke_mm",
            "loop_force_n",
            "modes",
        ];
        let csv = to_csv(&[Selection::of(&answer, COLUMNS)]);
        assert_eq!(
            String::from_utf8(csv).unwrap(),
            "rig,force_n,band_low_hz,band_high_hz,jump_free,stroke_mm,loop_force_n,modes\nwires,1.0,3.25,4.0,true,1.5,,\n"
        );
    }
}
