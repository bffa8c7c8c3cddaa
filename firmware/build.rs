//! Hands the linker what the chosen board needs: its `memory.x`, found in its folder of `src/hardware`.

use std::{env, error::Error, fs, path::PathBuf};

/// The link check has no board; it is laid out as this one.
const UNBOARDED: &str = "qemu";

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=../memory.x");

    // On the host there is only the library, and nothing to lay out.
    if env::var("CARGO_CFG_TARGET_OS")? != "none" {
        return Ok(());
    }
    let mut boards = chosen()?;
    if has("CHECK_PANIC_FREE") {
        boards.push(UNBOARDED.into());
    }
    let board = match &boards[..] {
        [] => return Ok(()),
        [board] => board,
        several => {
            return Err(
                format!("one board per build: choose one of {}", several.join(", ")).into(),
            );
        }
    };

    let out = PathBuf::from(env::var("OUT_DIR")?);
    let memory = format!("src/hardware/{board}/memory.x");
    println!("cargo:rerun-if-changed={memory}");
    fs::copy(memory, out.join("board.x"))?;
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg-bins=--nmagic");
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    // Boards that a rig hangs on log through defmt.
    if has("_RIG") {
        println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
    }
    Ok(())
}

/// Whether a feature is asked for.
fn has(feature: &str) -> bool {
    env::var_os(format!("CARGO_FEATURE_{feature}")).is_some()
}

/// The folders of boards whose feature is asked for.
fn chosen() -> Result<Vec<String>, Box<dyn Error>> {
    let mut boards = Vec::new();
    for entry in fs::read_dir("src/hardware")? {
        let folder = entry?.path();
        let name = folder.file_name().unwrap_or_default().to_string_lossy();
        let feature = format!("BOARD_{}", name.to_uppercase().replace('-', "_"));
        if folder.join("memory.x").is_file() && has(&feature) {
            boards.push(name.into_owned());
        }
    }
    Ok(boards)
}
