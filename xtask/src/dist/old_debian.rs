//! The program tried in a bare root of an older Debian: nothing is in there but its C library.

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
    packages: &["libc6", "libgcc-s1"],
};

/// Runs `program` in the bare root with these words, and returns what it printed. `Ok(Err)`: this machine cannot try it, and
/// why.
pub fn run(program: &Path, words: &[&str]) -> Outcome<Result<String, String>> {
    let root = match root() {
        Ok(root) => root,
        Err(why) => return Ok(Err(format!("not tried in Debian {}: {why}", DEBIAN.number))),
    };
    let Some(mut enter) = enter(&root) else {
        return Ok(Err(format!(
            "not tried in Debian {}: only root may change the root here",
            DEBIAN.number
        )));
    };
    let inside = root.join("host-sim");
    archive::write(&inside, &fs::read(program)?)?;
    make_executable(&inside)?;
    let said = command::output(enter.arg("/host-sim").args(words).current_dir("/"));
    let said = said.map_err(|error| format!("in Debian {}: {error}", DEBIAN.number))?;
    Ok(Ok(said))
}

/// Says what was tried.
pub fn name() -> String {
    format!("a bare Debian {} ({})", DEBIAN.number, DEBIAN.name)
}

fn root() -> Result<PathBuf, String> {
    if !debian::here() {
        return Err("its packages are only got on a Debian".into());
    }
    DEBIAN.provide().map_err(|error| error.to_string())
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
