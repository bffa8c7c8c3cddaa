//! Running firmware in QEMU. What a program says comes through semihosting, and
//! its verdict is QEMU's exit code.

use std::{process::Command, time::Duration};

use crate::{JobResult, boards, command, firmware, liveness::ProgramWatch, tools};

/// Processor time an emulated run may use: an image that hangs keeps QEMU busy. The longest run of ours takes about a
/// minute of a slow processor.
pub const MOST_WORK: Duration = Duration::from_secs(20 * 60);

/// Builds the firmware, runs the app and returns what it said.
pub fn run() -> JobResult<Vec<String>> {
    firmware::build_named(boards::QEMU)?;
    start("qemu", true)
}

/// Starts a program's image and returns the lines it said; fails if the program does.
fn start(program: &str, echo: bool) -> JobResult<Vec<String>> {
    command::tee(
        &mut command(program, "enable=on,target=native")?,
        ProgramWatch::new()?.working_at_most(MOST_WORK),
        echo,
    )
}

/// QEMU with a program's image, to be started. Counting, so that what the program counts are instructions.
pub fn command(program: &str, semihosting: &str) -> JobResult<Command> {
    let mut command = Command::new(tools::qemu()?);
    command
        .current_dir(command::root())
        .args([
            "-machine",
            "mps2-an386",
            "-display",
            "none",
            "-monitor",
            "none",
            "-serial",
            "none",
        ])
        .args(["-semihosting-config", semihosting])
        .args(["-icount", "shift=0", "-kernel"])
        .arg(firmware::image(program));
    Ok(command)
}

/// What a program said: a word and a number per line, up to its end. Other lines are passed over.
#[derive(Debug)]
pub struct Said(Vec<(String, String)>);

impl Said {
    /// Runs a program that has been built.
    pub fn by(program: &str) -> JobResult<Self> {
        Self::read(&start(program, false)?)
    }

    fn read(lines: &[String]) -> JobResult<Self> {
        if !lines.iter().any(|line| line == "end") {
            return Err("the program did not get to its end".into());
        }
        let pairs = lines.iter().filter_map(|line| line.split_once(' '));
        let owned = pairs.map(|(word, number)| (word.to_owned(), number.to_owned()));
        Ok(Self(owned.collect()))
    }

    /// Every number behind this word.
    pub fn all(&self, word: &str) -> JobResult<Vec<u64>> {
        let of = self.0.iter().filter(|(said, _)| said == word);
        let number = |(_, number): &(String, String)| {
            let parsed = number.parse();
            parsed.map_err(|_| format!("`{word} {number}` holds no count").into())
        };
        of.map(number).collect()
    }

    /// The number behind a word that is said once.
    pub fn number(&self, word: &str) -> JobResult<u64> {
        let number = self.all(word)?.last().copied();
        number.ok_or_else(|| format!("the program did not say `{word}`").into())
    }

    /// A time of the board, in instructions.
    pub fn instructions(&self, word: &str) -> JobResult<u64> {
        Ok(self.number(word)? * self.number("nanoseconds")?)
    }

    /// A text as a program's.
    #[cfg(test)]
    pub fn of(text: &str) -> JobResult<Self> {
        Self::read(&text.lines().map(str::to_owned).collect::<Vec<_>>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_become_instructions_and_what_is_missing_is_named() {
        let said = Said::of("nanoseconds 40\ntotal 5\nhello there\nend").unwrap();
        assert_eq!(said.instructions("total").unwrap(), 200);
        let missing = said.number("worst").unwrap_err().to_string();
        assert!(missing.contains("worst"));
    }

    #[test]
    fn a_run_cut_short_is_an_error() {
        assert!(Said::of("nanoseconds 40").is_err());
    }

    #[test]
    fn a_broken_count_is_named() {
        let said = Said::of("nanoseconds 40\nfree x1\nend").unwrap();
        assert!(
            said.all("free")
                .unwrap_err()
                .to_string()
                .contains("free x1")
        );
    }
}
