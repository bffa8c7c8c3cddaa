//! Scenarios: a true rig, what the controller believes, how long, and what happens when. In TOML.

mod builtin;
mod change;
mod complaint;
mod definition;
mod event;
mod file;
mod ground;
mod hardware;
mod sensor_fault;
mod words;

use std::ffi::OsStr;
use std::path::Path;

use files::UserError;
use files::read_text;
use files::rigfile::nearest;

pub use builtin::BUILTIN;
pub use change::RigChange;
pub use definition::{Expect, Scenario};
pub use event::{ScenarioAct, StartMode, Stuck, Timed};
pub use file::parse;
pub(crate) use hardware::MOST_FORCE_N;
pub use sensor_fault::{SensorDefect, SensorFault, Which};

/// The built-in scenario called `name`, or the one in the file of that path.
///
/// # Errors
/// There is no such scenario or file, or it is wrong, as [`parse`] says.
pub fn load(name: impl AsRef<OsStr>) -> Result<Scenario, UserError> {
    let path = Path::new(name.as_ref());
    let name = path.to_string_lossy();
    if let Some((_, text)) = BUILTIN.iter().find(|(n, _)| *n == name) {
        return parse(&name, text, &name);
    }
    let looks_like_a_file = path.extension().is_some() || path.components().count() > 1;
    if !looks_like_a_file && !path.exists() {
        let hint = nearest(&name, BUILTIN.iter().map(|(n, _)| *n));
        return Err(UserError::new(format!(
            "no scenario is called '{name}'{hint}; `host-sim scenarios` lists them, or give a FILE.toml"
        )));
    }
    let text = read_text(path)?;
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned());
    parse(stem.as_deref().unwrap_or(&name), &text, &name)
}
