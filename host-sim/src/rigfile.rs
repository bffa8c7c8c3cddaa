//! Rigs as people write them: a preset's name, a TOML file, and single settings on the command line.
//! Keys carry their units. A file or a setting names only what differs from what it starts from.

use std::collections::BTreeMap;
use std::path::Path;

use shared::contact::Law;
use shared::params::{LAWS, PRESETS, RigParams, SupportParams, Torque, preset};
use toml::Value;

use crate::error::UserError;

/// A rig and what to call it.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedRig {
    /// Preset name, or the file's stem.
    pub name: String,
    /// Its parameters.
    pub params: RigParams,
}

type Table = BTreeMap<String, Value>;

/// Every key a rig file or `--set` may use, with what it means.
pub const KEYS: [(&str, &str); 19] = [
    (
        "preset",
        "rig to start from: wires, beam-170, beam-150 or beam-135",
    ),
    ("support", "what the hammer hangs on: wires or beams"),
    ("mass_kg", "hammer mass m"),
    (
        "cart_mass_kg",
        "cart mass M (only for what the shaker must give)",
    ),
    ("amplitude_mm", "cart amplitude A0"),
    ("gap_mm", "clearance at rest; negative: pressed on"),
    (
        "natural_frequency_hz",
        "natural frequency; sets the wire length on wires",
    ),
    (
        "wire_length_mm",
        "wire length l; sets the natural frequency",
    ),
    ("gravity_m_per_s2", "gravity g (wires)"),
    (
        "torque",
        "moment of the contact force on wires: literal (F l, as printed) or cosine (F l cos)",
    ),
    ("damping_ratio", "damping ratio of the beams"),
    (
        "cubic_stiffness_n_per_m3",
        "cubic stiffness of the beams; left out: numerically k",
    ),
    (
        "contact_law",
        "spring-dashpot, hertz, hunt-crossley or lankarani-nikravesh",
    ),
    (
        "contact_stiffness_n_per_m",
        "ki (N/m^n for the nonlinear laws)",
    ),
    ("contact_damping_n_s_per_m", "ci (spring-dashpot)"),
    ("contact_exponent", "n (nonlinear laws)"),
    (
        "contact_damping_ratio_s_per_m",
        "lambda = ci/ki (hunt-crossley)",
    ),
    ("contact_restitution", "e (lankarani-nikravesh)"),
    ("description", "free text"),
];

/// The rig called `name`, or in the TOML file of that path, with `settings` (`key=value`) on top.
///
/// # Errors
/// One line naming the file or setting, the key and the mend.
pub fn load(name: &str, settings: &[String]) -> Result<NamedRig, UserError> {
    let mut rig = match preset(name) {
        Some(params) => NamedRig {
            name: name.to_owned(),
            params,
        },
        None => read(Path::new(name))?,
    };
    if !settings.is_empty() {
        let mut table = to_table(&rig.params);
        let mut changes = Table::new();
        for setting in settings {
            let (key, value) = parse_setting(setting)?;
            changes.insert(key, value);
        }
        overlay(&mut table, changes).map_err(|e| e.at("--set"))?;
        rig.params = from_table(&table).map_err(|e| e.at("--set"))?;
    }
    Ok(rig)
}

/// Parameters with one number changed: what `--set` does, from within the program.
///
/// # Errors
/// As [`load`].
pub fn with_number(params: &RigParams, key: &str, value: f64) -> Result<RigParams, UserError> {
    let mut table = to_table(params);
    overlay(
        &mut table,
        Table::from([(key.to_owned(), Value::Float(value))]),
    )?;
    from_table(&table)
}

/// A number of `params` by its key, if this rig has it.
pub fn number(params: &RigParams, key: &str) -> Option<f64> {
    to_table(params).get(key).and_then(as_number)
}

/// A rig as a TOML file to start from, every parameter with its meaning.
pub fn to_toml(rig: &NamedRig) -> String {
    let table = to_table(&rig.params);
    let mut text = format!(
        "# Rig \"{}\". Use it with: host-sim pick --rig FILE.toml\n# A file may also begin with preset = \"{}\" and name only what differs.\n\n",
        rig.name, rig.name
    );
    for (key, meaning) in KEYS {
        if let Some(value) = table.get(key) {
            text.push_str(&format!("{key} = {value}  # {meaning}\n"));
        }
    }
    text
}

