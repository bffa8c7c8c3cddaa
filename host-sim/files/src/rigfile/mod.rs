//! Rigs as people write them: a preset's name, a TOML file, and single settings on the command line.
//! Keys carry their units. A file or a setting names only what differs from what it starts from.

mod doubts;
mod keys;
mod table;
mod uncertainty;

use std::ffi::OsStr;
use std::path::Path;

use numerics::NamedRig;
use numerics::uncertainty::Stated;
use shared::model::cart::{ASSUMED_SHAKER, CartDrive};
use shared::model::params::{PRESETS, RigParams, preset};
use toml::Value;

use crate::UserError;
use crate::decimal::comma_at;
use crate::{line_at, read_text};
pub use doubts::doubts;
use keys::NoRig;
pub use keys::{KEYS, nearest};
pub use table::RigTable;
pub use table::as_number;
use table::{PRESCRIBED, from_table, overlay, to_table};
pub use uncertainty::{HalfWidth, WIDTHS};

/// The rig called `name`, or in the TOML file of that path, with `settings` (`key=value`) on top.
///
/// # Errors
/// There is no such rig or file, it is not TOML, a key or setting is unknown or missing, or a value out of range.
pub fn load(name: impl AsRef<OsStr>, settings: &[String]) -> Result<NamedRig, UserError> {
    let path = Path::new(name.as_ref());
    let place = path.display().to_string();
    let text = match path.to_str().and_then(preset) {
        Some(_) => format!("preset = \"{place}\""),
        None => read(path)?,
    };
    load_text(&place, &text, settings)
}

/// The rig in `text`, as [`load`] reads it from a file; complaints begin with `place`, whose stem is the rig's name.
///
/// # Errors
/// As [`load`].
pub fn load_text(place: &str, text: &str, settings: &[String]) -> Result<NamedRig, UserError> {
    let (mut params, stated) = parse_whole(text, place)?;
    if !settings.is_empty() {
        let mut table = to_table(&params);
        let mut changes = RigTable::new();
        for setting in settings {
            let (key, value) = parse_setting(setting)?;
            changes.insert(key, value);
        }
        let changed = overlay(&mut table, changes).and_then(|()| from_table(&table));
        params = changed.map_err(|e| UserError::from(e).at("--set"))?;
    }
    let mut rig = NamedRig::new(titled(&stem(Path::new(place)), settings), params).prescribed();
    rig.stated = stated;
    let told = |set: &String| set.trim_start().starts_with("shaker_max_force_n");
    rig.shaker_force_told = tells_shaker_force(text) || settings.iter().any(told);
    rig.overridden = settings.iter().map(|set| tidied(set)).collect();
    Ok(rig)
}

/// Whether the text of a rig file has the shaker's largest force.
fn tells_shaker_force(text: &str) -> bool {
    line_of_key(text, "shaker_max_force_n").is_some()
}

/// At most so many overrides stand in a rig's name; of more, how many there are.
const MOST_IN_NAME: usize = 4;

/// A rig's name with what is set over it, so that titles, tables and file names say so: `wires (mass_kg=0.5)`. The gap
/// stands beside the name everywhere, and is left out.
fn titled(name: &str, settings: &[String]) -> String {
    let sets = settings.iter().map(|set| tidied(set));
    let sets: Vec<_> = sets.filter(|set| !set.starts_with("gap_mm=")).collect();
    match sets.len() {
        0 => name.to_owned(),
        n if n <= MOST_IN_NAME => format!("{name} ({})", sets.join(", ")),
        n => {
            let sum = crc32fast::hash(sets.join(",").as_bytes());
            let few = sets[..MOST_IN_NAME - 1].join(", ");
            let more = n + 1 - MOST_IN_NAME;
            format!("{name} ({few} and {more} more: {sum:08x})")
        }
    }
}

/// `key=value` without blanks around either.
fn tidied(setting: &str) -> String {
    match setting.split_once('=') {
        Some((key, value)) => format!("{}={}", key.trim(), value.trim()),
        None => setting.trim().to_owned(),
    }
}

