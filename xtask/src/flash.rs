//! Putting the firmware on a board.

use std::process::Command;

use crate::{
    JobResult,
    boards::BuiltBoard,
    command::{self, find},
    firmware,
};

/// The traps that probe-rs otherwise sets stay in the part until power-off, over every reset: a processor fault would halt
/// it with the drive's enable as it was, and a reset would halt it before the program.
const NO_TRAPS: [&str; 2] = ["--no-catch-reset", "--no-catch-hardfault"];

/// What to install where probe-rs is missing.
fn advice() -> String {
    "no probe-rs here, which talks to the board's debugger; type: cargo install --locked probe-rs-tools\n\
     (Debian first: sudo apt-get install pkg-config libudev-dev; other ways: https://probe.rs)"
        .into()
}

/// Builds the board's program, flashes it, and shows its log until Ctrl-C.
pub fn run(board: &BuiltBoard) -> JobResult {
    let (Some(chip), Some(program)) = (&board.chip, board.programs.first()) else {
        return Err(format!("{} has no part to flash (board.toml: chip)", board.title).into());
    };
    let probe = find("probe-rs").ok_or_else(advice)?;
    firmware::build(board)?;
    let mut flash = Command::new(probe);
    flash
        .current_dir(command::root())
        .args(["run", "--chip", chip])
        .args(NO_TRAPS)
        .arg(firmware::image(program));
    command::run_attended(&mut flash)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_runner_and_this_name_the_same_chip_and_set_no_trap() {
        let config = command::root().join(".cargo/config.toml");
        let config = std::fs::read_to_string(config).unwrap();
        let traps = NO_TRAPS.join(" ");
        let chip = crate::boards::named("nucleo").unwrap().chip.unwrap();
        assert!(config.contains(&format!(
            "runner = \"probe-rs run --chip {chip} {traps}\"\n"
        )));
        assert!(advice().contains("cargo install --locked probe-rs-tools\n"));
    }
}
