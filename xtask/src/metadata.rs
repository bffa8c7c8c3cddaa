//! What the packages say of themselves: every manifest is complete, and all of them agree with LICENSE, CHANGELOG.md and
//! CITATION.cff.

use std::fs;

use serde::Deserialize;

use crate::command::{self, cargo, root};

#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
}

#[derive(Deserialize)]
struct Package {
    name: String,
    version: String,
    description: Option<String>,
    license: Option<String>,
    readme: Option<String>,
    rust_version: Option<String>,
    authors: Vec<String>,
    keywords: Vec<String>,
    categories: Vec<String>,
}

/// The packages of the workspace.
fn packages() -> Vec<Package> {
    let mut ask = cargo();
    ask.args(["metadata", "--locked", "--no-deps", "--format-version", "1"]);
    let text = command::output(&mut ask).unwrap();
    serde_json::from_str::<Metadata>(&text).unwrap().packages
}

fn text(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap()
}

/// The owner that LICENSE names.
fn owner() -> String {
    let licence = text("LICENSE");
    let line = licence.lines().find(|line| line.starts_with("Copyright"));
    line.unwrap()
        .trim_start_matches("Copyright (c) ")
        .trim_start_matches(|c: char| c.is_ascii_digit() || c == ' ')
        .into()
}

#[test]
fn every_manifest_is_complete() {
    let packages = packages();
    assert!(packages.len() > 10);
    for package in packages {
        let name = &package.name;
        assert!(package.description.is_some_and(|d| d.len() > 20), "{name}");
        assert_eq!(package.license.as_deref(), Some("MIT"), "{name}");
        assert!(package.readme.is_some(), "{name} has no readme");
        assert!(package.rust_version.is_some(), "{name}");
        assert_eq!(package.authors, [owner()], "{name}");
        // More than five keywords, or one with a space, are not allowed.
        assert!((1..=5).contains(&package.keywords.len()), "{name}");
        assert!(package.keywords.iter().all(|word| !word.contains(' ')));
        assert!(!package.categories.is_empty(), "{name}");
    }
}

#[test]
fn the_python_package_is_complete() {
    let project: toml::Table = toml::from_str(&text("python/pyproject.toml")).unwrap();
    let project = project["project"].as_table().unwrap();
    for key in [
        "name",
        "description",
        "license",
        "readme",
        "requires-python",
    ] {
        assert!(
            project[key].as_str().is_some_and(|v| !v.is_empty()),
            "{key}"
        );
    }
    for key in ["keywords", "classifiers", "authors"] {
        assert!(
            project[key].as_array().is_some_and(|v| !v.is_empty()),
            "{key}"
        );
    }
    assert_eq!(project["license"].as_str(), Some("MIT"));
    assert_eq!(project["authors"][0]["name"].as_str(), Some(&*owner()));
    let readme = project["readme"].as_str().unwrap();
    assert!(root().join("python").join(readme).is_file());
}

#[test]
fn the_citation_agrees_with_the_rest() {
    let citation = text("CITATION.cff");
    let value = |key: &str| {
        let line = citation.lines().find_map(|line| {
            let (found, value) = line.trim_start_matches([' ', '-']).split_once(": ")?;
            (found == key).then_some(value.trim_matches('"'))
        });
        line.unwrap_or_else(|| panic!("CITATION.cff has no {key}"))
    };
    let version = &packages()[0].version;
    assert_eq!(value("cff-version"), "1.2.0");
    assert_eq!(value("version"), version);
    assert_eq!(value("license"), "MIT");
    assert_eq!(value("name"), owner());
    for key in ["message", "title", "type"] {
        assert!(!value(key).is_empty());
    }
    // The day on which that version came out.
    let heading = format!("## {version} ({})", value("date-released"));
    assert!(text("CHANGELOG.md").contains(&heading), "no '{heading}'");
    let readme = text("README.md");
    let flat = readme.split_whitespace().collect::<Vec<_>>().join(" ");
    let chapter =
        "Study of an embarked vibro-impact system: mathematical modeling and nonlinear analysis";
    assert!(citation.contains(chapter) && flat.contains(chapter));
}
