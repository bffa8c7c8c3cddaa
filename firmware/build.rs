//! Hands the linker what the chosen board needs.

use std::{env, error::Error, fs, path::PathBuf};

/// Feature of what can be built, and the board whose memory it is laid out for (its folder); one at a time.
const LAYOUTS: [(&str, &str); 3] = [
    ("BOARD_NUCLEO", "nucleo"),
    ("BOARD_QEMU", "qemu"),
    ("CHECK_PANIC_FREE", "qemu"),
];

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=../memory.x");

    // On the host there is only the library, and nothing to lay out.
    if env::var("CARGO_CFG_TARGET_OS")? != "none" {
        return Ok(());
    }
    let chosen =
        |(feature, _): &(&str, &str)| env::var_os(format!("CARGO_FEATURE_{feature}")).is_some();
    let mut layouts = LAYOUTS.into_iter().filter(chosen);
    let Some((feature, board)) = layouts.next() else {
        return Ok(());
    };
    if layouts.next().is_some() {
        return Err("one board per build: choose one of board-nucleo and board-qemu".into());
    }

    let out = PathBuf::from(env::var("OUT_DIR")?);
    let memory = format!("src/hardware/{board}/memory.x");
    println!("cargo:rerun-if-changed={memory}");
    fs::copy(memory, out.join("board.x"))?;
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg-bins=--nmagic");
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    if feature == "BOARD_NUCLEO" {
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    }
    Ok(())
}
