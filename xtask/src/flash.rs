//! Putting the firmware on a board.

use std::process::Command;

use crate::{
    Outcome,
    command::{self, find},
    firmware::{self, Board},
};

/// The part, as probe-rs calls it.
const CHIP: &str = "STM32F446RETx";

/// What to install where probe-rs is missing.
fn advice() -> String {
    "no probe-rs here, which talks to the board's debugger; type: cargo install --locked probe-rs-tools\n\
     (Debian first: sudo apt-get install pkg-config libudev-dev; other ways: https://probe.rs)"
        .into()
}

/// Builds the board's program, flashes it, and shows its log until Ctrl-C.
pub fn run() -> Outcome {
    let probe = find("probe-rs").ok_or_else(advice)?;
    firmware::build(Board::Nucleo)?;
    let mut flash = Command::new(probe);
    flash
        .current_dir(command::root())
        .args(["run", "--chip", CHIP])
        .arg(firmware::image("nucleo"));
    command::run_attended(&mut flash)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_runner_and_this_name_the_same_chip() {
        let config = command::root().join(".cargo/config.toml");
        let config = std::fs::read_to_string(config).unwrap();
        assert!(config.contains(&format!("probe-rs run --chip {CHIP}")));
        assert!(advice().contains("cargo install --locked probe-rs-tools\n"));
    }
}
