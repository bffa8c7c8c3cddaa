//! The rig: a preset or the text of a rig file, with parameters set over it, as `files` reads them.

use files::rigfile::{self, KEYS};
use numerics::NamedRig;
use serde::Deserialize;
use serde_json::{Map, Value, json};
use shared::model::contact::LAWS;
use shared::model::params::PRESETS;

use crate::json::{read, write};

/// The rig as the page names it.
#[derive(Clone, Debug, Deserialize)]
pub struct RigAsked {
    /// A preset's name, or the name of the file whose text is given.
    source: String,
    /// The text of a rig file.
    text: Option<String>,
    /// Set over it, `key=value`, as `--set` of the command line.
    #[serde(default)]
    settings: Vec<String>,
    /// Whether the cart recoils under its shaker; left out: as the machine's, where its shaker is known.
    recoil: Option<bool>,
}

impl RigAsked {
    /// The rig.
    ///
    /// # Errors
    /// The line of the reader of rig files.
    pub fn rig(&self) -> Result<NamedRig, String> {
        let rig = match &self.text {
            Some(text) => rigfile::load_text(&self.source, text, &self.settings),
            // Without the text of a file only a preset's name makes sense: there are no files here.
            None if PRESETS.iter().any(|(name, _)| *name == self.source) => {
                rigfile::load(&self.source, &self.settings)
            }
            None => return Err(format!("no rig is called '{}'", self.source)),
        };
        // What is set over the rig came from a field of the page, not from the option.
        let rig = rig.map_err(|e| {
            let line = e.to_string();
            line.strip_prefix("--set: ")
                .map_or(line.clone(), str::to_owned)
        })?;
        match self.recoil {
            Some(false) => Ok(rig.prescribed()),
            Some(true) => rig.recoiling().ok_or_else(|| {
                format!(
                    "the shaker of rig {} is not known; set shaker_loop_hz, or take a prescribed cart",
                    rig.name
                )
            }),
            None => Ok(rig.recoiling().unwrap_or(rig)),
        }
    }

    /// The rig at `gap_mm`.
    ///
    /// # Errors
    /// As [`Self::rig`]; also if the rig cannot have this gap.
    pub fn at_gap(&self, gap_mm: f64) -> Result<NamedRig, String> {
        let mut rig = self.rig()?;
        rig.params = rig.params.with_gap_mm(gap_mm).map_err(|e| e.to_string())?;
        Ok(rig)
    }
}

/// Everything of a rig that the page shows.
pub fn rig(argument: &[u8]) -> Result<Vec<u8>, String> {
    let asked: RigAsked = read(argument)?;
    let rig = asked.rig()?;
    let whole = rig.recoiling().unwrap_or_else(|| rig.clone());
    let meanings = KEYS
        .iter()
        .map(|(key, meaning)| ((*key).to_owned(), meaning.as_str().into()));
    write(&json!({
        "name": rig.name,
        "parameters": rigfile::parameters_of(&whole.params),
        "meanings": meanings.collect::<Map<String, Value>>(),
        "toml": rigfile::to_toml(&rig),
        "notes": rigfile::doubts(&rig.params),
        "shaker_known": rig.shaker.is_some(),
        "natural_frequency_hz": rig.params.natural_frequency_hz(),
        "weight_n": rig.params.weight_n(),
        "amplitude_mm": rig.params.amplitude_m * 1e3,
        "version": env!("CARGO_PKG_VERSION"),
    }))
}

/// The words that can be chosen, by their key.
pub fn choices(_: &[u8]) -> Result<Vec<u8>, String> {
    write(&json!({
        "preset": PRESETS.map(|(name, _)| name),
        "contact_law": LAWS.map(|(name, _)| name),
        "torque": ["literal", "cosine"],
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rig_is_read_as_the_command_line_reads_it() {
        let text = r#"{"source":"mine.toml","text":"preset = \"wires\"\nmass_kg = 2","settings":["gap_mm=0.5"]}"#;
        let answer: Value = serde_json::from_slice(&rig(text.as_bytes()).unwrap()).unwrap();
        assert_eq!(answer["name"], "mine");
        assert_eq!(answer["parameters"]["mass_kg"], 2.0);
        assert_eq!(answer["parameters"]["gap_mm"], 0.5);
        assert_eq!(answer["shaker_known"], true);
        let refused = r#"{"source":"wires","text":null,"settings":["mass_kg=-1"]}"#;
        let line = rig(refused.as_bytes()).unwrap_err();
        assert!(line.starts_with("mass_kg is -1"), "{line}");
    }

    #[test]
    fn what_is_wrong_is_one_line_that_names_the_place() {
        let wrong = r#"{"source":"mine.toml","text":"preset = \"wires\"\nmas_kg = 2"}"#;
        let line = rig(wrong.as_bytes()).unwrap_err();
        assert!(
            line.contains("mine.toml, line 2") && line.contains("mass_kg"),
            "{line}"
        );
        let line = rig(br#"{"source":"/etc/passwd"}"#).unwrap_err();
        assert!(line.contains("no rig is called"), "{line}");
        assert!(rig(b"{}").unwrap_err().contains("asked wrongly"));
    }
}
