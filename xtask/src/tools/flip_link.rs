//! flip-link, the linker of the board's image: variables at the top of RAM, the stack below them, so that
//! a stack that overflows leaves RAM and faults (<https://github.com/knurling-rs/flip-link>).

use std::{
    ffi::OsString,
    fs,
    path::{Path, PathBuf},
};

use object::{Object, ObjectSegment, read::elf::ElfFile32};

use crate::{
    JobResult,
    command::{self, find},
    size::{RAM_START, symbol},
    tools::debian::tools,
};

/// The version that is installed where there is none.
const VERSION: &str = "0.1.12";

/// Finds flip-link, or installs it into the target folder; returns the program.
pub fn provide() -> JobResult<PathBuf> {
    if let Some(program) = find(&file("flip-link")) {
        return Ok(program);
    }
    let root = tools().join(format!("flip-link-{VERSION}"));
    let program = root.join("bin").join(file("flip-link"));
    if !program.is_file() {
        let mut cargo = command::cargo();
        cargo.args(["install", "--quiet", "--locked", "--version", VERSION]);
        cargo.arg("--root").arg(&root).arg("flip-link");
        command::run(&mut cargo).map_err(|error| {
            format!("{error}\nthe board's image is linked by flip-link; type: {ADVICE}")
        })?;
    }
    Ok(program)
}

const ADVICE: &str = "cargo install flip-link --locked";

/// The path for a build that links with flip-link. It starts `rust-lld`, and finds it where rustc has its
/// own; where rustc has none, `linker` is made to go by that name.
pub fn path(linker: Option<&Path>) -> JobResult<OsString> {
    let inherited = std::env::var_os("PATH").unwrap_or_default();
    let Some(linker) = linker else {
        return Ok(inherited);
    };
    let folder = tools().join("lld");
    name_it_rust_lld(linker, &folder)?;
    let folders = [folder]
        .into_iter()
        .chain(std::env::split_paths(&inherited));
    Ok(std::env::join_paths(folders)?)
}

fn name_it_rust_lld(linker: &Path, folder: &Path) -> JobResult {
    let link = folder.join(file("rust-lld"));
    if fs::canonicalize(&link).ok() != Some(fs::canonicalize(linker)?) {
        fs::create_dir_all(folder)?;
        if link.symlink_metadata().is_ok() {
            fs::remove_file(&link)?;
        }
        name_it(linker, &link)?;
    }
    Ok(())
}

/// An error if the image's stack does not begin where RAM does, with the variables above it.
pub fn check(elf: &[u8]) -> JobResult {
    let file: ElfFile32 = ElfFile32::parse(elf)?;
    let bottom = symbol(&file, "_stack_end").ok_or("the image names no end of its stack")?;
    let top = symbol(&file, "_stack_start").ok_or("the image names no start of its stack")?;
    let variables = file
        .segments()
        .filter(|segment| segment.address() >= RAM_START && segment.size() > 0)
        .map(|segment| segment.address());
    match variables.min() {
        _ if bottom != RAM_START => Err(format!(
            "the stack ends at {bottom:#x}, not where RAM begins: flip-link has not linked this image"
        )
        .into()),
        Some(first) if first < top => {
            Err(format!("variables begin at {first:#x}, within the stack up to {top:#x}").into())
        }
        _ => Ok(()),
    }
}

#[cfg(unix)]
fn name_it(linker: &Path, link: &Path) -> std::io::Result<()> {
    std::os::unix::fs::symlink(fs::canonicalize(linker)?, link)
}

#[cfg(not(unix))]
fn name_it(linker: &Path, link: &Path) -> std::io::Result<()> {
    fs::copy(linker, link).map(drop)
}

fn file(program: &str) -> String {
    format!("{program}{}", std::env::consts::EXE_SUFFIX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rust_with_its_own_linker_keeps_its_path() {
        assert_eq!(
            path(None).unwrap(),
            std::env::var_os("PATH").unwrap_or_default()
        );
    }

    #[test]
    #[cfg(unix)]
    fn any_linker_goes_by_the_name_flip_link_looks_for() {
        let folder = std::env::temp_dir().join(format!("rust-lld-{}", std::process::id()));
        let one = std::env::current_exe().unwrap();
        let other = folder.join("other");
        for linker in [&one, &one, &other] {
            fs::create_dir_all(&folder).unwrap();
            fs::write(&other, "").unwrap();
            name_it_rust_lld(linker, &folder).unwrap();
            let named = fs::canonicalize(folder.join(file("rust-lld"))).unwrap();
            assert_eq!(named, fs::canonicalize(linker).unwrap());
        }
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn what_is_no_image_is_an_error() {
        assert!(check(b"not an image").is_err());
    }
}
