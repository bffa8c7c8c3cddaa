//! The controller's settings as a TOML file: units in the keys, and only what differs need be named.

mod day;
mod keys;
#[cfg(test)]
mod tests;

use shared::model::params::ParamError;
use shared::settings::{DriveKind, Settings};
use toml::{Table, Value};

use crate::UserError;
use crate::decimal::comma_at;
use crate::rigfile::{self, nearest};
use keys::{NUMBERS, SECTIONS, SWITCHES};

/// Settings as a file, every value with its meaning.
pub fn to_toml(settings: &Settings) -> String {
    let mut settings = *settings;
    let mut text = String::from(
        "# Settings of the controller. A file may name only what differs.\n# Send them with: host-sim link PORT set FILE.toml\n",
    );
    for section in SECTIONS {
        text.push_str(&format!("\n[{section}]\n"));
        match section {
            "rig" => text.push_str(&rigfile::lines_onto_any(&settings.rig)),
            "drive" => {
                let kind = kind_name(settings.drive.kind);
                text.push_str(&format!("kind = \"{kind}\"  # shaker or motor\n"));
            }
            _ => {}
        }
        if let Some(calibration) = keys::calibration(&mut settings, section) {
            let day = day::text(calibration.day);
            text.push_str(&format!(
                "calibrated = \"{day}\"  # the day of the calibration, or never\n"
            ));
        }
        for key in keys::of(&SWITCHES, section) {
            let value = *(key.place)(&mut settings);
            text.push_str(&format!("{} = {value}  # {}\n", key.name, key.meaning));
        }
        for key in keys::of(&NUMBERS, section) {
            // As few digits as make the same f32; a point makes it a TOML float.
            let value = *(key.place)(&mut settings);
            text.push_str(&format!("{} = {value:?}  # {}\n", key.name, key.meaning));
        }
    }
    text
}

/// `base` with the file `text` on top, checked as a whole.
///
/// # Errors
/// If the text is not TOML, a key is unknown, or a value is out of range.
pub fn overlay(base: &Settings, text: &str) -> Result<Settings, UserError> {
    let file: Table = toml::from_str(text).map_err(|e| {
        let start = e.span().map_or(0, |s| s.start.min(text.len()));
        let line = text[..start].lines().count().max(1);
        let what = e.message().lines().next().unwrap_or("not TOML").to_owned();
        let mend = comma_at(text, line);
        let mend = mend.unwrap_or_else(|| {
            "settings have sections like [trips] and lines like force_n = 300.0".to_owned()
        });
        UserError::new(format!("line {line}: {what}; {mend}"))
    })?;
    let mut settings = *base;
    let (mut force_n, mut ratio) = (None, None);
    for (section, value) in file {
        if !value.is_table() && !SECTIONS.contains(&section.as_str()) {
            return Err(UserError::new(format!(
                "{section} stands outside a section; settings have sections like [trips] (`host-sim link PORT get` prints them all), and a rig file goes with --rig FILE.toml"
            )));
        }
        if !SECTIONS.contains(&section.as_str()) {
            let hint = nearest(&section, SECTIONS.into_iter());
            return Err(UserError::new(format!(
                "there is no section [{section}]{hint}; `host-sim link PORT get` prints them all"
            )));
        }
        let Value::Table(entries) = value else {
            return Err(UserError::new(format!(
                "{section} must be a section: write [{section}] on a line of its own"
            )));
        };
        if section == "rig" {
            let rig = rigfile::with_table(&settings.rig, entries);
            settings.rig = rig.map_err(|e| e.at("[rig]"))?;
            continue;
        }
        for (key, value) in entries {
            match (section.as_str(), key.as_str()) {
                ("aim", "force_n") => force_n = Some(a_number(&section, &key, &value)?),
                ("aim", "force_ratio") => ratio = Some(a_number(&section, &key, &value)?),
                _ => set(&mut settings, &section, &key, &value)?,
            }
        }
    }
    // In units of the weight of the rig that the file leads to, wherever in it that stands.
    if let Some(force_n) = rigfile::force_wanted(force_n, ratio, &settings.rig)? {
        settings.aim.force_n = force_n;
    }
    settings
        .check()
        .map_err(|error| refusal(&settings, error))?;
    Ok(settings)
}

/// Why `settings` are refused; with a force too low for a contact to be detected, the lowest that is not.
pub fn refusal(settings: &Settings, mut error: ParamError) -> UserError {
    // Settings are f32: as many digits as those have.
    if error.key.contains('.') {
        error.value = (error.value as f32)
            .to_string()
            .parse()
            .unwrap_or(error.value);
    }
    let least_n = settings.least_force_n();
    match error.key {
        "limits.force_n" | "aim.force_n" if error.value < f64::from(least_n) => {
            UserError::new(format!("{error} (here {least_n} N)"))
        }
        _ => error.into(),
    }
}

fn a_number(section: &str, key: &str, value: &Value) -> Result<f64, UserError> {
    rigfile::as_number(value)
        .ok_or_else(|| UserError::new(format!("{section}.{key} is {value}, must be a number")))
}

fn set(settings: &mut Settings, section: &str, key: &str, value: &Value) -> Result<(), UserError> {
    if (section, key) == ("drive", "kind") {
        let kinds = [DriveKind::Shaker, DriveKind::Motor];
        let named = kinds
            .into_iter()
            .find(|k| value.as_str() == Some(kind_name(*k)));
        settings.drive.kind = named.ok_or_else(|| {
            UserError::new(format!(
                "drive.kind is {value}, must be \"shaker\" or \"motor\""
            ))
        })?;
        return Ok(());
    }
    if let (Some(place), "calibrated") = (keys::calibration(settings, section), key) {
        place.day = value.as_str().and_then(day::number).ok_or_else(|| {
            UserError::new(format!(
                "{section}.calibrated is {value}, must be a day such as \"2026-11-23\", or \"never\""
            ))
        })?;
        return Ok(());
    }
    if let Some(known) = keys::of(&SWITCHES, section).find(|known| known.name == key) {
        *(known.place)(settings) = value.as_bool().ok_or_else(|| {
            UserError::new(format!("{section}.{key} is {value}, must be true or false"))
        })?;
        return Ok(());
    }
    if let Some(known) = keys::of(&NUMBERS, section).find(|known| known.name == key) {
        *(known.place)(settings) = a_number(section, key, value)? as f32;
        return Ok(());
    }
    let ratio = (section == "aim").then_some("force_ratio");
    let calibrated = keys::calibration(settings, section).map(|_| "calibrated");
    let names = keys::of(&NUMBERS, section).map(|known| known.name);
    let names = names.chain(keys::of(&SWITCHES, section).map(|known| known.name));
    let hint = nearest(key, names.chain(ratio).chain(calibrated));
    Err(UserError::new(format!(
        "there is no setting {section}.{key}{hint}; `host-sim link PORT get` prints them all"
    )))
}

fn kind_name(kind: DriveKind) -> &'static str {
    match kind {
        DriveKind::Shaker => "shaker",
        DriveKind::Motor => "motor",
    }
}
