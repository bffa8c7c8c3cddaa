//! A rig as keys and values, both ways.

use std::collections::BTreeMap;

use shared::model::cart::{ASSUMED_SHAKER, CartDrive, LoopParams, UNLIMITED_N};
use shared::model::contact::{Law, LawKind};
use shared::model::params::{ParamError, RigParams, SupportParams, Torque, WIRES};
use toml::Value;

use numerics::knob::Knob;

use crate::decimal::comma;

use super::keys::{KEYS, NoRig, nearest};

/// In place of `shaker_loop_hz`: no loop, also over a rig that has one.
pub(super) const PRESCRIBED: &str = "prescribed";

/// Keys and values of a rig.
pub type RigTable = BTreeMap<String, Value>;

/// Lays `changes` over `base`: what one key decides for others follows it.
///
/// # Errors
/// A key or a law that does not exist.
pub(super) fn overlay(base: &mut RigTable, changes: RigTable) -> Result<(), NoRig> {
    for key in changes.keys() {
        if !KEYS.iter().any(|(k, _)| k == key) {
            let names = KEYS.iter().map(|(k, _)| *k);
            let hint = nearest(key, names.chain(["uncertainty"]));
            let line = format!(
                "there is no parameter '{key}'{hint}; `host-sim rigs wires` prints them all"
            );
            return Err(NoRig::new(key, line));
        }
    }
    let has = |key: &str| changes.contains_key(key);
    if has("contact_law") {
        let law = text(&changes, "contact_law")?;
        let kind = LawKind::named(law).ok_or_else(|| {
            let names: Vec<_> = LawKind::all().map(LawKind::name).collect();
            let names = names.join(", ");
            NoRig::new(
                "contact_law",
                format!("contact_law is '{law}', must be one of {names}"),
            )
        })?;
        // A file without a preset must give the law's numbers itself.
        let before = base.get("contact_law").and_then(Value::as_str);
        if before.is_some_and(|before| before != law) {
            base.retain(|key, _| !key.starts_with("contact_"));
            let with = to_table(&of_contact(&kind.preset())).into_iter();
            base.extend(with.filter(|(key, _)| key.starts_with("contact_")));
        }
    }
    // On wires, length, gravity and frequency follow from each other: what is given decides, and the length gives way first.
    if has("natural_frequency_hz") {
        if !has("wire_length_mm") {
            base.remove("wire_length_mm");
        }
    } else if has("wire_length_mm") || has("gravity_m_per_s2") {
        base.remove("natural_frequency_hz");
    }
    base.extend(changes);
    Ok(())
}

/// Every parameter of a rig.
pub(super) fn to_table(params: &RigParams) -> RigTable {
    let numbers =
        Knob::all().filter_map(|knob| Some((knob.name(), Value::Float(knob.of(params)?))));
    let (support, torque) = match params.support {
        SupportParams::Wires { torque, .. } => ("wires", Some(torque)),
        SupportParams::Beams { .. } => ("beams", None),
    };
    let torque = torque.map(|torque| match torque {
        Torque::Literal => "literal",
        Torque::Cosine => "cosine",
    });
    let words = [
        Some(("support", support)),
        Some(("contact_law", params.contact.kind().name())),
        torque.map(|torque| ("torque", torque)),
    ];
    let words = words.into_iter().flatten();
    let words = words.map(|(key, word)| (key, Value::from(word)));
    let owned = |(key, value): (&str, Value)| (key.to_owned(), value);
    numbers.chain(words).map(owned).collect()
}

/// The rig that a table with every parameter describes.
///
/// # Errors
/// A key that is missing, out of place or out of range.
pub(super) fn from_table(table: &RigTable) -> Result<RigParams, NoRig> {
    let mut left = table.clone();
    let mut params = RigParams {
        support: support_from(&mut left)?,
        contact: law_from(&mut left)?,
        cart: cart_from(&mut left)?,
        ..WIRES
    };
    for number in RigParams::OWN_NUMBERS {
        if let Some(place) = params.number_mut(number.key) {
            *place = take(&mut left, number.key)? / number.per_si_unit;
        }
    }
    if let Some(key) = left.keys().next() {
        let line = format!(
            "{key} does not apply to this rig's support or contact law; leave it out or change support or contact_law"
        );
        return Err(NoRig::new(key, line));
    }
    // The complaint names the frequency that was given, not the length computed from it.
    let by_frequency = !table.contains_key("wire_length_mm");
    match params.check() {
        Err(error) if by_frequency && error.key == "wire_length_mm" => Err(ParamError {
            key: "natural_frequency_hz",
            value: params.natural_frequency_hz(),
            must_be: "that of wires from 0.1 to 1e5 mm long",
        }
        .into()),
        Err(error) => Err(error.into()),
        Ok(()) => Ok(params),
    }
}

