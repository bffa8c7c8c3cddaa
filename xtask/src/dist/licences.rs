//! The licences of everything that is compiled into the program and the Python package, gathered from the folders of the
//! crates. Which licences may be used at all, `cargo deny` holds to the list of `deny.toml`.

use std::{
    collections::{BTreeMap, BTreeSet, HashMap},
    fs,
    path::{Path, PathBuf},
};

use serde::Deserialize;

use crate::{
    JobResult,
    command::{self, cargo, root},
};

/// The packages of ours that are handed out.
const HANDED_OUT: &[&str] = &["host-sim", "python", "web"];

/// How the names of files with licences begin.
const NAMES: &[&str] = &[
    "licence",
    "license",
    "copying",
    "unlicense",
    "notice",
    "copyright",
];

#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
    resolve: Resolve,
}

#[derive(Clone, Deserialize)]
struct Package {
    id: String,
    name: String,
    version: String,
    license: Option<String>,
    authors: Vec<String>,
    repository: Option<String>,
    source: Option<String>,
    manifest_path: PathBuf,
}

#[derive(Deserialize)]
struct Resolve {
    nodes: Vec<Node>,
}

#[derive(Deserialize)]
struct Node {
    id: String,
    deps: Vec<Dependency>,
}

#[derive(Deserialize)]
struct Dependency {
    pkg: String,
    dep_kinds: Vec<Kind>,
}

#[derive(Deserialize)]
struct Kind {
    /// None: neither for building nor for tests.
    kind: Option<String>,
}

/// The one text for the archive: every crate with its licence, then every text once, with the crates it is of.
pub fn gather(target: &str) -> JobResult<String> {
    let mut ask = cargo();
    ask.args(["metadata", "--locked", "--format-version", "1"]);
    ask.args(["--filter-platform", target]);
    let metadata: Metadata = serde_json::from_str(&command::output(&mut ask)?)?;
    let ours = fs::read_to_string(root().join("LICENSE"))?;
    let crates = reached(&metadata);
    text_of(&crates, &ours)
}

/// The crates of others that stand below ours, build scripts and tests aside, sorted.
fn reached(metadata: &Metadata) -> Vec<Package> {
    let nodes: HashMap<&str, &Node> = metadata
        .resolve
        .nodes
        .iter()
        .map(|node| (node.id.as_str(), node))
        .collect();
    let own = |package: &&Package| package.source.is_none() && HANDED_OUT.contains(&&*package.name);
    let mut open: Vec<&str> = metadata
        .packages
        .iter()
        .filter(own)
        .map(|package| package.id.as_str())
        .collect();
    let mut seen: BTreeSet<&str> = open.iter().copied().collect();
    while let Some(node) = open.pop().and_then(|id| nodes.get(id)) {
        for dependency in &node.deps {
            let runs = dependency.dep_kinds.iter().any(|kind| kind.kind.is_none());
            if runs && seen.insert(&dependency.pkg) {
                open.push(&dependency.pkg);
            }
        }
    }
    let mut crates: Vec<Package> = metadata
        .packages
        .iter()
        .filter(|package| package.source.is_some() && seen.contains(package.id.as_str()))
        .cloned()
        .collect();
    crates.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));
    crates
}

fn text_of(crates: &[Package], ours: &str) -> JobResult<String> {
    let mut list = String::new();
    let mut texts: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for package in crates {
        let called = format!("{} {}", package.name, package.version);
        let licence = package
            .license
            .as_deref()
            .ok_or_else(|| format!("the crate {called} names no licence"))?;
        let source = package.repository.as_deref().unwrap_or_default();
        list += format!("{called}: {licence} {source}").trim_end();
        list.push('\n');
        for text in texts_of(package, licence, ours)? {
            texts.entry(text).or_default().push(called.clone());
        }
    }
    Ok(whole(&list, texts))
}

fn whole(list: &str, texts: BTreeMap<String, Vec<String>>) -> String {
    let rule = "-".repeat(100);
    let mut sorted: Vec<_> = texts.into_iter().collect();
    sorted.sort_by(|(_, a), (_, b)| a.cmp(b));
    let mut text = format!(
        "The crates that are compiled into the program and the Python package, each with its licence, and below them the\n\
         texts, each once, after the crates it belongs to. The standard library of Rust is in there, too, under\n\
         MIT OR Apache-2.0, both of which stand below. They are used as they are; behind each stands where its sources are.\n\n{list}"
    );
    for (body, crates) in sorted {
        text += &format!("\n{rule}\n{}\n{rule}\n\n{body}\n", crates.join("\n"));
    }
    text
}

