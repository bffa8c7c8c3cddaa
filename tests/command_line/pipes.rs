//! A reader that goes away is no error and no panic.

use std::process::Stdio;

use crate::support::{Folder, finish, wait};

#[test]
fn closed_standard_output_is_no_error() {
    for line in [
        "sweep --ratio 1.5:1.6:0.01 --cycles 20 --transient 10 --format csv",
        "simulate --ratio 1.5 --cycles 20 --transient 10",
        "rigs",
        "--help",
    ] {
        let words: Vec<_> = line.split_whitespace().collect();
        let mut child = Folder::new()
            .command(&words)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        drop(child.stdout.take());
        let mut stderr = child.stderr.take().expect("a pipe");
        assert_eq!(wait(child).code(), Some(0), "{line}");
        let mut said = String::new();
        std::io::Read::read_to_string(&mut stderr, &mut said).expect("UTF-8");
        assert_eq!(said, "", "{line}");
    }
}

#[test]
fn closed_standard_error_is_no_error_and_spoils_no_file() {
    let folder = Folder::new();
    let line = "simulate --ratio 1.5 --cycles 20 --transient 10 --out o";
    let words: Vec<_> = line.split_whitespace().collect();
    let mut child = folder
        .command(&words)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    drop(child.stderr.take());
    assert_eq!(wait(child).code(), Some(0));
    assert_eq!(folder.names().len(), 6);
    let mut child = folder
        .command(&["simulate"])
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    drop(child.stderr.take());
    assert_eq!(wait(child).code(), Some(2));
}

#[test]
fn help_and_version_are_answers() {
    for (line, says) in [
        ("--help", "pick"),
        ("pick --help", "--max-drive-force-n"),
        ("simulate --help", "--initial"),
        ("sweep --help", "--measured"),
        ("rigs --help", "TOML"),
        ("--version", env!("CARGO_PKG_VERSION")),
    ] {
        let folder = Folder::new();
        let words: Vec<_> = line.split_whitespace().collect();
        let ran = finish(folder.command(&words)).well();
        assert!(
            ran.out.contains(says) && ran.err.is_empty(),
            "{line}: {ran:?}"
        );
    }
}
