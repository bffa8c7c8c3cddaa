//! Debian's packages without installing them: apt resolves and downloads in a folder of its own, dpkg unpacks them
//! below `target/tools`. Neither root nor the system's package lists are needed, and nothing outside that folder
//! changes.

use std::{
    fs::{self, File, TryLockError},
    io::ErrorKind,
    path::{Path, PathBuf},
    process::Command,
};

use super::{
    apt::Apt,
    toolchain::version_of,
    tree::{STARTERS, library_folders, make_links_relative, started, wrap},
};
use crate::{
    Outcome,
    command::{self, find, output},
};

/// Packages that are unpacked together, with all their libraries.
#[derive(Debug)]
pub struct Bundle {
    /// Its folder below `target/tools`.
    pub name: &'static str,
    /// The packages asked for.
    pub packages: &'static [&'static str],
    /// The programs wanted of them: of `/usr/bin`, or as paths below `/usr`.
    pub programs: &'static [&'static str],
    /// The oldest version of its first program that will do; empty: any.
    pub oldest: &'static str,
}

/// The emulator.
pub const QEMU: Bundle = Bundle {
    name: "qemu",
    packages: &["qemu-system-arm"],
    programs: &["qemu-system-arm"],
    oldest: "",
};

/// Debian's Rust with the sources of `core`.
pub const RUST: Bundle = Bundle {
    name: "rust",
    packages: &["rustc-web", "cargo-web", "rust-web-src", "rust-web-clippy"],
    programs: &["rustc", "cargo", "cargo-clippy", "clippy-driver"],
    oldest: env!("CARGO_PKG_RUST_VERSION"),
};

/// A linker for the microcontroller.
pub const LLD: Bundle = Bundle {
    name: "lld",
    packages: &["lld"],
    programs: &["ld.lld"],
    oldest: "",
};

/// A browser without a window, and letters for it.
pub const CHROMIUM: Bundle = Bundle {
    name: "chromium",
    packages: &["chromium-headless-shell", "fonts-dejavu-core"],
    // What is in `bin` is a script that wants it installed.
    programs: &["lib/chromium/chromium-headless-shell"],
    oldest: "",
};

/// Every tool's folder.
pub fn tools() -> PathBuf {
    command::root().join("target/tools")
}

/// Whether this is a Debian, or one of its descendants.
pub fn here() -> bool {
    find("apt-get").is_some() && find("dpkg-deb").is_some()
}

impl Bundle {
    /// Where its programs are started from once it is unpacked.
    pub fn starters(&self) -> PathBuf {
        tools().join(self.name).join(STARTERS)
    }

    /// The line that installs it into the system instead.
    pub fn install_line(&self) -> String {
        format!(
            "sudo apt-get install --no-install-recommends {}",
            self.packages.join(" ")
        )
    }

    /// Whether it is unpacked, whole, and what this version of xtask asks for.
    pub fn is_there(&self) -> bool {
        fs::read_to_string(tools().join(self.name).join(STAMP))
            .is_ok_and(|stamp| stamp.lines().next() == Some(&self.wanted()))
    }

    /// The stamp's first line.
    fn wanted(&self) -> String {
        format!("wanted: {}", self.packages.join(" "))
    }

    /// Unpacks it where that has not been done; `Err` says in one line why not.
    pub fn provide(&self) -> Outcome {
        if self.is_there() {
            return Ok(());
        }
        let _lock = lock()?;
        // Another run may have unpacked it in the meantime.
        if self.is_there() {
            return Ok(());
        }
        println!(
            "unpacking Debian's {} into {} (nothing is installed)",
            self.packages.join(", "),
            tools().join(self.name).display()
        );
        let part = tools().join(format!("{}.part", self.name));
        self.unpack(&part).map_err(|error| {
            // Its remains are of no use, and the next run begins by removing them anyway.
            let _ = remove(&part);
            format!(
                "cannot get Debian's {}: {error}; check the network and apt's sources",
                self.packages.join(", "),
            )
            .into()
        })
    }

    /// Unpacks into the folder `part` and renames it when it is whole.
    fn unpack(&self, part: &Path) -> Outcome {
        remove(part)?;
        let tree = part.join(self.name);
        fs::create_dir_all(&tree)?;
        let apt = Apt::new(&part.join("apt"))?;
        apt.update()?;
        let packages = apt.resolve(self.packages)?;
        apt.unpack(&packages, &tree)?;
        keep_library_sources(&tree)?;
        make_links_relative(&tree, &tree)?;
        let starters = tree.join(STARTERS);
        fs::create_dir(&starters)?;
        let libraries = library_folders(&tree)?;
        for program in self.programs {
            wrap(&tree, program, &libraries)?;
            let version = version(&starters.join(started(program)))?;
            if *program == self.programs[0] && version_of(&version) < version_of(self.oldest) {
                return Err(format!("{version} is older than {}", self.oldest).into());
            }
        }
        let stamp = format!("{}\n{}\n", self.wanted(), packages.join("\n"));
        fs::write(tree.join(STAMP), stamp)?;
        let whole = tools().join(self.name);
        remove(&whole)?;
        fs::rename(&tree, &whole)?;
        remove(part)
    }
}

/// Names the packages of an unpacked bundle and their versions.
const STAMP: &str = "packages";

fn remove(folder: &Path) -> Outcome {
    match fs::remove_dir_all(folder) {
        Err(e) if e.kind() != ErrorKind::NotFound => {
            Err(format!("cannot remove {}: {e}", folder.display()).into())
        }
        _ => Ok(()),
    }
}

/// Held by whoever unpacks; the system releases it when that process ends, however it ends.
fn lock() -> Outcome<File> {
    fs::create_dir_all(tools())?;
    let file = File::create(tools().join("lock"))?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => {
            println!("waiting for another run that unpacks tools");
            file.lock()?;
        }
        other => other?,
    }
    Ok(file)
}

/// What the program says of its version; an error if it cannot: a library is missing, say.
fn version(program: &Path) -> Outcome<String> {
    output(Command::new(program).arg("--version"))
        .map(|text| text.lines().next().unwrap_or_default().to_owned())
}

/// Of Rust's sources, 440 MB, only those of its library are needed.
fn keep_library_sources(tree: &Path) -> Outcome {
    for sources in fs::read_dir(tree.join("usr/src")).into_iter().flatten() {
        let sources = sources?.path();
        for folder in ["src", "compiler"] {
            remove(&sources.join(folder))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_wanted_package_is_left_to_the_system() {
        for bundle in [QEMU, RUST, LLD, CHROMIUM] {
            for package in bundle.packages {
                assert!(
                    !super::super::apt::FROM_SYSTEM
                        .iter()
                        .any(|start| package.starts_with(start))
                );
            }
        }
    }
}
