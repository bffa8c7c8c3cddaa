//! A bare root of an older Debian: a few of its packages, unpacked below `target/tools`, from the mirror in use.

use std::{fs, path::PathBuf};

use super::{
    apt::Apt,
    debian::{lock, remove, tools},
};
use crate::Outcome;

/// Packages of an older Debian.
#[derive(Debug)]
pub struct Old {
    /// Its number.
    pub number: &'static str,
    /// Its name in the mirror.
    pub name: &'static str,
    /// The folder of the root below `target/tools`: one for each list of packages.
    pub folder: &'static str,
    /// What is unpacked.
    pub packages: &'static [&'static str],
}

impl Old {
    /// The root, unpacked where that has not been done.
    pub fn provide(&self) -> Outcome<PathBuf> {
        let whole = tools().join(self.folder);
        if whole.is_dir() {
            return Ok(whole);
        }
        let _lock = lock()?;
        if whole.is_dir() {
            return Ok(whole);
        }
        println!(
            "unpacking {} of Debian {} into {} (nothing is installed)",
            self.packages.join(", "),
            self.number,
            whole.display()
        );
        let part = whole.with_extension("part");
        remove(&part)?;
        let tree = part.join("root");
        fs::create_dir_all(&tree)?;
        let apt = Apt::of_release(&part.join("apt"), self.name)?;
        apt.update()?;
        let packages: Vec<_> = self.packages.iter().map(|&name| name.into()).collect();
        apt.unpack(&packages, &tree)?;
        fs::rename(&tree, &whole)?;
        remove(&part)?;
        Ok(whole)
    }
}