fn read(path: &Path) -> Result<NamedRig, UserError> {
    let place = path.display().to_string();
    let looks_like_a_file = path.extension().is_some() || path.components().count() > 1;
    if !looks_like_a_file && !path.exists() {
        let names: Vec<_> = PRESETS.iter().map(|(n, _)| *n).collect();
        let hint = nearest(&place, names.iter().copied());
        return Err(UserError::new(format!(
            "no rig is called '{place}'{hint}; presets: {}, or give a FILE.toml",
            names.join(", ")
        )));
    }
    let text = std::fs::read_to_string(path).map_err(|e| {
        UserError::new(format!(
            "cannot read the rig file {place}: {e}; check the path"
        ))
    })?;
    let mut changes: Table = toml::from_str(&text).map_err(|e| {
        let line = e.span().map_or(1, |s| {
            text[..s.start.min(text.len())].lines().count().max(1)
        });
        let what = e.message().lines().next().unwrap_or("not TOML").to_owned();
        UserError::new(format!(
            "{place}, line {line}: {what}; a rig file has lines like mass_kg = 0.298"
        ))
    })?;
    let mut table = match changes.remove("preset") {
        None => Table::new(),
        Some(Value::String(name)) => {
            let params = preset(&name).ok_or_else(|| {
                let hint = nearest(&name, PRESETS.iter().map(|(n, _)| *n));
                UserError::new(format!("{place}: preset = \"{name}\" is not known{hint}"))
            })?;
            to_table(&params)
        }
        Some(_) => {
            return Err(UserError::new(format!(
                "{place}: preset must be a name in quotes"
            )));
        }
    };
    changes.remove("description");
    overlay(&mut table, changes).map_err(|e| e.at(&place))?;
    let params = from_table(&table).map_err(|e| e.at(&place))?;
    let name = path
        .file_stem()
        .map_or(place, |s| s.to_string_lossy().into_owned());
    Ok(NamedRig { name, params })
}

fn parse_setting(setting: &str) -> Result<(String, Value), UserError> {
    let (key, text) = setting.split_once('=').ok_or_else(|| {
        UserError::new(format!(
            "--set {setting}: write it as key=value, for example mass_kg=0.3"
        ))
    })?;
    let (key, text) = (key.trim(), text.trim());
    if key == "preset" || key == "description" {
        return Err(UserError::new(format!(
            "--set {setting}: {key} belongs in a rig file; use --rig"
        )));
    }
    let value = text
        .parse::<f64>()
        .map_or_else(|_| Value::String(text.to_owned()), Value::Float);
    Ok((key.to_owned(), value))
}

/// Lays `changes` over `base`: what one key decides for others follows it.
fn overlay(base: &mut Table, changes: Table) -> Result<(), UserError> {
    for key in changes.keys() {
        if !KEYS.iter().any(|(k, _)| k == key) {
            let hint = nearest(key, KEYS.iter().map(|(k, _)| *k));
            return Err(UserError::new(format!(
                "there is no parameter '{key}'{hint}; `host-sim rigs wires` prints them all"
            )));
        }
    }
    let has = |key: &str| changes.contains_key(key);
    if has("contact_law") {
        let law = text(&changes, "contact_law")?;
        let (_, preset) = LAWS.iter().find(|(n, _)| *n == law).ok_or_else(|| {
            let names: Vec<_> = LAWS.iter().map(|(n, _)| *n).collect();
            UserError::new(format!(
                "contact_law is '{law}', must be one of {}",
                names.join(", ")
            ))
        })?;
        if base.get("contact_law").and_then(Value::as_str) != Some(law) {
            base.retain(|key, _| !key.starts_with("contact_"));
            law_to_table(preset, base);
        }
    }
    // On wires, length and frequency say the same thing: the one given decides.
    let length_given = has("wire_length_mm") || has("gravity_m_per_s2");
    match (length_given, has("natural_frequency_hz")) {
        (true, false) => {
            base.remove("natural_frequency_hz");
        }
        (false, true) => {
            base.remove("wire_length_mm");
        }
        _ => {}
    }
    base.extend(changes);
    Ok(())
}

