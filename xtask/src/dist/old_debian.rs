//! The program and the wheel tried in a bare root of an older Debian: nothing is in there but its C library, and for the wheel
//! its Python.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use super::archive;
use crate::{
    Outcome,
    command::{self, find},
    tools::{debian, old::Old},
};

/// The root that is tried. Its C library is 2.31.
const DEBIAN: Old = Old {
    number: "11",
    name: "bullseye",
    folder: "debian-11",
    packages: &["libc6", "libgcc-s1"],
};

/// The same with its Python, 3.9, the oldest that the wheel is for.
const WITH_PYTHON: Old = Old {
    folder: "debian-11-python",
    packages: &[
        "libc6",
        "libgcc-s1",
        "libbz2-1.0",
        "libcrypt1",
        "libexpat1",
        "libffi7",
        "liblzma5",
        "libpython3.9-minimal",
        "libpython3.9-stdlib",
        "libssl1.1",
        "libstdc++6",
        "python3.9-minimal",
        "zlib1g",
    ],
    ..DEBIAN
};

/// Runs `program` in the bare root with these words, and returns what it printed. `Ok(Err)`: this machine cannot try it, and
/// why.
pub fn run(program: &Path, words: &[&str]) -> Outcome<Result<String, String>> {
    let (root, mut enter) = match entered(&DEBIAN) {
        Ok(entered) => entered,
        Err(why) => return Ok(Err(format!("not tried in Debian {}: {why}", DEBIAN.number))),
    };
    let inside = root.join("host-sim");
    archive::write(&inside, &fs::read(program)?)?;
    make_executable(&inside)?;
    let said = command::output(enter.arg("/host-sim").args(words).current_dir("/"));
    let said = said.map_err(|error| format!("in Debian {}: {error}", DEBIAN.number))?;
    Ok(Ok(said))
}

/// Runs a line of Python in the root with Python, into which `pip` puts the wheel with what it needs. As [`run`].
pub fn run_python(pip: Command, wheel: &Path, line: &str) -> Outcome<Result<String, String>> {
    let (root, mut enter) = match entered(&WITH_PYTHON) {
        Ok(entered) => entered,
        Err(why) => return Ok(Err(format!("not tried in Debian {}: {why}", DEBIAN.number))),
    };
    let place = root.join("wheel");
    if place.exists() {
        fs::remove_dir_all(&place)?;
    }
    let mut install = pip;
    install.args(["--only-binary", ":all:", "--python-version", "3.9"]);
    for platform in ["manylinux_2_17", "manylinux2014"] {
        let arch = std::env::consts::ARCH;
        install.args(["--platform", &format!("{platform}_{arch}")]);
    }
    command::run(install.arg("--target").arg(&place).arg(wheel))?;
    enter.env("PYTHONPATH", "/wheel").current_dir("/");
    let said = command::output(enter.args(["/usr/bin/python3.9", "-c", line]));
    let said = said.map_err(|error| format!("in Debian {}: {error}", DEBIAN.number))?;
    Ok(Ok(said))
}

/// Says what was tried.
pub fn name() -> String {
    format!("a bare Debian {} ({})", DEBIAN.number, DEBIAN.name)
}

/// A root, and the command that changes into it; or why there is none.
fn entered(old: &Old) -> Result<(PathBuf, Command), String> {
    if !debian::here() {
        return Err("its packages are only got on a Debian".into());
    }
    let root = old.provide().map_err(|error| error.to_string())?;
    let enter = enter(&root).ok_or("only root may change the root here")?;
    Ok((root, enter))
}

/// The command that changes the root, if one works here.
fn enter(root: &Path) -> Option<Command> {
    let ways: [&[&str]; 2] = [&["chroot"], &["unshare", "--map-root-user", "chroot"]];
    ways.into_iter().find_map(|way| {
        let make = || {
            let mut command = Command::new(find(way[0])?);
            command.args(&way[1..]).arg(root);
            Some(command)
        };
        // The loader itself runs in any root with a C library.
        let loader = fs::read_dir(root.join("lib64")).ok()?.flatten().next()?;
        let loader = Path::new("/lib64").join(loader.file_name());
        let mut tried = make()?;
        tried.arg(&loader).arg("--list").arg(&loader);
        let works = command::ask(tried.current_dir("/"));
        works.and_then(|_| make())
    })
}

#[cfg(unix)]
fn make_executable(file: &Path) -> Outcome {
    use std::os::unix::fs::PermissionsExt;
    Ok(fs::set_permissions(
        file,
        fs::Permissions::from_mode(0o755),
    )?)
}

#[cfg(not(unix))]
fn make_executable(_: &Path) -> Outcome {
    Ok(())
}
