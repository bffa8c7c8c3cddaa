//! The program under limits of the system, as a shell sets them: on the size of a file and on memory. Whatever is
//! refused, and wherever, the older files stay as they were or the new ones are whole. A file that may grow no further
//! is told in one line, and nothing else is left; for want of memory Rust ends the program as a signal would.
#![cfg(target_os = "linux")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

const PROGRAM: &str = env!("CARGO_BIN_EXE_host-sim");

/// A run of a twentieth of a second.
const SCENARIO: &str =
    "duration_s = 0.05\n[true_rig]\npreset = \"wires\"\n[shaker]\nprescribed = true\n";

/// Runs the program in `folder` under a `ulimit`; none: without.
fn run(folder: &Path, limit: Option<String>, arguments: &[&str]) -> Output {
    let limit = limit.map_or(String::new(), |limit| format!("ulimit {limit} && "));
    Command::new("sh")
        .args(["-c", &format!("{limit} exec \"$0\" \"$@\""), PROGRAM])
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

/// The name of a file and what is in it.
type File = (String, Vec<u8>);

/// The files in a folder, but for those that a program that was killed was writing.
fn files(folder: &Path) -> Vec<File> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    let mut files: Vec<_> = entries
        .map(|entry| {
            let name = entry.file_name().into_string().unwrap();
            (name, fs::read(entry.path()).unwrap())
        })
        .filter(|(name, _)| !name.starts_with(".writing-"))
        .collect();
    files.sort();
    files
}

/// A refused run says so in one line, and leaves nothing beside the files.
fn check_told(out: &Path, done: &Output, limit: u64, says: &str) {
    let line = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(2), "limit {limit}: {line}");
    assert_eq!(line.lines().count(), 1, "limit {limit}: {line}");
    assert!(line.starts_with("error: "), "limit {limit}: {line}");
    assert!(line.contains(says), "limit {limit}: {line}");
    let left = fs::read_dir(out).unwrap().count();
    assert_eq!(left, files(out).len(), "limit {limit}: more is left");
}

/// Each file is as it was, or whole and new.
fn check_whole(out: &Path, [old, new]: [&[File]; 2], limit: u64) {
    let left = files(out);
    let names =
        |files: &[File]| -> Vec<String> { files.iter().map(|(name, _)| name.clone()).collect() };
    assert_eq!(names(&left), names(old), "limit {limit}");
    for (left, (old, new)) in left.iter().zip(old.iter().zip(new)) {
        let name = &left.0;
        assert!(left == old || left == new, "limit {limit}: half of {name}");
    }
}

/// Runs `arguments` under `ulimit` with each of `limits`, over files that are there; how many runs were refused, each with
/// a line that holds `says`, if it is given. The last must succeed.
fn under(
    ulimit: &str,
    limits: impl Iterator<Item = u64>,
    arguments: &[&str],
    says: Option<&str>,
) -> u32 {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("short.toml"), SCENARIO).unwrap();
    let out = folder.path().join("o");
    let done = run(folder.path(), None, arguments);
    assert!(done.status.success(), "{done:?}");
    let new = files(&out);
    assert!(!new.is_empty());
    for (refused, limit) in (0..).zip(limits) {
        for (name, _) in &new {
            // An answer that may be replaced.
            fs::write(out.join(name), "\"made_from\": old").unwrap();
        }
        let old = files(&out);
        let done = run(folder.path(), Some(format!("{ulimit} {limit}")), arguments);
        if done.status.success() {
            assert!(files(&out) == new, "limit {limit}: another answer");
            return refused;
        }
        check_whole(&out, [&old, &new], limit);
        if let Some(says) = says {
            check_told(&out, &done, limit, says);
        }
    }
    panic!("no limit was large enough");
}

/// Limits from `from` on, each so many percent of the one before.
fn rising(from: u64, percent: u64) -> impl Iterator<Item = u64> {
    let next = move |n: &u64| Some((n * percent / 100).max(n + 1));
    std::iter::successors(Some(from), next).take(200)
}

#[test]
fn a_limit_on_the_size_of_files_leaves_no_half_answer() {
    let arguments = ["contact", "--speed", "0.1:0.2:0.1", "--out", "o"];
    let refused = under("-f", rising(0, 150), &arguments, Some("cannot write"));
    assert!(refused >= 4, "{refused}");
}

#[test]
fn a_limit_on_the_size_of_files_leaves_no_half_log() {
    let arguments = ["emulate", "short.toml", "--out", "o"];
    let refused = under("-f", rising(0, 150), &arguments, Some("File too large"));
    assert!(refused >= 4, "{refused}");
}

#[test]
fn too_little_memory_anywhere_leaves_no_half_answer() {
    let arguments = ["emulate", "short.toml", "--out", "o"];
    // With less the program cannot be loaded, and so say nothing.
    let loaded = |limit: &u64| {
        let limit = Some(format!("-v {limit}"));
        run(Path::new("."), limit, &["--version"]).status.success()
    };
    let least = rising(8_000, 105).find(loaded).unwrap();
    let refused = under("-v", rising(least, 112), &arguments, None);
    assert!(refused >= 2, "{refused}");
}
