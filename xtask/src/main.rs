//! The caretaker: checks a change, builds the firmware, runs it in QEMU.
//!
//! ```text
//! cargo xtask test          everything that must hold before a change is done
//! cargo xtask tools         gets the tools that checks and builds need, and lists them
//! cargo xtask firmware      builds the firmware
//! cargo xtask qemu          runs it in QEMU
//! cargo xtask pil           runs the image in a closed loop, and compares it with the desktop bit for bit
//! cargo xtask board         runs the board's image in a model of the board, in a closed loop and through its faults
//! cargo xtask python        builds the Python package and tests it against the command line
//! cargo xtask dist          builds what is handed out: archive, wheel, checksums
//! cargo xtask site          builds the site: the pages of docs/, documentation of the code
//! cargo xtask web           builds the page; with --test also tests it in a browser
//! cargo xtask lab           builds the page and the program with it, and opens it
//! cargo xtask bench-ticks   counts instructions per tick of the model and of a forecast
//! cargo xtask size          holds flash, RAM, stack and instructions to their budgets
//! cargo xtask first-answer  times a build from nothing and the first answer
//! cargo xtask golden        compares the answers of a list of requests with those before
//! cargo xtask msrv          checks the workspace with the oldest Rust it supports
//! cargo xtask flash         puts the firmware on a NUCLEO-F446RE
//! ```

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

use checks::CheckPart;

/// What a caretaker's job ends with; the error is meant to be read by a person.
pub type JobResult<T = ()> = Result<T, Box<dyn std::error::Error>>;

const HELP: &str = "\
cargo xtask COMMAND

  test [--host | --firmware]  everything that must hold before a change is done, or one part of it;
                              unpacks the tools it lacks on Debian, else says what to install
  tools                       get the tools that checks and builds need, and list them
  firmware [--board BOARD]    build the firmware; BOARD is a folder of firmware/src/hardware (default: every one)
  qemu                        run the firmware in QEMU; its verdict is the exit code
  pil [--scenario NAME] [--seconds S] [--runs N]
                              run the firmware's image under QEMU in a closed loop with the emulator's plant,
                              and compare its every output with the desktop's, bit for bit
                              (default: the field scenario, once, as long as it is)
  board [--short | --mutants | --oracle [STATES]] [--seconds S] [WORDS]
                              run the image for the NUCLEO-F446RE in a model of that board: boots, the closed loop with
                              the emulator's plant (60 s), faults, power cuts; only those with WORDS in their name;
                              --mutants runs it with one mistake in its set-up after another: each must be caught;
                              --oracle compares the model's processor with Unicorn's, each instruction of the image in so
                              many random states (default: 4; needs Python and the network once)
  python [WORDS]              build the Python package into target/python, and run its tests; WORDS go to pytest
  dist [--check]              build what is handed out into target/dist: archive, Python wheel, page, checksums; try the
                              wheel in an environment of its own; with --check only pack the program of the tests,
                              twice, and look at the archive
  site [--check]              build the site into target/site: the pages of docs/ with their links followed, the
                              documentation of the crates and of the Python package, the chapter's figures (five
                              minutes on two cores) and the page; with --check the pages alone (Sphinx makes them: needs
                              Python, and the network once)
  web [--test [WORDS]]        build the page into target/web/index.html; --test runs it in headless Chromium, too, and
                              compares its numbers with host-sim's; WORDS go to pytest
  lab [--board PORT] [OPTIONS]
                              build the page and the program with it, and run `host-sim lab`; with a board,
                              `host-sim link PORT --page`; OPTIONS (such as --no-open) go to the program
  bench-ticks                 count the instructions of each tick of the model and of a
                              forecast, under QEMU; the forecast must be this machine's
  size                        flash, RAM, stack and instructions per tick against firmware/budgets.toml
  first-answer [--json FILE]  build host-sim from nothing and run `pick`: wall and processor time of both, and the
                              ten dearest crates
  speed                       processor time of pick, map, trials and others as multiples of one reference run's, against
                              bounds; added to target/speed.csv, too
  golden [--write]            ask a fixed list of requests and compare every table and JSON with the check sums in
                              xtask/golden.txt: for a change that is to change no answer; --write writes them anew
  msrv [--version]            check the workspace with the oldest Rust it supports, if that is installed;
                              with --version only print which that is
  flash [--board BOARD]       build for the NUCLEO-F446RE (or another board), flash it and show its log
";

/// A parsed command line.
#[derive(Debug, PartialEq)]
enum Job {
    Help,
    Test(CheckPart),
    Tools,
    Firmware(Vec<boards::BuiltBoard>),
    Qemu,
    Pil(pil::PilPlan),
    Board(Vec<String>),
    Python(Vec<String>),
    Dist(dist::DistPlan),
    /// Whether the pages alone are built.
    Site(bool),
    Web,
    WebTest(Vec<String>),
    Lab(Vec<String>),
    BenchTicks,
    Size,
    FirstAnswer(first_answer::FirstAnswerPlan),
    Speed,
    /// Whether the check sums are written anew.
    Golden(bool),
    Msrv,
    OldestRust,
    Flash(boards::BuiltBoard),
}

