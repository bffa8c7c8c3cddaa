//! Rigs as people write them: a preset's name, a TOML file, and single settings on the command line.
//! Keys carry their units. A file or a setting names only what differs from what it starts from.

mod table;

use std::path::Path;

use numerics::NamedRig;
use shared::model::params::{PRESETS, RigParams, preset};
use toml::Value;

use crate::UserError;
use crate::read_text;
pub use table::Table;
pub use table::as_number;
use table::{from_table, overlay, to_table};

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

/// Parameters with those of a table on top, keys as in a rig file: a rig that stands in another file.
///
/// # Errors
/// As [`load`].
pub fn with_table(params: &RigParams, changes: toml::Table) -> Result<RigParams, UserError> {
    let mut table = to_table(params);
    overlay(&mut table, changes.into_iter().collect())?;
    from_table(&table)
}

/// The lines of a rig file: every parameter with its meaning.
pub fn lines(params: &RigParams) -> String {
    let table = to_table(params);
    let present = KEYS.iter().filter_map(|(key, meaning)| {
        let value = table.get(*key)?;
        Some(format!("{key} = {value}  # {meaning}\n"))
    });
    present.collect()
}

/// A number of `params` by its key, if this rig has it.
pub fn number(params: &RigParams, key: &str) -> Option<f64> {
    to_table(params).get(key).and_then(as_number)
}

/// A rig as a TOML file to start from, every parameter with its meaning.
pub fn to_toml(rig: &NamedRig) -> String {
    format!(
        "# Rig \"{}\". Use it with: host-sim pick --rig FILE.toml\n# A file may also begin with preset = \"{}\" and name only what differs.\n\n{}",
        rig.name,
        rig.name,
        lines(&rig.params)
    )
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
    let text = read_text(path)?;
    let changes: Table = toml::from_str(&text).map_err(|e| {
        let line = e.span().map_or(1, |s| {
            text[..s.start.min(text.len())].lines().count().max(1)
        });
        let what = e.message().lines().next().unwrap_or("not TOML").to_owned();
        UserError::new(format!(
            "{place}, line {line}: {what}; a rig file has lines like mass_kg = 0.298"
        ))
    })?;
    let keys: Vec<String> = changes.keys().cloned().collect();
    let params = parameters(changes).map_err(|error| {
        // The key that the line names, and where it stands: a longer one first, as one may begin with another.
        let said = error.to_string();
        let named = keys.iter().filter(|key| said.contains(key.as_str()));
        let key = named.max_by_key(|key| key.len());
        let sets = |line: &str, key: &str| {
            let rest = line.trim_start().strip_prefix(key);
            rest.is_some_and(|rest| rest.trim_start().starts_with('='))
        };
        let line = key.and_then(|key| text.lines().position(|line| sets(line, key)));
        match line {
            Some(line) => error.at(format!("{place}, line {}", line + 1)),
            None => error.at(&place),
        }
    })?;
    let name = path
        .file_stem()
        .map_or(place, |s| s.to_string_lossy().into_owned());
    Ok(NamedRig { name, params })
}

/// The rig that keys and values say, `preset` and `description` among them.
///
/// # Errors
/// One line that begins with `place`.
pub fn from_keys(changes: Table, place: &str) -> Result<RigParams, UserError> {
    parameters(changes).map_err(|e| e.at(place))
}

fn parameters(mut changes: Table) -> Result<RigParams, UserError> {
    let mut table = match changes.remove("preset") {
        None => Table::new(),
        Some(Value::String(name)) => {
            let params = preset(&name).ok_or_else(|| {
                let hint = nearest(&name, PRESETS.iter().map(|(n, _)| *n));
                UserError::new(format!("preset = \"{name}\" is not known{hint}"))
            })?;
            to_table(&params)
        }
        Some(_) => {
            return Err(UserError::new("preset must be a name in quotes"));
        }
    };
    changes.remove("description");
    overlay(&mut table, changes)?;
    from_table(&table)
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

/// `; did you mean 'x'?`, if something like `word` is there.
pub fn nearest<'a>(word: &str, among: impl Iterator<Item = &'a str>) -> String {
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
    use shared::model::contact::Law;
    use shared::model::params::{LAWS, SupportParams};

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
