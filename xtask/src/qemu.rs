//! Running firmware in QEMU. What a program says comes through semihosting, and
//! its verdict is QEMU's exit code.

use std::{path::Path, process::Command, time::Duration};

use crate::{JobResult, boards, command, firmware, liveness::ProgramWatch, tools};

/// Processor time an emulated run may use: an image that hangs keeps QEMU busy. The longest run of ours takes about a
/// minute of a slow processor.
pub const MOST_WORK: Duration = Duration::from_secs(20 * 60);

/// Builds the firmware, runs the app and returns what it said. Counting, so that what it counts are instructions.
pub fn run() -> JobResult<Vec<String>> {
    firmware::build_named(boards::QEMU)?;
    start(&firmware::image("qemu"), &["-icount", "shift=0"], true)
}

/// Starts an image and returns the lines it said; fails if the program does.
pub fn start(image: &Path, options: &[&str], echo: bool) -> JobResult<Vec<String>> {
    command::tee(
        &mut command(image, "enable=on,target=native", options)?,
        ProgramWatch::new()?.working_at_most(MOST_WORK),
        echo,
    )
}

/// QEMU with an image, to be started.
pub fn command(image: &Path, semihosting: &str, options: &[&str]) -> JobResult<Command> {
    let mut command = Command::new(tools::qemu()?);
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
        .args(["-semihosting-config", semihosting])
        .args(options)
        .arg("-kernel")
        .arg(image);
    Ok(command)
}
