//! The image that is flashed, in the executable model of the board (tests/board).

use std::process::Command;

use crate::{
    Outcome, command,
    desktop::{self, Build},
    firmware::{self, Board},
};

/// What every change is checked with.
pub const SHORT: &[&str] = &["--short"];

/// Builds the image and the model, and runs the one in the other; `words` go to the model.
pub fn run(words: &[&str], build: &Build) -> Outcome {
    firmware::build(Board::Nucleo)?;
    let mut board = Command::new(desktop::program("board", build)?);
    board.current_dir(command::root());
    command::run(board.arg(firmware::image("nucleo")).args(words))
}
