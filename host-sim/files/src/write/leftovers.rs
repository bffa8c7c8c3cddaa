//! What a killed program left in a folder: temporary files, and renames it had begun.

use std::collections::HashSet;
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use tempfile::NamedTempFile;

use super::{TEMPORARY, WriteError, failed, step, temporary_named};

/// How the names of plans begin, and their last line.
const PLAN: &str = ".writing-plan-";
const WHOLE: &str = "all of these";

/// Which file gets which name, on the disk while that is done.
#[derive(Debug)]
pub(super) struct Plan(#[expect(dead_code, reason = "removed when dropped")] NamedTempFile);

impl Plan {
    /// Writes down that each file is to get its name. From now on this is done, whatever becomes of the program.
    pub(super) fn write(pairs: &[(&Path, &Path)]) -> Result<Self, WriteError> {
        let (_, target) = pairs[0];
        let dir = target.parent().unwrap_or_else(|| Path::new("."));
        let dir = if dir.as_os_str().is_empty() {
            Path::new(".")
        } else {
            dir
        };
        let write = || -> io::Result<NamedTempFile> {
            let mut file = temporary_named(dir, PLAN)?;
            let mut text = String::new();
            for (from, to) in pairs {
                // A name that is no text cannot be written down; then a kill may leave some files old.
                let (Some(from), Some(to)) = (line(from), line(to)) else {
                    return Ok(file);
                };
                text += &format!("{from}\n{to}\n");
            }
            step()?;
            file.write_all(format!("{text}{WHOLE}\n").as_bytes())?;
            file.as_file().sync_all()?;
            Ok(file)
        };
        write().map(Self).map_err(|source| failed(dir, source))
    }
}

/// The absolute path as a line of text.
fn line(path: &Path) -> Option<String> {
    let path = std::path::absolute(path).ok()?;
    let text = path.to_str()?;
    (!text.contains('\n')).then(|| text.to_owned())
}

/// Removes what killed programs left in `dir`, once in a program's life. Never fails: what cannot be removed stays.
pub(super) fn sweep(dir: &Path) {
    static SWEPT: Mutex<Option<HashSet<PathBuf>>> = Mutex::new(None);
    let Ok(dir) = dir.canonicalize() else {
        return;
    };
    let mut swept = SWEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if swept.get_or_insert_default().insert(dir.clone()) {
        sweep_now(&dir);
    }
}

/// The same, however often.
pub(super) fn sweep_now(dir: &Path) {
    let Ok(entries) = fs::read_dir(dir) else {
        return;
    };
    let mut left: Vec<(PathBuf, File)> = Vec::new();
    for entry in entries.flatten() {
        let ours = entry.file_name().to_string_lossy().starts_with(TEMPORARY);
        let plain = entry.file_type().is_ok_and(|kind| kind.is_file());
        if !ours || !plain {
            continue;
        }
        // Whoever works on a file holds its lock.
        if let Ok(file) = File::open(entry.path())
            && file.try_lock().is_ok()
        {
            left.push((entry.path(), file));
        }
    }
    let is_plan = |path: &Path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with(PLAN)
    };
    for (path, file) in &mut left {
        if is_plan(path) {
            finish(file);
        }
    }
    for (path, _) in &left {
        // What a plan named is gone from here.
        let _ = fs::remove_file(path);
    }
}

/// Does the rest of a plan, if it is whole.
fn finish(plan: &mut File) {
    let mut text = String::new();
    if plan.read_to_string(&mut text).is_err() {
        return;
    }
    let Some(pairs) = text.strip_suffix(&format!("{WHOLE}\n")) else {
        return;
    };
    let lines: Vec<_> = pairs.lines().collect();
    for pair in lines.chunks_exact(2) {
        // Those that were renamed before are no longer there.
        let _ = fs::rename(pair[0], pair[1]);
    }
}
