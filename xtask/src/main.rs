//! The caretaker: checks a change, builds the firmware, runs it in QEMU.
//!
//! `cargo xtask help` lists its jobs: those of [`Job`].

mod board;
mod boards;
mod budgets;
mod checks;
mod command;
mod desktop;
mod dist;
mod firmware;
mod first_answer;
mod flash;
mod forecast;
mod golden;
#[cfg(test)]
mod layers;
mod liveness;
#[cfg(test)]
mod metadata;
mod msrv;
mod pil;
mod python;
mod qemu;
mod site;
mod size;
mod speed;
mod ticks;
mod timing;
mod tools;
mod web;

use std::process::ExitCode;

use clap::Parser;

use checks::CheckPart;
use desktop::Build;

/// What a caretaker's job ends with; the error is meant to be read by a person.
pub type JobResult<T = ()> = Result<T, Box<dyn std::error::Error>>;

/// A job for the caretaker.
#[derive(Debug, PartialEq, Parser)]
#[command(name = "xtask", bin_name = "cargo xtask")]
enum Job {
    /// Everything that must hold before a change is done, or one part of it
    ///
    /// Unpacks the tools it lacks on Debian, else says what to install.
    Test(CheckPart),
    /// Get the tools that checks and builds need, and list them
    Tools,
    /// Build the firmware
    Firmware {
        /// A folder of firmware/src/hardware (default: every one)
        #[arg(long, value_parser = board_named)]
        board: Option<boards::BuiltBoard>,
    },
    /// Run the firmware in QEMU; its verdict is the exit code
    Qemu,
    /// Run the firmware's image under QEMU in a closed loop with the emulator's plant
    ///
    /// Compares its every output with the desktop's, bit for bit.
    Pil(pil::PilPlan),
    /// Run the image for the NUCLEO-F446RE in a model of that board
    ///
    /// Boots, the closed loop with the emulator's plant (60 s), faults, power cuts. With --mutants it runs with one mistake in
    /// its set-up after another: each must be caught. Other options: --short, --seconds S.
    Board {
        /// Compare the model's processor with Unicorn's, each instruction of the image in so many random states
        ///
        /// Needs Python, and the network once.
        #[arg(long, value_name = "STATES", num_args = 0..=1, default_missing_value = board::STATES)]
        oracle: Option<String>,
        /// Only what has one of these words in its name, and the options above
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        words: Vec<String>,
    },
    /// Build the Python package into target/python, and run its tests
    Python {
        /// For pytest
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        words: Vec<String>,
    },
    /// Build what is handed out into target/dist: archive, Python wheel, page, checksums
    ///
    /// Tries the wheel in an environment of its own.
    Dist {
        /// Only pack the program of the tests, twice, and look at the archive
        #[arg(long)]
        check: bool,
    },
    /// Build the site into target/site
    ///
    /// The pages of docs/ with their links followed, the documentation of the crates and of the Python package, the chapter's
    /// figures (five minutes on two cores) and the page.
    Site {
        /// The pages alone (Sphinx makes them: needs Python, and the network once)
        #[arg(long)]
        check: bool,
    },
    /// Build the page into target/web/index.html
    Web {
        /// Run it in headless Chromium, too, and compare its numbers with host-sim's
        #[arg(long)]
        test: bool,
        /// For pytest
        #[arg(trailing_var_arg = true, allow_hyphen_values = true, requires = "test")]
        words: Vec<String>,
    },
    /// Build the page and the program with it, and run `host-sim lab`
    Lab {
        /// Run `host-sim link PORT --page` instead
        #[arg(long, value_name = "PORT")]
        board: Option<String>,
        /// For the program, such as --no-open
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        options: Vec<String>,
    },
    /// Count the instructions of each tick of the model and of a forecast, under QEMU
    ///
    /// The forecast must be this machine's.
    BenchTicks,
    /// Flash, RAM, stack and instructions per tick against firmware/budgets.toml
    Size,
    /// Build host-sim from nothing and run `pick`: wall and processor time of both, and where cargo shows each crate's
    FirstAnswer,
    /// Processor time of pick, map, trials and others as multiples of one reference run's, against bounds
    ///
    /// Added to target/speed.csv, too.
    Speed,
    /// Ask a fixed list of requests and compare every table and JSON with the check sums in xtask/golden.txt
    ///
    /// For a change that is to change no answer.
    Golden {
        /// Write the check sums anew
        #[arg(long)]
        write: bool,
    },
    /// Check the workspace with the oldest Rust it supports, if that is installed
    Msrv {
        /// Only print which that is
        #[arg(long)]
        version: bool,
    },
    /// Build for a board, flash it and show its log
    Flash {
        /// A folder of firmware/src/hardware
        #[arg(long, value_parser = board_named, default_value = boards::NUCLEO)]
        board: boards::BuiltBoard,
    },
}

fn board_named(name: &str) -> Result<boards::BuiltBoard, String> {
    boards::named(name).map_err(|error| error.to_string())
}

