//! Running firmware in QEMU. What a program says comes through semihosting, and
//! its verdict is QEMU's exit code.

use std::{path::Path, process::Command, time::Duration};

use crate::{
    Outcome,
    command::{self, find, run_tee},
    debian,
    firmware::{self, Board},
};

/// No run of ours takes this long; one that does hangs.
const LIMIT: Duration = Duration::from_secs(180);

/// Builds the firmware and runs the app.
pub fn run() -> Outcome {
    firmware::build(Board::Qemu)?;
    start(&firmware::image("qemu"), &[], true).map(|_lines| ())
}

/// Starts an image and returns the lines it said; fails if the program does.
pub fn start(image: &Path, options: &[&str], echo: bool) -> Outcome<Vec<String>> {
    let qemu = find("qemu-system-arm").ok_or_else(debian::qemu_advice)?;
    let mut command = Command::new(qemu);
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
        .args(["-semihosting-config", "enable=on,target=native"])
        .args(options)
        .arg("-kernel")
        .arg(image);
    run_tee(&mut command, LIMIT, echo)
}
