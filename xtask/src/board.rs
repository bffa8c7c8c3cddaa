//! The image that is flashed, in the executable model of the board (tests/board).

use std::{
    path::{Path, PathBuf},
    process::Command,
};

use crate::{
    JobResult, boards, command,
    desktop::{self, Build},
    firmware, python, tools,
};

/// States in which each instruction of the image is compared with Unicorn's: at every change, and if nothing is said.
pub const FEW_STATES: &str = "1";
pub const STATES: &str = "4";

/// Builds the image and the model, and runs the one in the other; `words` go to the model.
pub fn run(words: &[String], build: &Build) -> JobResult {
    firmware::build_named(boards::NUCLEO)?;
    let mut board = Command::new(desktop::program("board", build)?);
    board.current_dir(command::root());
    command::run(board.arg(firmware::image(boards::NUCLEO)).args(words))
}

/// Unicorn, in an environment of its own.
pub fn oracle() -> JobResult<PathBuf> {
    python::environment("oracle", &["unicorn==2.1.4"])
}

/// Compares the model's processor with Unicorn's, an instruction of the image at a time, each in so many random states; and its
/// exceptions with QEMU's, in random programs.
pub fn compare(states: &str, build: &Build, oracle: &Path) -> JobResult {
    firmware::build_named(boards::NUCLEO)?;
    let board = desktop::program("board", build)?;
    let compare = |script: &str, program: &str, with: PathBuf| {
        let mut compare = Command::new(oracle.join("bin/python"));
        compare
            .current_dir(command::root())
            .arg(format!("tests/board/oracle/{script}"))
            .arg(board.with_file_name(program))
            .arg(with)
            .arg(states);
        command::run(&mut compare)
    };
    compare(
        "compare.py",
        "one-instruction",
        firmware::image(boards::NUCLEO),
    )?;
    compare("exceptions.py", "one-program", tools::qemu()?)
}