fn run(job: Job) -> JobResult {
    const ALONE: Build = Build::Alone;
    match job {
        Job::Test(part) => checks::run(&part)?,
        Job::Tools => tools::list()?,
        Job::Firmware { board } => {
            for board in board.map_or_else(boards::all, |board| Ok(vec![board]))? {
                for image in firmware::build(&board)? {
                    println!("{}", image.display());
                }
            }
        }
        Job::Qemu => drop(qemu::run()?),
        Job::Pil(plan) => pil::run(&plan, &ALONE)?,
        Job::Board { oracle, words } => match oracle {
            Some(states) => board::compare(&states, &ALONE, &board::oracle()?)?,
            None => board::run(&words, &ALONE)?,
        },
        Job::Python { words } => python::run(&words, &ALONE)?,
        Job::Dist { check: true } => dist::check(&ALONE)?,
        Job::Dist { check: false } => dist::whole()?,
        Job::Site { check } => drop(site::run(check)?),
        Job::Web { test: false, .. } => println!("{}", web::build()?.display()),
        Job::Web { test: true, words } => web::test(&words, &ALONE)?,
        Job::Lab { board, options } => web::lab(board, &options)?,
        Job::BenchTicks => {
            ticks::run()?;
            forecast::run()?;
        }
        Job::Size => size::run()?,
        Job::FirstAnswer => first_answer::run()?,
        Job::Speed => speed::run()?,
        Job::Golden { write } => golden::run(write)?,
        Job::Msrv { version: true } => println!("{}", msrv::OLDEST),
        Job::Msrv { version: false } => drop(msrv::run()?),
        Job::Flash { board } => flash::run(&board)?,
    }
    Ok(())
}

fn main() -> ExitCode {
    match run(Job::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    fn parse(words: &[&str]) -> Result<Job, String> {
        let words = ["xtask"].iter().chain(words);
        Job::try_parse_from(words).map_err(|error| error.to_string())
    }

    #[test]
    fn every_command_of_the_help_is_understood() {
        Job::command().debug_assert();
        let help = Job::command().render_help().to_string();
        for word in [
            "test",
            "tools",
            "firmware",
            "qemu",
            "pil",
            "board",
            "python",
            "dist",
            "site",
            "web",
            "lab",
            "bench-ticks",
            "size",
            "first-answer",
            "speed",
            "golden",
            "msrv",
            "flash",
        ] {
            assert!(
                help.contains(&format!("\n  {word}")),
                "{word} is not in the help"
            );
            assert!(parse(&[word]).is_ok(), "{word} is not understood");
        }
    }

    #[test]
    fn one_part_of_the_checks_can_be_chosen() {
        let all = CheckPart::default();
        let host = CheckPart { host: true, ..all };
        let firmware = CheckPart {
            firmware: true,
            ..all
        };
        assert_eq!(parse(&["test"]), Ok(Job::Test(all)));
        assert_eq!(parse(&["test", "--host"]), Ok(Job::Test(host)));
        assert_eq!(parse(&["test", "--firmware"]), Ok(Job::Test(firmware)));
        assert!(parse(&["test", "--host", "--firmware"]).is_err());
        assert!(parse(&["test", "--half"]).is_err());
    }

    #[test]
    fn one_board_can_be_chosen() {
        let nucleo = || boards::named(boards::NUCLEO).unwrap();
        let one = Job::Firmware {
            board: Some(nucleo()),
        };
        assert_eq!(parse(&["firmware", "--board", "nucleo"]), Ok(one));
        let every = Job::Firmware { board: None };
        assert_eq!(parse(&["firmware"]), Ok(every));
        for words in [&["flash"][..], &["flash", "--board", "nucleo"]] {
            assert_eq!(parse(words), Ok(Job::Flash { board: nucleo() }));
        }
    }

    #[test]
    fn options_are_passed_on_to_the_programs() {
        let words = |words: &[&str]| words.iter().map(|&word| word.to_owned()).collect();
        let oracle = |states: Option<&str>| states.map(str::to_owned);
        for (asked, states, passed) in [
            (&["--short", "fault"][..], None, &["--short", "fault"][..]),
            (
                &["--mutants", "--seconds", "9"],
                None,
                &["--mutants", "--seconds", "9"],
            ),
            (&["--oracle"], Some(board::STATES), &[]),
            (&["--oracle", "9"], Some("9"), &[]),
        ] {
            let board = Job::Board {
                oracle: oracle(states),
                words: words(passed),
            };
            assert_eq!(parse(&[&["board"], asked].concat()), Ok(board));
        }
        let test = Job::Web {
            test: true,
            words: words(&["-k", "site"]),
        };
        assert_eq!(parse(&["web", "--test", "-k", "site"]), Ok(test));
        assert!(parse(&["web", "-k"]).is_err());
        let lab = Job::Lab {
            board: Some("port".into()),
            options: words(&["--no-open"]),
        };
        assert_eq!(parse(&["lab", "--board", "port", "--no-open"]), Ok(lab));
        let pytest = Job::Python {
            words: words(&["-x", "--lf"]),
        };
        assert_eq!(parse(&["python", "-x", "--lf"]), Ok(pytest));
        assert_eq!(parse(&["dist", "--check"]), Ok(Job::Dist { check: true }));
        assert!(parse(&["dist", "--chek"]).unwrap_err().contains("--chek"));
    }

    #[test]
    fn what_is_not_understood_is_named() {
        assert!(
            parse(&["firmware", "--board", "uno"])
                .unwrap_err()
                .contains("uno")
        );
        assert!(parse(&["tset"]).unwrap_err().contains("tset"));
    }
}