fn to_table(params: &RigParams) -> Table {
    let mut table = Table::new();
    let mut put = |key: &str, value: f64| {
        table.insert(key.to_owned(), Value::Float(value));
    };
    put("mass_kg", params.mass_kg);
    put("cart_mass_kg", params.cart_mass_kg);
    put("amplitude_mm", to_mm(params.amplitude_m));
    put("gap_mm", to_mm(params.gap_m));
    put("natural_frequency_hz", params.natural_frequency_hz());
    match params.support {
        SupportParams::Wires {
            length_m,
            gravity_m_per_s2,
            torque,
            ..
        } => {
            put("wire_length_mm", to_mm(length_m));
            put("gravity_m_per_s2", gravity_m_per_s2);
            let torque = match torque {
                Torque::Literal => "literal",
                Torque::Cosine => "cosine",
            };
            table.insert("torque".into(), Value::String(torque.into()));
            table.insert("support".into(), Value::String("wires".into()));
        }
        SupportParams::Beams {
            damping_ratio,
            cubic_stiffness_n_per_m3,
            ..
        } => {
            put("damping_ratio", damping_ratio);
            if let Some(cubic) = cubic_stiffness_n_per_m3 {
                put("cubic_stiffness_n_per_m3", cubic);
            }
            table.insert("support".into(), Value::String("beams".into()));
        }
    }
    law_to_table(&params.contact, &mut table);
    table
}

fn law_to_table(law: &Law<f64>, table: &mut Table) {
    let mut put = |key: &str, value: f64| {
        table.insert(key.to_owned(), Value::Float(value));
    };
    put("contact_stiffness_n_per_m", law.stiffness());
    let name = match *law {
        Law::SpringDashpot { damping, .. } => {
            put("contact_damping_n_s_per_m", damping);
            "spring-dashpot"
        }
        Law::Hertz { exponent, .. } => {
            put("contact_exponent", exponent);
            "hertz"
        }
        Law::HuntCrossley {
            exponent,
            damping_ratio,
            ..
        } => {
            put("contact_exponent", exponent);
            put("contact_damping_ratio_s_per_m", damping_ratio);
            "hunt-crossley"
        }
        Law::LankaraniNikravesh {
            exponent,
            restitution,
            ..
        } => {
            put("contact_exponent", exponent);
            put("contact_restitution", restitution);
            "lankarani-nikravesh"
        }
    };
    table.insert("contact_law".into(), Value::String(name.into()));
}

fn from_table(table: &Table) -> Result<RigParams, UserError> {
    let mut left = table.clone();
    let params = RigParams {
        support: support_from(&mut left)?,
        mass_kg: take(&mut left, "mass_kg")?,
        cart_mass_kg: take(&mut left, "cart_mass_kg")?,
        amplitude_m: take(&mut left, "amplitude_mm")? / 1e3,
        gap_m: take(&mut left, "gap_mm")? / 1e3,
        contact: law_from(&mut left)?,
    };
    if let Some(key) = left.keys().next() {
        return Err(UserError::new(format!(
            "{key} does not apply to this rig's support or contact law; leave it out or change support or contact_law"
        )));
    }
    params.check()?;
    Ok(params)
}