fn parse(args: &[&str]) -> Result<Job, String> {
    let named = |name| boards::named(name).map_err(|error| error.to_string());
    match args {
        [] | ["help" | "--help" | "-h"] => Ok(Job::Help),
        ["test"] => Ok(Job::Test(CheckPart::All)),
        ["test", "--host"] => Ok(Job::Test(CheckPart::Host)),
        ["test", "--firmware"] => Ok(Job::Test(CheckPart::Firmware)),
        // For `test` itself.
        ["test", "--pages"] => Ok(Job::Test(CheckPart::Pages)),
        ["tools"] => Ok(Job::Tools),
        ["firmware"] => boards::all().map(Job::Firmware).map_err(|e| e.to_string()),
        ["firmware", "--board", name] => named(name).map(|board| Job::Firmware(vec![board])),
        ["qemu"] => Ok(Job::Qemu),
        ["pil", options @ ..] => pil::PilPlan::parse(options).map(Job::Pil),
        ["board", words @ ..] => Ok(Job::Board(words.iter().map(|&word| word.into()).collect())),
        ["python", words @ ..] => Ok(Job::Python(words.iter().map(|&word| word.into()).collect())),
        ["dist", options @ ..] => dist::DistPlan::parse(options).map(Job::Dist),
        ["site"] => Ok(Job::Site(false)),
        ["site", "--check"] => Ok(Job::Site(true)),
        ["web"] => Ok(Job::Web),
        ["web", "--test", words @ ..] => Ok(Job::WebTest(
            words.iter().map(|&word| word.into()).collect(),
        )),
        ["lab", words @ ..] => Ok(Job::Lab(words.iter().map(|&word| word.into()).collect())),
        ["first-answer", options @ ..] => {
            first_answer::FirstAnswerPlan::parse(options).map(Job::FirstAnswer)
        }
        ["speed"] => Ok(Job::Speed),
        ["golden"] => Ok(Job::Golden(false)),
        ["golden", "--write"] => Ok(Job::Golden(true)),
        ["msrv"] => Ok(Job::Msrv),
        ["msrv", "--version"] => Ok(Job::OldestRust),
        ["flash"] => named(boards::NUCLEO).map(Job::Flash),
        ["flash", "--board", name] => named(name).map(Job::Flash),
        ["bench-ticks"] => Ok(Job::BenchTicks),
        ["size"] => Ok(Job::Size),
        other => Err(format!(
            "cannot make sense of `{}`; see `cargo xtask help`",
            other.join(" ")
        )),
    }
}

fn run(job: Job) -> JobResult {
    match job {
        Job::Help => print!("{HELP}"),
        Job::Test(part) => checks::run(part)?,
        Job::Tools => tools::list()?,
        Job::Firmware(boards) => {
            for board in &boards {
                for image in firmware::build(board)? {
                    println!("{}", image.display());
                }
            }
        }
        Job::Qemu => drop(qemu::run()?),
        Job::Pil(plan) => pil::run(&plan, &desktop::Build::Alone)?,
        Job::Board(words) => {
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            board::run(&words, &desktop::Build::Alone)?;
        }
        Job::Python(words) => {
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            python::run(&words, &desktop::Build::Alone)?;
        }
        Job::Dist(plan) => dist::run(&plan, &desktop::Build::Alone)?,
        Job::Site(check) => drop(site::run(check)?),
        Job::Web => println!("{}", web::build()?.display()),
        Job::WebTest(words) => {
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            web::test(&words, &desktop::Build::Alone)?;
        }
        Job::Lab(words) => {
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            web::lab(&words)?;
        }
        Job::FirstAnswer(plan) => first_answer::run(&plan)?,
        Job::Speed => speed::run()?,
        Job::Golden(write) => golden::run(write)?,
        Job::Msrv => drop(msrv::run()?),
        Job::OldestRust => println!("{}", msrv::OLDEST),
        Job::Flash(board) => flash::run(&board)?,
        Job::BenchTicks => {
            ticks::run()?;
            forecast::run()?;
        }
        Job::Size => size::run()?,
    }
    Ok(())
}

fn main() -> ExitCode {
    if let Some(code) = timing::rustc() {
        return code;
    }
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let job = match parse(&args) {
        Ok(job) => job,
        Err(message) => {
            eprintln!("error: {message}");
            return ExitCode::from(2);
        }
    };
    match run(job) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_of_the_help_is_understood() {
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
                HELP.contains(&format!("\n  {word}")),
                "{word} is not in the help"
            );
            assert!(parse(&[word]).is_ok(), "{word} is not understood");
        }
    }

    #[test]
    fn one_part_of_the_checks_can_be_chosen() {
        assert_eq!(parse(&["test"]), Ok(Job::Test(CheckPart::All)));
        assert_eq!(parse(&["test", "--host"]), Ok(Job::Test(CheckPart::Host)));
        assert_eq!(
            parse(&["test", "--firmware"]),
            Ok(Job::Test(CheckPart::Firmware))
        );
        assert!(parse(&["test", "--half"]).is_err());
    }

    #[test]
    fn one_board_can_be_chosen() {
        let nucleo = boards::named(boards::NUCLEO).unwrap();
        assert_eq!(
            parse(&["firmware", "--board", "nucleo"]),
            Ok(Job::Firmware(vec![nucleo.clone()]))
        );
        let all = boards::all().unwrap();
        assert_eq!(parse(&["firmware"]), Ok(Job::Firmware(all)));
        assert_eq!(parse(&["flash"]), Ok(Job::Flash(nucleo.clone())));
        assert_eq!(
            parse(&["flash", "--board", "nucleo"]),
            Ok(Job::Flash(nucleo))
        );
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
