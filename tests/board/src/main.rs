//! Runs the board's image in the model: `board ELF [--short | --mutants] [--seconds S] [WORDS]`. `cargo xtask board` builds the image
//! and starts this. WORDS: only the checks whose name has them in it. The exit code is 1 if a check fails.

use std::process::ExitCode;

use board::checks::{Setup, mutants, run};

const USAGE: &str = "board ELF [--short | --mutants] [--seconds S] [WORDS]";

/// What is asked for.
struct Asked {
    setup: Setup,
    mutants: bool,
    wanted: String,
}

fn parse(words: &[String]) -> Result<Asked, String> {
    let (mut wanted, mut mutants) = (Vec::new(), false);
    let mut rest = words.iter();
    let mut setup = Setup::new(rest.next().ok_or(USAGE)?.into());
    while let Some(word) = rest.next() {
        match word.as_str() {
            "--short" => {
                setup.seconds = 2.0;
                setup.short = Some(101);
            }
            "--mutants" => mutants = true,
            "--seconds" => {
                let seconds = rest
                    .next()
                    .and_then(|s| s.parse().ok())
                    .filter(|s| (0.1..=3600.0).contains(s));
                setup.seconds = seconds.ok_or("--seconds wants a number from 0.1 to 3600")?;
            }
            other if other.starts_with('-') => return Err(format!("no option {other}: {USAGE}")),
            other => wanted.push(other),
        }
    }
    Ok(Asked {
        setup,
        mutants,
        wanted: wanted.join(" "),
    })
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let asked = match parse(&words) {
        Ok(parsed) => parsed,
        Err(message) => {
            eprintln!("error: {message}");
            return ExitCode::from(2);
        }
    };
    let (failed, what) = if asked.mutants {
        (
            mutants::run(&asked.setup, &asked.wanted),
            "mutant(s) passed",
        )
    } else {
        (Ok(run(&asked.setup, &asked.wanted)), "check(s) failed")
    };
    match failed {
        Ok(0) => return ExitCode::SUCCESS,
        Ok(failed) => eprintln!("error: {failed} {what}"),
        Err(message) => eprintln!("error: {message}"),
    }
    ExitCode::FAILURE
}