fn support_from(table: &mut Table) -> Result<SupportParams, UserError> {
    let support = text(table, "support")?.to_owned();
    table.remove("support");
    match support.as_str() {
        "wires" => {
            let gravity_m_per_s2 = take(table, "gravity_m_per_s2")?;
            let torque = match table.remove("torque").as_ref().map(|v| v.as_str()) {
                None | Some(Some("literal")) => Torque::Literal,
                Some(Some("cosine")) => Torque::Cosine,
                Some(_) => return Err(UserError::new("torque must be literal or cosine")),
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
                    // A frequency that is no number is the fault to name, not the length it gives.
                    if !(frequency > 0.0 && frequency.is_finite()) {
                        return Err(UserError::new(format!(
                            "natural_frequency_hz is {frequency}, must be a positive number"
                        )));
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
        other => Err(UserError::new(format!(
            "support is '{other}', must be wires or beams"
        ))),
    }
}

fn law_from(table: &mut Table) -> Result<Law<f64>, UserError> {
    let law = text(table, "contact_law")?.to_owned();
    table.remove("contact_law");
    let stiffness = take(table, "contact_stiffness_n_per_m")?;
    match law.as_str() {
        "spring-dashpot" => Ok(Law::SpringDashpot {
            stiffness,
            damping: take(table, "contact_damping_n_s_per_m")?,
        }),
        "hertz" => Ok(Law::Hertz {
            stiffness,
            exponent: take(table, "contact_exponent")?,
        }),
        "hunt-crossley" => Ok(Law::HuntCrossley {
            stiffness,
            exponent: take(table, "contact_exponent")?,
            damping_ratio: take(table, "contact_damping_ratio_s_per_m")?,
        }),
        "lankarani-nikravesh" => Ok(Law::LankaraniNikravesh {
            stiffness,
            exponent: take(table, "contact_exponent")?,
            restitution: take(table, "contact_restitution")?,
        }),
        other => Err(UserError::new(format!(
            "contact_law is '{other}', which is not known"
        ))),
    }
}

fn text<'a>(table: &'a Table, key: &str) -> Result<&'a str, UserError> {
    let value = table.get(key).ok_or_else(|| missing(key))?;
    value
        .as_str()
        .ok_or_else(|| UserError::new(format!("{key} is {value}, must be a word in quotes")))
}

fn take(table: &mut Table, key: &str) -> Result<f64, UserError> {
    optional(table, key)?.ok_or_else(|| missing(key))
}

fn optional(table: &mut Table, key: &str) -> Result<Option<f64>, UserError> {
    table
        .remove(key)
        .map(|value| {
            as_number(&value)
                .ok_or_else(|| UserError::new(format!("{key} is {value}, must be a number")))
        })
        .transpose()
}

fn as_number(value: &Value) -> Option<f64> {
    value
        .as_float()
        .or_else(|| value.as_integer().map(|i| i as f64))
}

fn missing(key: &str) -> UserError {
    UserError::new(format!(
        "{key} is missing; give it, or begin with preset = \"wires\""
    ))
}

/// Millimetres, without the last-digit noise of a multiplication.
fn to_mm(metres: f64) -> f64 {
    let mm = metres * 1e3;
    let tidy = (mm * 1e9).round() / 1e9;
    if (tidy - mm).abs() <= 1e-12 * mm.abs() {
        tidy
    } else {
        mm
    }
}

/// `; did you mean 'x'?`, if something like `word` is there.
fn nearest<'a>(word: &str, among: impl Iterator<Item = &'a str>) -> String {
    among
        .map(|candidate| (strsim::jaro_winkler(word, candidate), candidate))
        .filter(|(likeness, _)| *likeness > 0.75)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(String::new(), |(_, candidate)| {
            format!(" (did you mean '{candidate}'?)")
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(text: &str) -> Result<NamedRig, UserError> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("mine.toml");
        std::fs::write(&path, text).unwrap();
        load(path.to_str().unwrap(), &[])
    }

    #[test]
    fn a_printed_preset_reads_back_the_same() {
        for (name, params) in PRESETS {
            for (_, contact) in LAWS {
                let rig = NamedRig {
                    name: name.into(),
                    params: RigParams { contact, ..params },
                };
                let back = file(&to_toml(&rig)).unwrap();
                assert_eq!(back.params, rig.params, "{name}");
            }
        }
    }

    #[test]
    fn what_one_key_decides_for_another_follows_it() {
        let set = |s: &str| load("wires", &[s.to_owned()]).unwrap().params;
        assert!((set("wire_length_mm=300").natural_frequency_hz() - 0.9101).abs() < 1e-4);
        let SupportParams::Wires { length_m, .. } = set("natural_frequency_hz=0.91").support else {
            panic!()
        };
        assert!((length_m - 0.3001).abs() < 1e-4);
        assert!(matches!(
            set("contact_law=hunt-crossley").contact,
            Law::HuntCrossley { .. }
        ));
        assert_eq!(set("gap_mm=2.4").gap_m, 2.4e-3);
    }

    #[test]
    fn every_mistake_gets_one_line_that_names_it() {
        let complaint = |result: Result<NamedRig, UserError>| {
            let line = result.unwrap_err().to_string();
            assert!(!line.contains('\n'), "{line}");
            line
        };
        let set = |s: &str| complaint(load("wires", &[s.to_owned()]));
        assert!(set("mas_kg=1").contains("did you mean 'mass_kg'"));
        assert!(set("mass_kg=-1").contains("mass_kg is -1, must be a positive number"));
        assert!(set("mass_kg=NaN").contains("mass_kg is NaN"));
        assert!(set("mass_kg=heavy").contains("must be a number"));
        assert!(set("mass_kg").contains("key=value"));
        assert!(set("damping_ratio=0.1").contains("does not apply"));
        assert!(set("natural_frequency_hz=0").contains("natural_frequency_hz"));
        assert!(complaint(load("wire", &[])).contains("did you mean 'wires'"));
        assert!(complaint(load("none.toml", &[])).contains("cannot read"));
        assert!(complaint(file("mass_kg = ")).contains("line 1"));
        assert!(complaint(file("mass_kg = 0.3")).contains("missing"));
        assert!(complaint(file("preset = \"wires\"\nmass_kg = \"x\"")).contains("mine.toml"));
        assert!(complaint(file("preset = \"wires\"\ngap = 1")).contains("'gap_mm'"));
    }
}
