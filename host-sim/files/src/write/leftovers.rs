//! The temporary files that a killed program left in a folder.

use std::collections::HashSet;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::TEMPORARY;

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
    for entry in entries.flatten() {
        let ours = entry.file_name().to_string_lossy().starts_with(TEMPORARY);
        let plain = entry.file_type().is_ok_and(|kind| kind.is_file());
        // Whoever works on a file holds its lock.
        if ours
            && plain
            && let Ok(file) = File::open(entry.path())
            && file.try_lock().is_ok()
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}
