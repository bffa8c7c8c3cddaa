//! Building the firmware.

use std::path::PathBuf;

use crate::{
    Outcome, command,
    tools::{
        self, flip_link,
        toolchain::{TARGET, Toolchain},
    },
};

/// A board the firmware is built for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Board {
    /// ST NUCLEO-F446RE.
    Nucleo,
    /// Arm MPS2 AN386, played by QEMU.
    Qemu,
}

impl Board {
    /// Every board.
    pub const ALL: [Self; 2] = [Self::Nucleo, Self::Qemu];

    /// The board's name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nucleo => "nucleo",
            Self::Qemu => "qemu",
        }
    }

    /// The board of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|board| board.name() == name)
    }

    fn feature(self) -> &'static str {
        match self {
            Self::Nucleo => "board-nucleo",
            Self::Qemu => "board-qemu",
        }
    }

    fn programs(self) -> &'static [&'static str] {
        match self {
            Self::Nucleo => &["nucleo"],
            Self::Qemu => &["qemu", "pil", "ticks", "forecast"],
        }
    }
}

/// What is built of the package, and how.
const FIRMWARE: [&str; 5] = ["--profile", "firmware", "--package", "firmware", "--bins"];

/// Builds all programs of a board and returns where they lie, relative to the root.
pub fn build(board: Board) -> Outcome<Vec<PathBuf>> {
    match board {
        Board::Nucleo => link_flipped(&tools::toolchain()?)?,
        Board::Qemu => {
            let mut cargo = tools::toolchain()?.cargo("build");
            cargo.args(FIRMWARE).args(["--features", board.feature()]);
            command::run(&mut cargo)?;
        }
    }
    Ok(board
        .programs()
        .iter()
        .map(|program| image(program))
        .collect())
}

/// Builds the board's program with flip-link as its linker. Only that one crate is told: to cargo, another
/// linker for the target is a reason to build everything anew, `core` too.
fn link_flipped(toolchain: &Toolchain) -> Outcome {
    let flip_link = flip_link::provide()?;
    let mut cargo = toolchain.cargo("rustc");
    cargo
        .env("PATH", flip_link::path(toolchain.linker())?)
        .args(["--profile", "firmware", "--package", "firmware"])
        .args(["--bin", "nucleo", "--features", Board::Nucleo.feature()])
        .args(["--", "-C"])
        .arg(format!("linker={}", flip_link.display()));
    command::run(&mut cargo)?;
    flip_link::check(&std::fs::read(command::root().join(image("nucleo")))?)
}

/// Where a program lies once it is built, relative to the root.
pub fn image(program: &str) -> PathBuf {
    ["target/thumb", TARGET, "firmware", program]
        .iter()
        .collect()
}

/// Runs clippy over a board's programs, warnings being errors; says so where
/// there is no clippy for the target.
pub fn lint(board: Board) -> Outcome {
    let toolchain = tools::toolchain()?;
    if !toolchain.has_clippy() {
        println!("skipped: no clippy for {TARGET} here");
        return Ok(());
    }
    let mut cargo = toolchain.cargo("clippy");
    cargo.args(FIRMWARE).args(["--features", board.feature()]);
    command::run(cargo.args(["--", "-D", "warnings"]))
}

/// Builds the model alone for the microcontroller: it must need nothing else.
pub fn build_shared() -> Outcome {
    command::run(tools::toolchain()?.cargo("build").args([
        "--profile",
        "firmware",
        "--package",
        "shared",
    ]))
}

/// Links the control task's work alone, which fails if a panic can be reached in it.
pub fn check_panic_free() -> Outcome {
    let mut cargo = tools::toolchain()?.cargo("build");
    cargo.args(FIRMWARE);
    command::run(cargo.args(["--features", "check-panic-free"]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boards_are_found_by_their_own_name() {
        for board in Board::ALL {
            assert_eq!(Board::named(board.name()), Some(board));
        }
        assert_eq!(Board::named("uno"), None);
    }

    #[test]
    fn features_and_programs_are_those_of_the_package() {
        let manifest =
            std::fs::read_to_string(command::root().join("firmware/Cargo.toml")).unwrap();
        for board in Board::ALL {
            assert!(manifest.contains(&format!("\n{} = [", board.feature())));
            for program in board.programs() {
                let name = format!("\nname = \"{program}\"\n");
                let feature = format!("\nrequired-features = [\"{}\"]\n", board.feature());
                let mut bins = manifest.split("[[bin]]");
                assert!(bins.any(|bin| bin.contains(&name) && bin.contains(&feature)));
            }
        }
    }
}