fn support_from(table: &mut RigTable) -> Result<SupportParams, NoRig> {
    let support = text(table, "support")?.to_owned();
    table.remove("support");
    match support.as_str() {
        "wires" => {
            let gravity_m_per_s2 = take(table, "gravity_m_per_s2")?;
            let torque = match table.remove("torque").as_ref().map(|v| v.as_str()) {
                None | Some(Some("literal")) => Torque::Literal,
                Some(Some("cosine")) => Torque::Cosine,
                Some(_) => {
                    let line = "torque must be literal or cosine".to_owned();
                    return Err(NoRig::new("torque", line));
                }
            };
            let length = optional(table, "wire_length_mm")?.map(|mm| mm / 1e3);
            let frequency = optional(table, "natural_frequency_hz")?;
            let (length_m, natural_frequency_hz) = match (length, frequency) {
                (Some(length), Some(frequency)) => (length, frequency),
                (Some(length), None) => (
                    length,
                    (gravity_m_per_s2 / length).sqrt() / std::f64::consts::TAU,
                ),
                (None, Some(frequency)) => {
                    let omega = std::f64::consts::TAU * frequency;
                    let length = gravity_m_per_s2 / (omega * omega);
                    // The complaint names the frequency that was given, not the length computed from it.
                    if !(frequency > 0.0 && frequency.is_finite()) {
                        let line = format!(
                            "natural_frequency_hz is {frequency}, must be a positive number"
                        );
                        return Err(NoRig::new("natural_frequency_hz", line));
                    }
                    (length, frequency)
                }
                (None, None) => return Err(missing("wire_length_mm")),
            };
            Ok(SupportParams::Wires {
                length_m,
                gravity_m_per_s2,
                natural_frequency_hz,
                torque,
            })
        }
        "beams" => Ok(SupportParams::Beams {
            natural_frequency_hz: take(table, "natural_frequency_hz")?,
            damping_ratio: take(table, "damping_ratio")?,
            cubic_stiffness_n_per_m3: optional(table, "cubic_stiffness_n_per_m3")?,
        }),
        other => Err(NoRig::new(
            "support",
            format!("support is '{other}', must be wires or beams"),
        )),
    }
}

/// The shaker, if its position loop is given; what is left out of it is the assumed one's, but a largest force.
fn cart_from(table: &mut RigTable) -> Result<CartDrive, NoRig> {
    if table.get("shaker_loop_hz").and_then(Value::as_str) == Some(PRESCRIBED) {
        table.retain(|key, _| !key.starts_with("shaker_"));
        return Ok(CartDrive::Prescribed);
    }
    let frequency = optional(table, "shaker_loop_hz")?;
    let damping = optional(table, "shaker_damping_ratio")?;
    let forward = optional(table, "shaker_feed_forward")?;
    let most = optional(table, "shaker_max_force_n")?;
    let Some(frequency_hz) = frequency else {
        let orphan = [
            ("shaker_damping_ratio", damping),
            ("shaker_feed_forward", forward),
            ("shaker_max_force_n", most),
        ];
        return match orphan.iter().find(|(_, value)| value.is_some()) {
            Some((key, _)) => Err(NoRig::new(key, format!("{key} needs shaker_loop_hz"))),
            None => Ok(CartDrive::Prescribed),
        };
    };
    Ok(CartDrive::Loop(LoopParams {
        frequency_hz,
        damping_ratio: damping.unwrap_or(ASSUMED_SHAKER.damping_ratio),
        feed_forward: forward.unwrap_or(ASSUMED_SHAKER.feed_forward),
        max_force_n: most.unwrap_or(UNLIMITED_N),
    }))
}

fn law_from(table: &mut RigTable) -> Result<Law<f64>, NoRig> {
    let name = text(table, "contact_law")?.to_owned();
    table.remove("contact_law");
    let kind = LawKind::named(&name).ok_or_else(|| {
        let line = format!("contact_law is '{name}', which is not known");
        NoRig::new("contact_law", line)
    })?;
    let mut law = kind.preset();
    for number in kind.numbers() {
        if let Some(place) = law.number_mut(number.key) {
            *place = take(table, number.key)?;
        }
    }
    Ok(law)
}

/// A rig with this contact.
fn of_contact(contact: &Law<f64>) -> RigParams {
    let contact = *contact;
    RigParams { contact, ..WIRES }
}

fn text<'a>(table: &'a RigTable, key: &str) -> Result<&'a str, NoRig> {
    let value = table.get(key).ok_or_else(|| missing(key))?;
    value
        .as_str()
        .ok_or_else(|| NoRig::new(key, format!("{key} is {value}, must be a word in quotes")))
}

fn take(table: &mut RigTable, key: &str) -> Result<f64, NoRig> {
    optional(table, key)?.ok_or_else(|| missing(key))
}

fn optional(table: &mut RigTable, key: &str) -> Result<Option<f64>, NoRig> {
    table
        .remove(key)
        .map(|value| {
            as_number(&value).ok_or_else(|| {
                let write = comma(&value.to_string()).map_or(String::new(), |w| format!("; {w}"));
                NoRig::new(key, format!("{key} is {value}, must be a number{write}"))
            })
        })
        .transpose()
}

/// A TOML float or integer as a number; none for any other value.
pub fn as_number(value: &Value) -> Option<f64> {
    value
        .as_float()
        .or_else(|| value.as_integer().map(|i| i as f64))
}

fn missing(key: &str) -> NoRig {
    let line = format!(
        "{key} is missing; give it, or begin with preset = and the name of the nearest rig (see: host-sim rigs)"
    );
    NoRig::new(key, line)
}
