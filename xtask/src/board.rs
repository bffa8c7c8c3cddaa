//! The image that is flashed, in the executable model of the board (tests/board).

use std::process::Command;

use crate::{
    Outcome, boards, command,
    desktop::{self, Build},
    firmware,
};

/// What every change is checked with.
pub const SHORT: &[&str] = &["--short"];

/// Builds the image and the model, and runs the one in the other; `words` go to the model.
pub fn run(words: &[&str], build: &Build) -> Outcome {
    firmware::build_named(boards::NUCLEO)?;
    let mut board = Command::new(desktop::program("board", build)?);
    board.current_dir(command::root());
    command::run(board.arg(firmware::image(boards::NUCLEO)).args(words))
}
