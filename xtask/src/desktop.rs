//! The desktop's programs, built: `host-sim`, and `board`, the model of the board.

use std::path::PathBuf;

use crate::{
    JobResult,
    command::{cargo, run_tee},
};

/// What Cargo is asked for to have it.
pub enum Build {
    /// The program and what it needs.
    Alone,
    /// The one the host tests run: it is there after them, while `Alone` would build it again with other features of
    /// its dependencies.
    Tested,
}

impl Build {
    fn words<'a>(&self, name: &'a str) -> [&'a str; 3] {
        match self {
            Self::Alone => ["build", "--package", name],
            Self::Tested => ["test", "--workspace", "--no-run"],
        }
    }
}

/// Builds the program of that name; where it is.
pub fn program(name: &str, build: &Build) -> JobResult<PathBuf> {
    built(name, &build.words(name), |message| {
        executable(name, message)
    })
}

/// Builds `host-sim` as its users do; where it is.
pub fn released() -> JobResult<PathBuf> {
    let words = ["build", "--release", "--package", "host-sim"];
    built("host-sim", &words, |message| {
        executable("host-sim", message)
    })
}

/// The shared library of that name, as the host tests have it; where it is.
pub fn library(name: &str) -> JobResult<PathBuf> {
    let ours = format!("/lib{name}.so");
    built(name, &Build::Tested.words(name), |message| {
        message
            .split('"')
            .find(|part| part.ends_with(&ours))
            .map(PathBuf::from)
    })
}

/// Builds, and finds what is looked for in Cargo's messages.
fn built(name: &str, words: &[&str], look: impl Fn(&str) -> Option<PathBuf>) -> JobResult<PathBuf> {
    let mut command = cargo();
    command.args(words);
    command.args(["--message-format", "json-render-diagnostics"]);
    let messages = run_tee(&mut command, false)?;
    let path = messages.iter().find_map(|message| look(message));
    path.ok_or_else(|| format!("cargo names no {name}").into())
}

/// The path in Cargo's message about the program; none in other messages, the one about its unit tests among
/// them.
fn executable(name: &str, message: &str) -> Option<PathBuf> {
    let ours = [
        r#""kind":["bin"]"#,
        &format!(r#""name":"{name}""#),
        r#""test":false}"#,
    ];
    if !ours.iter().all(|part| message.contains(part)) {
        return None;
    }
    let (_, rest) = message.split_once(r#""executable":""#)?;
    rest.split_once('"').map(|(path, _)| path.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_program_is_told_from_its_tests_and_from_the_library() {
        let message = |kind: &str, test: bool, executable: &str| {
            format!(
                r#"{{"reason":"compiler-artifact","target":{{"kind":["{kind}"],"crate_types":["{kind}"],"name":"host-sim","test":true}},"profile":{{"opt_level":"2","test":{test}}},"filenames":[],"executable":{executable},"fresh":true}}"#
            )
        };
        let found = |kind, test, path| executable("host-sim", &message(kind, test, path));
        assert_eq!(
            found("bin", false, r#""/t/host-sim""#),
            Some("/t/host-sim".into())
        );
        assert_eq!(found("bin", true, r#""/t/deps/host_sim-1""#), None);
        assert_eq!(found("lib", false, "null"), None);
    }
}
