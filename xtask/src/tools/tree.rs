//! Packages unpacked into a folder of their own: links that stay within, and scripts that start their programs with
//! their libraries.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use crate::{Outcome, command::output};

/// Holds a script for each wanted program; no package has a folder of that name.
pub const STARTERS: &str = "starters";

/// A link to `/usr/…` would lead out of the tree: it is made to lead to the same file within.
pub fn make_links_relative(tree: &Path, folder: &Path) -> Outcome {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let kind = path.symlink_metadata()?.file_type();
        if kind.is_dir() {
            make_links_relative(tree, &path)?;
        } else if kind.is_symlink() {
            let target = fs::read_link(&path)?;
            let Ok(inside) = target.strip_prefix("/") else {
                continue;
            };
            if tree.join(inside).symlink_metadata().is_ok() {
                let depth = folder.strip_prefix(tree)?.components().count();
                let up: PathBuf = std::iter::repeat_n("..", depth).collect();
                fs::remove_file(&path)?;
                link(&up.join(inside), &path)?;
            }
        }
    }
    Ok(())
}

#[cfg(unix)]
fn link(target: &Path, path: &Path) -> std::io::Result<()> {
    std::os::unix::fs::symlink(target, path)
}

#[cfg(not(unix))]
fn link(_: &Path, _: &Path) -> std::io::Result<()> {
    Err(std::io::ErrorKind::Unsupported.into())
}

/// Folders within the folder of the libraries in which a library looks for another, by a path that is not the tree's.
const INNER: &[&str] = &["pulseaudio"];

/// The folders of the tree that hold its libraries, relative to it: `usr/lib/x86_64-linux-gnu` and the like.
pub fn library_folders(tree: &Path) -> Outcome<Vec<String>> {
    let mut folders = Vec::new();
    for above in ["lib", "usr/lib"] {
        for entry in fs::read_dir(tree.join(above)).into_iter().flatten() {
            let name = entry?.file_name().to_string_lossy().into_owned();
            if name.contains("-linux-") {
                let folder = format!("{above}/{name}");
                let inner = INNER.iter().map(|inner| format!("{folder}/{inner}"));
                let there: Vec<_> = inner.filter(|inner| tree.join(inner).is_dir()).collect();
                folders.push(folder);
                folders.extend(there);
            }
        }
    }
    Ok(folders)
}

/// Letters as fontconfig finds them: within the tree, where it has some.
const FONTS: &str = "[ ! -d \"$tree/etc/fonts\" ] || export FONTCONFIG_SYSROOT=\"$tree\"\n";

/// A script that starts a program with the tree's libraries and letters, wherever the tree has been moved. The program is
/// one of `usr/bin`, or a path below `usr`.
fn wrapper(program: &str, libraries: &[String]) -> String {
    let path: Vec<_> = libraries
        .iter()
        .map(|folder| format!("$tree/{folder}"))
        .collect();
    let place = match program.contains('/') {
        true => format!("usr/{program}"),
        false => format!("usr/bin/{program}"),
    };
    format!(
        "#!/bin/sh\n\
         # Starts {program} from the packages unpacked here, with their libraries.\n\
         tree=$(dirname \"$(dirname \"$(readlink -f \"$0\")\")\")\n\
         export LD_LIBRARY_PATH=\"{}${{LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}}\"\n\
         {FONTS}\
         exec \"$tree/{place}\" \"$@\"\n",
        path.join(":")
    )
}

/// The name under which a program is started.
pub fn started(program: &str) -> &str {
    program.rsplit('/').next().unwrap_or(program)
}

/// Writes that script.
pub fn wrap(tree: &Path, program: &str, libraries: &[String]) -> Outcome {
    let path = tree.join(STARTERS).join(started(program));
    fs::write(&path, wrapper(program, libraries))?;
    output(Command::new("chmod").arg("755").arg(&path)).map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn links_stay_within_the_tree_and_a_wrapper_uses_its_libraries() {
        let tree = tempfile::tempdir().unwrap();
        let path = |name: &str| tree.path().join(name);
        fs::create_dir_all(path("usr/lib/x86_64-linux-gnu")).unwrap();
        fs::create_dir_all(path("usr/bin")).unwrap();
        fs::create_dir_all(path(STARTERS)).unwrap();
        fs::write(path("usr/lib/x86_64-linux-gnu/one"), "inside").unwrap();
        link(
            Path::new("/usr/lib/x86_64-linux-gnu/one"),
            &path("usr/lib/two"),
        )
        .unwrap();
        link(Path::new("/nowhere/else"), &path("usr/lib/three")).unwrap();
        make_links_relative(tree.path(), tree.path()).unwrap();
        assert_eq!(fs::read_to_string(path("usr/lib/two")).unwrap(), "inside");
        assert_eq!(
            fs::read_link(path("usr/lib/three")).unwrap(),
            Path::new("/nowhere/else")
        );

        let libraries = library_folders(tree.path()).unwrap();
        assert_eq!(libraries, ["usr/lib/x86_64-linux-gnu"]);
        fs::write(
            path("usr/bin/say"),
            "#!/bin/sh\necho \"$LD_LIBRARY_PATH $1\"\n",
        )
        .unwrap();
        output(Command::new("chmod").arg("755").arg(path("usr/bin/say"))).unwrap();
        wrap(tree.path(), "say", &libraries).unwrap();
        // A link to the wrapper finds the tree, too.
        link(&path(STARTERS).join("say"), &path("elsewhere")).unwrap();
        let said = output(
            Command::new(path("elsewhere"))
                .env_remove("LD_LIBRARY_PATH")
                .arg("on"),
        );
        let tree = fs::canonicalize(tree.path()).unwrap();
        let expected = format!("{}/usr/lib/x86_64-linux-gnu on\n", tree.display());
        assert_eq!(said.unwrap(), expected);
    }
}
