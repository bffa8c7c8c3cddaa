//! A reader that goes away is no error and no panic.

use std::process::Stdio;

use crate::support::{Folder, finish, wait};
#[cfg(target_os = "linux")]
use crate::support::{Ran, program};

#[test]
fn closed_standard_output_is_no_error() {
    for line in [
        "sweep --ratio 1.5:1.6:0.01 --cycles 20 --transient 10 --format csv",
        "simulate --ratio 1.5 --cycles 20 --transient 10 --format json",
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
        ("pick --help", "--max-shaker-force-n"),
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

/// Runs `line` in a shell after `before`, with whatever `after` redirects.
#[cfg(target_os = "linux")]
fn in_a_shell(folder: &Folder, before: &str, line: &str, after: &str) -> Ran {
    let script = format!("{before} exec '{}' {line} {after}", program().display());
    let mut shell = std::process::Command::new("sh");
    shell
        .args(["-c", &script])
        .current_dir(folder.path(""))
        .stdin(Stdio::null());
    finish(shell)
}

/// Closed from the start, standard output is as `/dev/null`. A disk that is full is an error: the answer would be lost.
#[cfg(target_os = "linux")]
#[test]
fn standard_output_may_be_closed_but_not_full() {
    let folder = Folder::new();
    for line in [
        "rigs",
        "--help",
        "simulate --ratio 1.5 --cycles 20 --transient 10 --quiet",
    ] {
        for after in [">&-", ">/dev/null"] {
            let ran = in_a_shell(&folder, "", line, after);
            assert_eq!(ran.code, Some(0), "{line}: {ran:?}");
            assert!(ran.err.is_empty(), "{line}: {ran:?}");
        }
    }
    let ran = in_a_shell(&folder, "", "rigs", ">/dev/full");
    assert_eq!(ran.code, Some(2), "{ran:?}");
    assert!(
        ran.err.contains("cannot write to standard output"),
        "{ran:?}"
    );
}

/// A limit on the size of files ends a write with an error, not the program with a signal.
#[cfg(target_os = "linux")]
#[test]
fn files_larger_than_the_limit_are_refused_in_one_line() {
    let folder = Folder::new();
    let line = "simulate --ratio 1.5 --cycles 40 --transient 10 --format json --quiet --out o";
    let ran = in_a_shell(&folder, "ulimit -f 1;", line, "");
    assert_eq!(ran.code, Some(2), "{ran:?}");
    assert_eq!(ran.err.lines().count(), 1, "{ran:?}");
    assert!(ran.err.contains("cannot write o/simulate"), "{ran:?}");
    assert!(folder.names().is_empty(), "{:?}", folder.names());
}

/// A log is written as it comes: the error then has the name asked for, not the temporary one.
#[cfg(target_os = "linux")]
#[test]
fn a_log_that_does_not_fit_is_named_as_it_was_to_be() {
    let folder = Folder::new();
    let ran = in_a_shell(
        &folder,
        "ulimit -f 20;",
        "emulate sudden-gap --quiet --out o",
        "",
    );
    assert_eq!(ran.code, Some(2), "{ran:?}");
    assert_eq!(ran.err.lines().count(), 1, "{ran:?}");
    assert!(ran.err.contains("cannot write o/"), "{ran:?}");
    assert!(!ran.err.contains(".writing-"), "{ran:?}");
}

/// A name that is not UTF-8 is a name like any other.
#[cfg(target_os = "linux")]
#[test]
fn a_folder_s_name_need_not_be_utf_8() {
    use std::os::unix::ffi::OsStrExt;
    let folder = Folder::new();
    let name = std::ffi::OsStr::from_bytes(b"o\xff");
    let line = "simulate --ratio 1.5 --cycles 20 --transient 10 --format json --out";
    let words: Vec<_> = line.split_whitespace().collect();
    let mut command = folder.command(&words);
    command.arg(name);
    finish(command).well();
    let made: Vec<_> = std::fs::read_dir(folder.path(""))
        .expect("a folder")
        .map(|entry| entry.expect("a folder").file_name())
        .collect();
    assert_eq!(made, [name]);
    assert!(
        folder
            .path("")
            .join(name)
            .join("simulate-wires-ratio-1.5-cycles-20-transient-10.json")
            .is_file()
    );
}
