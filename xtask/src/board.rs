//! The image that is flashed, in the executable model of the board (tests/board).

use std::{
    path::{Path, PathBuf},
    process::Command,
};

use crate::{
    Outcome, boards, command,
    desktop::{self, Build},
    firmware, python,
};

/// What every change is checked with.
pub const SHORT: &[&str] = &["--short"];
/// States in which each instruction of the image is compared with Unicorn's: at every change, and if nothing is said.
pub const FEW_STATES: &str = "1";
const STATES: &str = "4";

/// Builds the image and the model, and runs the one in the other; `words` go to the model. With `--oracle` the model's processor is
/// compared with another.
pub fn run(words: &[&str], build: &Build) -> Outcome {
    match words {
        ["--oracle"] => return compare(STATES, build, &oracle()?),
        ["--oracle", states] => return compare(states, build, &oracle()?),
        _ => {}
    }
    firmware::build_named(boards::NUCLEO)?;
    let mut board = Command::new(desktop::program("board", build)?);
    board.current_dir(command::root());
    command::run(board.arg(firmware::image(boards::NUCLEO)).args(words))
}

/// Unicorn, in an environment of its own.
pub fn oracle() -> Outcome<PathBuf> {
    python::environment("oracle", &["unicorn==2.1.4"])
}

/// Compares the model's processor with Unicorn's, an instruction of the image at a time, each in so many random states.
pub fn compare(states: &str, build: &Build, oracle: &Path) -> Outcome {
    firmware::build_named(boards::NUCLEO)?;
    let program = desktop::program("board", build)?.with_file_name("one-instruction");
    let mut compare = Command::new(oracle.join("bin/python"));
    compare
        .current_dir(command::root())
        .arg("tests/board/oracle/compare.py")
        .arg(program)
        .arg(firmware::image(boards::NUCLEO))
        .arg(states);
    command::run(&mut compare)
}