/// The texts in the crate's folder. Where there is none and the crate may be used under MIT, that licence with the crate's
/// authors.
fn texts_of(package: &Package, licence: &str, ours: &str) -> JobResult<Vec<String>> {
    let folder = package.manifest_path.parent().unwrap_or(Path::new("."));
    let mut files = Vec::new();
    find(folder, &mut files)?;
    files.sort();
    if files.is_empty() {
        // A choice: no crate asks for another licence as well.
        let mit = licence
            .split([' ', '/', '(', ')'])
            .any(|word| word == "MIT")
            && !licence.contains("AND");
        return match under_mit(package, ours) {
            Some(text) if mit => Ok(vec![text]),
            _ => Err(format!(
                "the crate {} {} has no text of its licence '{licence}' in {}",
                package.name,
                package.version,
                folder.display()
            )
            .into()),
        };
    }
    let read = |file: &PathBuf| {
        let text = String::from_utf8_lossy(&fs::read(file)?).replace("\r\n", "\n");
        Ok(text.trim().to_owned())
    };
    files.iter().map(read).collect()
}

/// Our own licence is MIT: its text with another owner.
fn under_mit(package: &Package, ours: &str) -> Option<String> {
    let who = match package.authors.as_slice() {
        [] => format!("the authors of {}", package.name),
        authors => authors.join(", "),
    };
    let owner = ours.lines().find(|line| line.starts_with("Copyright"))?;
    let text = ours.replacen(owner, &format!("Copyright (c) {who}"), 1);
    Some(text.trim().to_owned())
}

/// The files of licences in a folder and those below it: a font has its own.
fn find(folder: &Path, files: &mut Vec<PathBuf>) -> JobResult {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let name = name.to_ascii_lowercase();
        if path.is_dir() {
            find(&path, files)?;
        } else if NAMES.iter().any(|start| name.starts_with(start)) && !name.ends_with(".rs") {
            files.push(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const OURS: &str = "MIT License\n\nCopyright (c) 2026 us\n\nPermission";

    fn package(folder: &Path, name: &str, licence: Option<&str>) -> Package {
        Package {
            id: name.into(),
            name: name.into(),
            version: "1.0.0".into(),
            license: licence.map(Into::into),
            authors: vec!["A. Author".into()],
            repository: None,
            source: Some("registry".into()),
            manifest_path: folder.join("Cargo.toml"),
        }
    }

    fn gathered(package: Package) -> Result<String, String> {
        text_of(&[package], OURS).map_err(|error| error.to_string())
    }

    #[test]
    fn every_text_of_a_crate_is_there_those_of_its_folders_too() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("fonts")).unwrap();
        fs::write(folder.path().join("LICENSE-MIT"), "of the crate\r\n").unwrap();
        fs::write(folder.path().join("fonts/Licence_OFL.txt"), "of the font").unwrap();
        fs::write(folder.path().join("license.rs"), "no licence").unwrap();
        let text = gathered(package(folder.path(), "a", Some("MIT OR X"))).unwrap();
        assert!(text.contains("a 1.0.0: MIT OR X\n"), "{text}");
        assert!(text.contains("of the crate\n") && text.contains("of the font\n"));
        assert!(!text.contains("no licence"), "{text}");
    }

    #[test]
    fn a_crate_without_a_text_is_under_mit_by_its_authors_or_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let text = gathered(package(folder.path(), "a", Some("X OR MIT"))).unwrap();
        assert!(
            text.contains("Copyright (c) A. Author\n\nPermission"),
            "{text}"
        );
        assert!(!text.contains("2026 us"), "{text}");
        for licence in ["MPL-2.0", "MIT AND MPL-2.0"] {
            let error = gathered(package(folder.path(), "a", Some(licence))).unwrap_err();
            assert!(
                error.contains(&format!("no text of its licence '{licence}'")),
                "{error}"
            );
        }
    }

    #[test]
    fn a_crate_that_names_no_licence_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("COPYING"), "text").unwrap();
        let error = gathered(package(folder.path(), "b", None)).unwrap_err();
        assert!(error.contains("b 1.0.0 names no licence"), "{error}");
    }
}
