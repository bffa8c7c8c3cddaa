//! The programs that checks and builds need beside the Rust in use. Each is taken from the path where it is there; on
//! Debian it is unpacked below `target/tools` where it is not; elsewhere the error is the line to type.

pub mod debian;
pub mod flip_link;
pub mod toolchain;

use std::{
    path::{Path, PathBuf},
    process::Command,
};

use crate::{
    JobResult,
    command::{self, find},
};
use debian::Bundle;
use toolchain::{Missing, TARGET, Toolchain, WASM};

/// QEMU's system emulator for Arm.
const QEMU: &str = "qemu-system-arm";

/// The emulator: the one in the path, or Debian's, unpacked.
pub fn qemu() -> JobResult<PathBuf> {
    match find(QEMU) {
        Some(program) => Ok(program),
        None => provide(&debian::QEMU, qemu_advice).map(|()| debian::QEMU.starters().join(QEMU)),
    }
}

/// A way to build for the microcontroller: the Rust in use, or Debian's, installed or unpacked.
pub fn toolchain() -> JobResult<Toolchain> {
    let choose = || toolchain::choose(&toolchain::look(TARGET));
    // Twice something may be missing: the Rust, then its linker.
    for _ in 0..2 {
        match choose() {
            Ok(toolchain) => return Ok(toolchain),
            Err(Missing::Rust) => provide(&debian::RUST, || advice(&Missing::Rust))?,
            Err(Missing::Linker) => provide(&debian::LLD, || advice(&Missing::Linker))?,
        }
    }
    choose().map_err(|missing| advice(&missing).into())
}

/// A way to build the page's module: the Rust in use, or Debian's, installed or unpacked.
pub fn wasm_toolchain() -> JobResult<Toolchain> {
    let choose = || toolchain::choose_for_wasm(&toolchain::look(WASM));
    let advice =
        |_: &Missing| format!("no Rust here builds for {WASM}; type: rustup target add {WASM}");
    match choose() {
        Err(Missing::Rust) => {
            provide(&debian::RUST, || advice(&Missing::Rust))?;
            choose().map_err(|missing| advice(&missing).into())
        }
        chosen => chosen.map_err(|missing| advice(&missing).into()),
    }
}

/// The browser that the page is tested in: the one in the path, or Debian's, unpacked.
pub fn chromium() -> JobResult<PathBuf> {
    let names = ["chromium", "chromium-browser", "google-chrome", CHROMIUM];
    if let Some(program) = names.iter().find_map(|name| find(name)) {
        return Ok(program);
    }
    let advice = || {
        format!(
            "no Chromium here; install it (Debian: {})",
            debian::CHROMIUM.install_line()
        )
    };
    provide(&debian::CHROMIUM, advice).map(|()| debian::CHROMIUM.starters().join(CHROMIUM))
}

/// Debian's browser without a window.
const CHROMIUM: &str = "chromium-headless-shell";

/// Unpacks a bundle on Debian. Where there is no Debian, or it fails, the error says what to type.
fn provide(bundle: &Bundle, advice: impl Fn() -> String) -> JobResult {
    if !debian::here() {
        return Err(advice().into());
    }
    bundle
        .provide()
        .map_err(|error| format!("{error}\n{}", advice()).into())
}

/// Says what to type where there is no Debian.
fn advice(missing: &Missing) -> String {
    match missing {
        Missing::Rust => format!(
            "no Rust here builds for {TARGET}; type: rustup target add {TARGET}\n\
             or, on Debian: {}",
            debian::RUST.install_line()
        ),
        Missing::Linker => format!(
            "no linker for the firmware; install lld (Debian: {})",
            debian::LLD.install_line()
        ),
    }
}

fn qemu_advice() -> String {
    format!(
        "no {QEMU} here; install QEMU for Arm (Debian: {})",
        debian::QEMU.install_line()
    )
}

/// The first line of what a program answers to `--version`.
fn version(command: &mut Command) -> String {
    let answer = command::ask(command.arg("--version")).unwrap_or_default();
    answer.lines().next().unwrap_or("unknown version").into()
}

/// Sees to it that every tool is there, and prints a line for each: what it is for, its version, where it is.
pub fn list() -> JobResult {
    let line = |purpose: &str, version: &str, place: &str| {
        println!("{purpose:<28} {version}; {place}");
    };
    for (tool, purpose) in [("fmt", "format"), ("clippy", "lints")] {
        let version =
            command::ask(command::cargo().args([tool, "--version"])).ok_or_else(|| {
                format!("no cargo {tool} here; type: rustup component add rustfmt clippy")
            })?;
        line(purpose, &version, "in the path");
    }
    let toolchain = toolchain()?;
    line(
        "firmware: Rust",
        &version(&mut toolchain.rustc()),
        &toolchain.describe(),
    );
    match toolchain.linker() {
        Some(linker) => line(
            "firmware: linker",
            // `rust-lld` is told which linker to be; `ld.lld` knows, and takes the same words.
            &version(Command::new(linker).args(["-flavor", "gnu"])),
            &linker.display().to_string(),
        ),
        None => line("firmware: linker", "rust-lld", "the Rust in use has it"),
    }
    let flip_link = flip_link::provide()?;
    line(
        "linker of the board's image",
        // It cannot be asked which version it is, for it is a linker.
        "flip-link",
        &flip_link.display().to_string(),
    );
    let found = |purpose: &str, program: &Path| {
        let place = program.display().to_string();
        line(purpose, &version(&mut Command::new(program)), &place);
    };
    found("runs the images for QEMU", &qemu()?);
    let flashes = "puts an image on the board";
    match find("probe-rs") {
        Some(probe) => found(flashes, &probe),
        None => line(flashes, "no probe-rs", "only `cargo xtask flash` needs it"),
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn advice_can_be_typed() {
        assert!(advice(&Missing::Rust).contains("rustup target add thumbv7em-none-eabihf\n"));
        assert!(advice(&Missing::Rust).contains("rustc-web cargo-web rust-web-src"));
        assert!(advice(&Missing::Linker).contains("apt-get install --no-install-recommends lld"));
        assert!(qemu_advice().contains("apt-get install --no-install-recommends qemu-system-arm"));
    }
}
