//! Whose a file is that stands where one is to be written.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::{KEY, MadeFrom};
use crate::UserError;

/// Why a file must not be replaced.
#[derive(Clone, Debug, PartialEq)]
pub enum NotOurs {
    /// Another request made it.
    Other(PathBuf, Box<MadeFrom>),
    /// It does not say what it was made from.
    Unknown(PathBuf),
}

/// What the JSON file at `path` says it was made from; `Some(None)` if there is a file that does not say.
pub fn standing(path: &Path) -> Option<Option<MadeFrom>> {
    #[derive(Deserialize)]
    struct Carrier {
        made_from: Box<MadeFrom>,
    }
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Answer {
        One(Carrier),
        List(Vec<serde_json::Value>),
    }
    if !path.exists() {
        return None;
    }
    let bytes = fs::read(path).unwrap_or_default();
    let said = match serde_json::from_slice::<Answer>(&bytes) {
        Ok(Answer::One(carrier)) => Some(*carrier.made_from),
        Ok(Answer::List(list)) => list
            .first()
            .and_then(|first| serde_json::from_value(first.get(KEY)?.clone()).ok()),
        Err(_) => None,
    };
    Some(said)
}

/// Checks that none of the files `names` in `dir` would replace what another request made. The JSON among them tells
/// whose the others are.
///
/// # Errors
/// [`NotOurs`], the first that is another's.
pub fn refuse_others<'a>(
    dir: &Path,
    names: impl IntoIterator<Item = &'a str> + Clone,
    made: &MadeFrom,
) -> Result<(), NotOurs> {
    let mut ours = false;
    for name in names.clone().into_iter().filter(|n| n.ends_with(".json")) {
        let path = dir.join(name);
        match standing(&path) {
            None => {}
            Some(None) => return Err(NotOurs::Unknown(path)),
            Some(Some(other)) if other.same_request(made) => ours = true,
            Some(Some(other)) => return Err(NotOurs::Other(path, Box::new(other))),
        }
    }
    let taken = names.into_iter().map(|name| dir.join(name));
    match taken.into_iter().find(|path| path.exists()) {
        Some(path) if !ours => Err(NotOurs::Unknown(path)),
        _ => Ok(()),
    }
}

impl From<NotOurs> for UserError {
    fn from(why: NotOurs) -> Self {
        let mend = "give --out another folder, or --replace to replace it";
        Self::new(match why {
            NotOurs::Unknown(path) => format!(
                "{} is there and does not say what it was made from; {mend}",
                path.display()
            ),
            NotOurs::Other(path, other) => format!(
                "{} was made from something else ({}); {mend}",
                path.display(),
                other.command
            ),
        })
    }
}
