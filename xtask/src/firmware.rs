//! Building the firmware.

use std::path::PathBuf;

use crate::{
    JobResult,
    boards::{self, BuiltBoard},
    command,
    tools::{
        self, flip_link,
        toolchain::{TARGET, Toolchain},
    },
};

/// What is built of the package, and how.
const FIRMWARE: [&str; 5] = ["--profile", "firmware", "--package", "firmware", "--bins"];

/// Builds all programs of a board and returns where they lie, relative to the root.
pub fn build(board: &BuiltBoard) -> JobResult<Vec<PathBuf>> {
    let toolchain = tools::toolchain()?;
    if board.flip_link {
        for program in &board.programs {
            link_flipped(&toolchain, board, program)?;
        }
    } else {
        let mut cargo = toolchain.cargo("build");
        command::run(cargo.args(FIRMWARE).args(["--features", &board.feature()]))?;
    }
    Ok(board.programs.iter().map(|name| image(name)).collect())
}

/// Builds all programs of the board called `name`, as [`build`] does.
pub fn build_named(name: &str) -> JobResult<Vec<PathBuf>> {
    build(&boards::named(name)?)
}

/// Builds a board's program with flip-link as its linker. Only that one crate is told: to cargo, another
/// linker for the target is a reason to build everything anew, `core` too.
fn link_flipped(toolchain: &Toolchain, board: &BuiltBoard, program: &str) -> JobResult {
    let flip_link = flip_link::provide()?;
    let mut cargo = toolchain.cargo("rustc");
    cargo
        .env("PATH", flip_link::path(toolchain.linker())?)
        .args(["--profile", "firmware", "--package", "firmware"])
        .args(["--bin", program, "--features", &board.feature()])
        .args(["--", "-C"])
        .arg(format!("linker={}", flip_link.display()));
    command::run(&mut cargo)?;
    flip_link::check(&std::fs::read(command::root().join(image(program)))?)
}

/// Where a program lies once it is built, relative to the root.
pub fn image(program: &str) -> PathBuf {
    ["target/thumb", TARGET, "firmware", program]
        .iter()
        .collect()
}

/// Runs clippy over a board's programs, warnings being errors; says so where
/// there is no clippy for the target.
pub fn lint(board: &BuiltBoard) -> JobResult {
    let toolchain = tools::toolchain()?;
    if !toolchain.has_clippy() {
        println!("skipped: no clippy for {TARGET} here");
        return Ok(());
    }
    let mut cargo = toolchain.cargo("clippy");
    cargo.args(FIRMWARE).args(["--features", &board.feature()]);
    command::run(cargo.args(["--", "-D", "warnings"]))
}

/// Builds the model alone for the microcontroller: it must need nothing else.
pub fn build_shared() -> JobResult {
    command::run(tools::toolchain()?.cargo("build").args([
        "--profile",
        "firmware",
        "--package",
        "shared",
    ]))
}

/// Links the control task's work alone, which fails if a panic can be reached in it.
pub fn check_panic_free() -> JobResult {
    let mut cargo = tools::toolchain()?.cargo("build");
    cargo.args(FIRMWARE);
    command::run(cargo.args(["--features", "check-panic-free"]))
}
