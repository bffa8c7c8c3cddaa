//! Sets `KERNEL_FINGERPRINT`: the hash of the sources that decide what a cell of a map shows, so that tiles of builds
//! that could differ are never put together. The compiler and the mathematical functions of the platform are not in it.

use std::fs;
use std::path::{Path, PathBuf};

#[path = "src/fingerprint.rs"]
mod fingerprint;

/// Files and folders, relative to the repository.
const SOURCES: [&str; 7] = [
    "shared/src/model",
    "host-sim/lanes/src",
    "host-sim/numerics/src/engine",
    "host-sim/numerics/src/lanes",
    "host-sim/numerics/src/reference",
    "host-sim/numerics/src/map/compute.rs",
    "host-sim/numerics/src/map/mod.rs",
];

/// Packages outside the repository whose functions the cells are computed with.
const PACKAGES: [&str; 2] = ["libm", "pulp"];

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut names = Vec::new();
    for source in SOURCES {
        println!("cargo:rerun-if-changed={}", root.join(source).display());
        collect(&root, source.to_owned(), &mut names);
    }
    println!(
        "cargo:rerun-if-changed={}",
        root.join("Cargo.lock").display()
    );
    println!("cargo:rerun-if-changed=src/fingerprint.rs");
    names.sort_unstable();
    let mut sources: Vec<(String, String)> = names
        .into_iter()
        .map(|name| {
            let content = read(&root.join(&name));
            (name, content)
        })
        .collect();
    let versions = fingerprint::versions(&read(&root.join("Cargo.lock")), &PACKAGES);
    sources.push(("Cargo.lock".to_owned(), versions));
    let sources = sources
        .iter()
        .map(|(name, content)| (name.as_str(), content.as_str()));
    println!(
        "cargo:rustc-env=KERNEL_FINGERPRINT={:016x}",
        fingerprint::of(sources)
    );
}

/// Adds the Rust sources at or under `name`, each with slashes between folders on every machine.
fn collect(root: &Path, name: String, names: &mut Vec<String>) {
    let path: PathBuf = root.join(&name);
    if path.is_file() {
        names.push(name);
        return;
    }
    let entries = fs::read_dir(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    for entry in entries {
        let entry = entry.unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let child = entry.file_name();
        let child = child.to_string_lossy();
        if entry.path().is_dir() || child.ends_with(".rs") {
            collect(root, format!("{name}/{child}"), names);
        }
    }
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}
