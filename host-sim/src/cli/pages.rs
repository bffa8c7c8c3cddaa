//! Every command line on the pages of the project is one that this program understands.

use std::fs;
use std::path::{Path, PathBuf};

use super::parser;

/// Words of the pages that stand for a value of the reader's.
const PLACEHOLDERS: &[(&str, &str)] = &[
    ("HZ", "3.5"),
    ("R", "2"),
    ("MM", "1"),
    ("N", "1"),
    ("S", "1"),
];

/// The words after `host-sim` of a line, without its remark, what it writes to, and programs behind it. None if it is no such
/// line, or says that something is left out.
fn words(line: &str) -> Option<Vec<String>> {
    let line = line.strip_prefix("    ")?.trim_start();
    let line = line.strip_prefix("$ ").unwrap_or(line);
    let line = line
        .strip_prefix("host-sim ")
        .or_else(|| line.strip_prefix("cargo run --release -p host-sim -- "))?;
    let line = line.split("  #").next()?.split(" # ").next()?;
    let line = line.split(['|', '>', '&']).next()?.split("; ").next()?;
    if line.contains(['…', '$', '`', '(']) {
        return None;
    }
    let value = |word: &str| {
        let found = PLACEHOLDERS.iter().find(|(name, _)| *name == word);
        found
            .map_or(word, |(_, value)| value)
            .replace(['"', '\''], "")
    };
    Some(line.split_whitespace().map(value).collect())
}

/// The words of the command in a line of code, or of every piece of code in a row of a table; see [`words`].
fn commands(line: &str) -> Vec<Vec<String>> {
    if !line.starts_with('|') {
        return words(line).into_iter().collect();
    }
    let code = line.split('`').skip(1).step_by(2);
    code.filter_map(|code| words(&format!("    {code}")))
        .collect()
}

fn pages() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let docs = fs::read_dir(root.join("docs")).expect("docs");
    let mut pages: Vec<_> = docs.map(|entry| entry.expect("a page").path()).collect();
    pages.retain(|page| page.extension().is_some_and(|e| e == "md"));
    pages.push(root.join("README.md"));
    pages.sort();
    pages
}

#[test]
fn every_command_line_of_the_pages_is_understood() {
    let mut command = parser();
    let mut count = 0;
    let mut wrong = Vec::new();
    for page in pages() {
        // A line that ends with \ goes on below.
        let text = fs::read_to_string(&page)
            .expect("a page")
            .replace("\\\n", " ");
        for line in text.lines() {
            for words in commands(line) {
                count += 1;
                let line = std::iter::once("host-sim".to_owned()).chain(words);
                if let Err(error) = command.try_get_matches_from_mut(line.clone()) {
                    let line: Vec<_> = line.collect();
                    let why = error.to_string();
                    let why = why.lines().next().unwrap_or("");
                    wrong.push(format!("{}: {}: {why}", page.display(), line.join(" ")));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(count > 80, "{count} lines");
}