/// Every parameter of a rig by its key.
pub fn parameters_of(params: &RigParams) -> RigTable {
    to_table(params)
}

/// A preset with the shaker assumed for it.
fn with_shaker(params: RigParams) -> RigParams {
    RigParams {
        cart: CartDrive::Loop(ASSUMED_SHAKER),
        ..params
    }
}

/// `params` with the `changes` of a table whose keys are those of a rig file.
///
/// # Errors
/// As [`load`].
pub fn with_table(params: &RigParams, changes: toml::Table) -> Result<RigParams, UserError> {
    let mut table = to_table(params);
    overlay(&mut table, changes.into_iter().collect())?;
    Ok(from_table(&table)?)
}

/// The rig, if no shaker was given with it: where it is told elsewhere.
fn without_shaker(params: RigParams) -> Result<RigParams, NoRig> {
    match params.cart {
        CartDrive::Prescribed => Ok(params),
        CartDrive::Loop(_) => {
            let line = "shaker_loop_hz does not belong here: [shaker] has the true shaker, [believed] what the controller knows of it";
            Err(NoRig::new("shaker_loop_hz", line.to_owned()))
        }
    }
}

/// The lines of a rig file with which it reads back the same onto any other: they say also that there is no shaker.
pub fn lines_onto_any(params: &RigParams) -> String {
    let mut lines = lines(params);
    if !params.cart.recoils() {
        lines.push_str(&format!(
            "shaker_loop_hz = \"{PRESCRIBED}\"  # the cart does not recoil\n"
        ));
    }
    lines
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

/// The value of a key of `params` as a rig file has it, if this rig has it.
pub fn shown(params: &RigParams, key: &str) -> Option<String> {
    to_table(params).get(key).map(ToString::to_string)
}

/// A rig as a TOML file to start from, every parameter with its meaning.
pub fn to_toml(rig: &NamedRig) -> String {
    // Of any other rig, a file cannot begin with its name.
    let is_preset = preset(&rig.name) == Some(rig.clone().prescribed().params);
    let begin = if is_preset {
        let name = &rig.name;
        format!("# A file may also begin with preset = \"{name}\" and name only what differs.\n")
    } else {
        String::new()
    };
    format!(
        "# Rig \"{}\". Use it with: host-sim pick --rig FILE.toml\n{begin}\n{}{}",
        rig.name,
        lines(&rig.recoiling().as_ref().unwrap_or(rig).params),
        uncertainty::lines(&rig.stated)
    )
}

/// The text of a rig file.
fn read(path: &Path) -> Result<String, UserError> {
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
    read_text(path)
}

/// The name of the rig in a file.
fn stem(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or(path.as_os_str());
    stem.to_string_lossy().into_owned()
}

/// The rig in the text of a rig file; complaints begin with `place`.
///
/// # Errors
/// It is not TOML, a key is unknown or missing, or a value out of range.
pub fn parse(text: &str, place: &str) -> Result<RigParams, UserError> {
    parse_whole(text, place).map(|(params, _)| params)
}

/// The rig in the text of a rig file, and what it states of its uncertainty; complaints begin with `place`.
///
/// # Errors
/// As [`parse`].
pub fn parse_whole(text: &str, place: &str) -> Result<(RigParams, Stated), UserError> {
    let mut changes: RigTable = toml::from_str(text).map_err(|e| {
        let line = line_at(text, e.span().map_or(0, |span| span.start));
        let what = e.message().lines().next().unwrap_or("not TOML").to_owned();
        let mend = comma_at(text, line);
        let mend = mend.unwrap_or_else(|| {
            "a rig file has lines like mass_kg = 0.298, without units".to_owned()
        });
        UserError::new(format!("{place}, line {line}: {what}; {mend}"))
    })?;
    let stated = uncertainty::stated(changes.remove("uncertainty"));
    let whole = stated.and_then(|stated| Ok((parameters(changes, with_shaker)?, stated)));
    whole.map_err(|error| {
        let line = line_of_key(text, &error.key);
        let error = UserError::from(error);
        match line {
            Some(line) => error.at(format!("{place}, line {line}")),
            None => error.at(place),
        }
    })
}

/// The line that sets `key`, counted from 1; none if no line does.
fn line_of_key(text: &str, key: &str) -> Option<usize> {
    let sets = |line: &str| {
        let rest = line.trim_start().strip_prefix(key);
        rest.is_some_and(|rest| rest.trim_start().starts_with('='))
    };
    text.lines().position(sets).map(|above| above + 1)
}

/// The rig of keys and values, `preset` and `description` among them; complaints begin with `place`.
///
/// # Errors
/// A key is unknown or missing, or a value out of range.
pub fn from_keys(changes: RigTable, place: &str) -> Result<RigParams, UserError> {
    let rig = parameters(changes, |preset| preset).and_then(without_shaker);
    rig.map_err(|e| UserError::from(e).at(place))
}

/// What the controller believes: the same, and a shaker may be among the keys. The second says whether there was a word of it.
///
/// # Errors
/// As [`from_keys`].
pub fn believed_from_keys(changes: RigTable, place: &str) -> Result<(RigParams, bool), UserError> {
    let told = changes.contains_key("shaker_loop_hz");
    let rig = parameters(changes, |preset| preset);
    let rig = rig.map_err(|e| UserError::from(e).at(place))?;
    Ok((rig, told))
}

/// The rig of `changes`; `from` makes of a preset what they are laid over.
fn parameters(mut changes: RigTable, from: fn(RigParams) -> RigParams) -> Result<RigParams, NoRig> {
    let mut table = match changes.remove("preset") {
        None => RigTable::new(),
        Some(Value::String(name)) => {
            let params = preset(&name).ok_or_else(|| {
                let hint = nearest(&name, PRESETS.iter().map(|(n, _)| *n));
                NoRig::new("preset", format!("preset = \"{name}\" is not known{hint}"))
            })?;
            to_table(&from(params))
        }
        Some(_) => {
            let line = "preset must be a name in quotes".to_owned();
            return Err(NoRig::new("preset", line));
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

/// The force wanted of `rig`, N, from an `[aim]` in newtons or in units of the rig's weight; nothing if neither is given.
///
/// # Errors
/// Both are given.
pub fn force_wanted(
    force_n: Option<f64>,
    force_ratio: Option<f64>,
    rig: &RigParams,
) -> Result<Option<f32>, UserError> {
    if force_n.is_some() && force_ratio.is_some() {
        let what = "[aim] has force_n and force_ratio; give one of them";
        return Err(UserError::new(what));
    }
    let of_weight = force_ratio.map(|ratio| ratio * rig.weight_n());
    Ok(force_n.or(of_weight).map(|n| n as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use shared::model::contact::LAWS;
    use shared::model::contact::Law;
    use shared::model::params::SupportParams;

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
                let rig = NamedRig::new(name, RigParams { contact, ..params });
                let back = file(&to_toml(&rig)).unwrap();
                assert_eq!(back.params, rig.params, "{name}");
            }
        }
    }

    #[test]
    fn only_a_preset_is_said_to_be_one() {
        let said = "preset = ";
        for (name, _) in PRESETS {
            assert!(to_toml(&load(name, &[]).unwrap()).contains(said), "{name}");
        }
        let mine = file("preset = \"wires\"\nmass_kg = 0.5\n").unwrap();
        assert!(!to_toml(&mine).contains(said), "{}", to_toml(&mine));
    }

    #[test]
    fn an_uncertainty_is_read_printed_and_read_back() {
        let rig =
            file("preset = \"wires\"\n[uncertainty]\nmass_percent = 0.5\ngap_tolerance_mm = 0.1\n")
                .unwrap();
        let stated = Stated {
            mass_percent: Some(0.5),
            gap_mm: Some(0.1),
            ..Stated::default()
        };
        assert_eq!(rig.stated, stated);
        let back = file(&to_toml(&rig)).unwrap();
        assert_eq!(back.stated, stated);
        let complaint = |text: &str| file(text).unwrap_err().to_string();
        let line = complaint("preset = \"wires\"\n[uncertainty]\nmas_percent = 1\n");
        assert!(
            line.contains("line 3") && line.contains("did you mean 'mass_percent'"),
            "{line}"
        );
        let line = complaint("preset = \"wires\"\n[uncertainty]\nmass_percent = 50\n");
        assert!(line.contains("must be from 0 to below 50"), "{line}");
        let both = "contact_damping_percent = 5\ncontact_damping_ratio_percent = 5\n";
        let line = complaint(&format!("preset = \"wires\"\n[uncertainty]\n{both}"));
        assert!(
            line.contains("line 4: contact_damping_ratio_percent: contact_damping_percent and contact_damping_ratio_percent are both given"),
            "{line}"
        );
        let line = complaint("preset = \"wires\"\nuncertainty = 1\n");
        assert!(line.contains("must be a table"), "{line}");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_path_that_is_not_utf_8_is_read() {
        use std::os::unix::ffi::OsStrExt;
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join(OsStr::from_bytes(b"r\xff.toml"));
        std::fs::write(&path, "preset = \"wires\"\nmass_kg = 0.5\n").unwrap();
        assert_eq!(load(&path, &[]).unwrap().params.mass_kg, 0.5);
    }

    #[test]
    fn what_one_key_decides_for_another_follows_it() {
        let set = |s: &str| load("wires", &[s.to_owned()]).unwrap().params;
        assert!((set("wire_length_mm=300").natural_frequency_hz() - 0.9101).abs() < 1e-4);
        let SupportParams::Wires { length_m, .. } = set("natural_frequency_hz=0.91").support else {
            panic!()
        };
        assert!((length_m - 0.3001).abs() < 1e-4);
        // With another gravity the length gives way, too: the frequency asked for is the one there is.
        let elsewhere = ["gravity_m_per_s2=5", "natural_frequency_hz=2.5"].map(str::to_owned);
        let hz = load("wires", &elsewhere)
            .unwrap()
            .params
            .natural_frequency_hz();
        assert!((hz - 2.5).abs() < 1e-9);
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
        assert!(set("mass_kg=0,3").contains("write 0.3 with a point"));
        let line = complaint(file("preset = \"wires\"\nmass_kg = 0,3\n"));
        assert!(
            line.contains("line 2") && line.contains("write 0.3 with a point"),
            "{line}"
        );
        assert!(set("mass_kg").contains("key=value"));
        assert!(set("damping_ratio=0.1").contains("does not apply"));
        assert!(set("natural_frequency_hz=0").contains("natural_frequency_hz"));
        assert!(complaint(load("wire", &[])).contains("did you mean 'wires'"));
        assert!(complaint(load("none.toml", &[])).contains("cannot read"));
        assert!(complaint(file("mass_kg = ")).contains("line 1"));
        assert!(complaint(file("mass_kg = 1\n= 2")).contains("line 2"));
        assert!(complaint(file("mass_kg = 0.3")).contains("missing"));
        // A contact is not the built-in rigs' because a line of it is missing. (It was, without a word.)
        let whole = lines(&shared::model::params::WIRES);
        for key in ["contact_stiffness_n_per_m", "contact_damping_n_s_per_m"] {
            let without = whole.lines().filter(|line| !line.starts_with(key));
            let text: Vec<_> = without.collect();
            let line = complaint(file(&text.join("\n")));
            assert!(line.contains(&format!("{key} is missing")), "{line}");
        }
        assert!(complaint(file("preset = \"wires\"\nmass_kg = \"x\"")).contains("mine.toml"));
        assert!(complaint(file("preset = \"wires\"\ngap = 1")).contains("'gap_mm'"));
        // The line is that of the key, not of another whose name the words contain.
        let line = complaint(file("preset = \"wires\"\ngap_mm = 1\n\ngap = 1\n"));
        assert!(line.contains("mine.toml, line 4: "), "{line}");
        let line = complaint(file("preset = \"wires\"\nmass_kg = 1\ncart_mass_kg = -1\n"));
        assert!(line.contains("mine.toml, line 3: cart_mass_kg"), "{line}");
    }
}
