//! The keys of a rig file, and the error that names one.

use std::sync::LazyLock;

use shared::model::contact::LawKind;
use shared::model::params::{ParamError, RigParams};

use crate::UserError;

/// Every key a rig file or `--set` may use, with what it means: the numbers of a rig, and among them the words.
pub static KEYS: LazyLock<Vec<(&'static str, String)>> = LazyLock::new(|| {
    let laws: Vec<_> = LawKind::all().map(LawKind::name).collect();
    let word = |key: &'static str, meaning: &str| (key, meaning.to_owned());
    let mut keys = vec![
        word(
            "preset",
            "rig to start from: wires, beam-170, beam-150 or beam-135",
        ),
        word("support", "suspension of the hammer: wires or beams"),
    ];
    for number in RigParams::numbers() {
        match number.key {
            "damping_ratio" => keys.push(word(
                "torque",
                "moment of the contact force on wires: literal (F l, as printed) or cosine (F l cos)",
            )),
            "contact_stiffness_n_per_m" => keys.push(("contact_law", either(&laws))),
            _ => {}
        }
        keys.push(word(number.key, number.meaning));
    }
    keys.push(word("description", "free text"));
    keys
});

/// `a, b or c`.
fn either(words: &[&str]) -> String {
    match words {
        [first @ .., last] if !first.is_empty() => format!("{} or {last}", first.join(", ")),
        _ => words.concat(),
    }
}

/// ` (did you mean 'x'?)`, if one of the names is like `word`; else nothing.
pub fn nearest<'a>(word: &str, among: impl Iterator<Item = &'a str>) -> String {
    // Two letters that changed places weigh too much in a short word.
    let slip = |candidate: &str| word.len() > 2 && strsim::osa_distance(word, candidate) == 1;
    // The dashes of options are alike in all.
    let bare = |word: &'a str| word.trim_start_matches('-');
    let alike = |candidate| strsim::jaro_winkler(word.trim_start_matches('-'), bare(candidate));
    let likeness = |candidate: &'a str| match slip(candidate) {
        true => 0.9_f64.max(alike(candidate)),
        false => alike(candidate),
    };
    among
        .map(|candidate| (likeness(candidate), candidate))
        .filter(|(likeness, _)| *likeness > 0.75)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(String::new(), |(_, candidate)| {
            format!(" (did you mean '{candidate}'?)")
        })
}

/// Why keys and values make no rig.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NoRig {
    /// The key that is wrong or missing.
    pub key: String,
    /// What is wrong and what to do, in one line.
    line: String,
}

impl NoRig {
    pub fn new(key: &str, line: String) -> Self {
        Self {
            key: key.to_owned(),
            line,
        }
    }
}

impl From<ParamError> for NoRig {
    fn from(error: ParamError) -> Self {
        Self::new(error.key, error.to_string())
    }
}

impl From<NoRig> for UserError {
    fn from(error: NoRig) -> Self {
        Self::new(error.line)
    }
}
