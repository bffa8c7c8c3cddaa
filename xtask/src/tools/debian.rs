//! Debian's packages without installing them: apt resolves and downloads in a folder of its own, dpkg unpacks them
//! below `target/tools`. Neither root nor the system's package lists are needed, and nothing outside that folder
//! changes.

use std::{
    fs::{self, File, TryLockError},
    io::ErrorKind,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use super::toolchain::version_of;
use crate::{
    Outcome,
    command::{self, find},
};

/// Packages that are unpacked together, with all their libraries.
#[derive(Debug)]
pub struct Bundle {
    /// Its folder below `target/tools`.
    pub name: &'static str,
    /// The packages asked for.
    pub packages: &'static [&'static str],
    /// The programs wanted of them, all in `/usr/bin`.
    pub programs: &'static [&'static str],
    /// The oldest version of its first program that will do; empty: any.
    pub oldest: &'static str,
}

/// The emulator.
pub const QEMU: Bundle = Bundle {
    name: "qemu",
    packages: &["qemu-system-arm"],
    programs: &["qemu-system-arm"],
    oldest: "",
};

/// Debian's Rust with the sources of `core`.
pub const RUST: Bundle = Bundle {
    name: "rust",
    packages: &["rustc-web", "cargo-web", "rust-web-src", "rust-web-clippy"],
    programs: &["rustc", "cargo", "cargo-clippy", "clippy-driver"],
    oldest: env!("CARGO_PKG_RUST_VERSION"),
};

/// A linker for the microcontroller.
pub const LLD: Bundle = Bundle {
    name: "lld",
    packages: &["lld"],
    programs: &["ld.lld"],
    oldest: "",
};

/// Dependencies taken from the system: the C library (two of them in one process do not work), the C compiler, which
/// Rust needs on every machine anyway, and what serves installation only. Beginnings of package names.
const FROM_SYSTEM: &[&str] = &[
    "libc6",
    "libc-",
    "libcrypt",
    "libgcc",
    "linux-libc-dev",
    "gcc",
    "cpp",
    "binutils",
    "libbinutils",
    "libctf",
    "libgprofng",
    "libasan",
    "liblsan",
    "libtsan",
    "libubsan",
    "libcc1",
    "libisl",
    "libmpc",
    "libmpfr",
    "debconf",
    "adduser",
    "passwd",
    "libpam-modules",
    "iso-codes",
];

/// Every tool's folder.
pub fn tools() -> PathBuf {
    command::root().join("target/tools")
}

/// Whether this is a Debian, or one of its descendants.
pub fn here() -> bool {
    find("apt-get").is_some() && find("dpkg-deb").is_some()
}

/// An unpacked package and its version, as apt writes it.
type Package = String;

impl Bundle {
    /// Where its programs are started from once it is unpacked.
    pub fn starters(&self) -> PathBuf {
        tools().join(self.name).join(STARTERS)
    }

    /// The line that installs it into the system instead.
    pub fn install_line(&self) -> String {
        format!(
            "sudo apt-get install --no-install-recommends {}",
            self.packages.join(" ")
        )
    }

    /// Whether it is unpacked, whole, and what this version of xtask asks for.
    pub fn is_there(&self) -> bool {
        fs::read_to_string(tools().join(self.name).join(STAMP))
            .is_ok_and(|stamp| stamp.lines().next() == Some(&self.wanted()))
    }

    /// The stamp's first line.
    fn wanted(&self) -> String {
        format!("wanted: {}", self.packages.join(" "))
    }

    /// Unpacks it where that has not been done; `Err` says in one line why not, and what to type.
    pub fn provide(&self) -> Outcome {
        if self.is_there() {
            return Ok(());
        }
        let _lock = lock()?;
        // Another run may have unpacked it in the meantime.
        if self.is_there() {
            return Ok(());
        }
        println!(
            "unpacking Debian's {} into {} (nothing is installed)",
            self.packages.join(", "),
            tools().join(self.name).display()
        );
        let part = tools().join(format!("{}.part", self.name));
        self.unpack(&part).map_err(|error| {
            // Its remains are of no use, and the next run begins by removing them anyway.
            let _ = remove(&part);
            format!(
                "cannot get Debian's {}: {error}; check the network and apt's sources, or type: {}",
                self.packages.join(", "),
                self.install_line()
            )
            .into()
        })
    }

    /// Unpacks into the folder `part` and renames it when it is whole.
    fn unpack(&self, part: &Path) -> Outcome {
        remove(part)?;
        let tree = part.join(self.name);
        fs::create_dir_all(&tree)?;
        let apt = Apt::new(&part.join("apt"))?;
        apt.update()?;
        let packages = apt.resolve(self.packages)?;
        apt.download(&packages, &tree)?;
        let starters = tree.join(STARTERS);
        fs::create_dir(&starters)?;
        let libraries = library_folders(&tree)?;
        for program in self.programs {
            wrap(&tree, program, &libraries)?;
            let version = version(&starters.join(program))?;
            if *program == self.programs[0] && version_of(&version) < version_of(self.oldest) {
                return Err(format!("{version} is older than {}", self.oldest).into());
            }
        }
        let stamp = format!("{}\n{}\n", self.wanted(), packages.join("\n"));
        fs::write(tree.join(STAMP), stamp)?;
        let whole = tools().join(self.name);
        remove(&whole)?;
        fs::rename(&tree, &whole)?;
        remove(part)
    }
}

/// Names the packages of an unpacked bundle and their versions.
const STAMP: &str = "packages";

/// Holds a script for each wanted program; no package has a folder of that name.
const STARTERS: &str = "starters";

fn remove(folder: &Path) -> Outcome {
    match fs::remove_dir_all(folder) {
        Err(e) if e.kind() != ErrorKind::NotFound => {
            Err(format!("cannot remove {}: {e}", folder.display()).into())
        }
        _ => Ok(()),
    }
}

/// Held by whoever unpacks; the system releases it when that process ends, however it ends.
fn lock() -> Outcome<File> {
    fs::create_dir_all(tools())?;
    let file = File::create(tools().join("lock"))?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => {
            println!("waiting for another run that unpacks tools");
            file.lock()?;
        }
        other => other?,
    }
    Ok(file)
}

/// apt with package lists, cache and an empty list of installed packages of its own, but the system's sources.
struct Apt {
    config: PathBuf,
    debs: PathBuf,
}

impl Apt {
    fn new(folder: &Path) -> Outcome<Self> {
        let debs = folder.join("debs");
        for inner in ["lists/partial", "cache/archives/partial", "debs"] {
            fs::create_dir_all(folder.join(inner))?;
        }
        fs::write(folder.join("status"), "")?;
        let config = folder.join("apt.conf");
        fs::write(&config, apt_config(folder))?;
        Ok(Self { config, debs })
    }

    fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.env("LC_ALL", "C").current_dir(&self.debs);
        command.arg("-c").arg(&self.config).arg("-q");
        command
    }

    fn update(&self) -> Outcome {
        output(self.command("apt-get").arg("update")).map(drop)
    }

    /// The packages asked for and all they depend on, each as `name=version`, without what the system has.
    fn resolve(&self, packages: &[&str]) -> Outcome<Vec<Package>> {
        let mut apt = self.command("apt-get");
        apt.args(["-s", "install", "--no-install-recommends"]);
        Ok(resolved(&output(apt.args(packages))?))
    }

    fn download(&self, packages: &[Package], tree: &Path) -> Outcome {
        output(self.command("apt-get").arg("download").args(packages))?;
        let mut files: Vec<PathBuf> = fs::read_dir(&self.debs)?
            .map(|entry| Ok(entry?.path()))
            .collect::<std::io::Result<_>>()?;
        files.retain(|file| file.extension().is_some_and(|ending| ending == "deb"));
        if files.len() != packages.len() {
            return Err(format!("{} of {} packages came", files.len(), packages.len()).into());
        }
        files.sort();
        for file in files {
            output(Command::new("dpkg-deb").arg("-x").arg(file).arg(tree))?;
        }
        keep_library_sources(tree)?;
        make_links_relative(tree, tree)
    }
}

/// Of Rust's sources, 440 MB, only those of its library are needed.
fn keep_library_sources(tree: &Path) -> Outcome {
    for sources in fs::read_dir(tree.join("usr/src")).into_iter().flatten() {
        let sources = sources?.path();
        for folder in ["src", "compiler"] {
            remove(&sources.join(folder))?;
        }
    }
    Ok(())
}

/// Everything apt writes goes into `folder`; hooks of the system's configuration are not run.
fn apt_config(folder: &Path) -> String {
    let folder = folder.display();
    let mut text = format!(
        "Dir::State \"{folder}\";\nDir::State::Lists \"{folder}/lists\";\nDir::State::status \"{folder}/status\";\n\
         Dir::Cache \"{folder}/cache\";\nDir::Log \"{folder}\";\n\
         APT::Sandbox::User \"\";\nDebug::NoLocking \"true\";\n\
         Acquire::Languages \"none\";\nAcquire::IndexTargets::deb::DEP-11::DefaultEnabled \"false\";\n\
         Acquire::Retries \"2\";\nAcquire::http::Timeout \"30\";\nAcquire::https::Timeout \"30\";\n"
    );
    for hook in ["Pre-Invoke", "Post-Invoke", "Post-Invoke-Success"] {
        text += &format!("#clear APT::Update::{hook};\n#clear DPkg::{hook};\n");
    }
    text
}

/// Reads what `apt-get -s install` would install: `Inst name (version …`.
fn resolved(simulation: &str) -> Vec<Package> {
    let lines = simulation
        .lines()
        .filter_map(|line| line.strip_prefix("Inst "));
    let packages = lines.filter_map(|line| {
        let (name, rest) = line.split_once(" (")?;
        Some((name, rest.split([' ', ')']).next()?))
    });
    packages
        .filter(|(name, _)| !FROM_SYSTEM.iter().any(|start| name.starts_with(start)))
        .map(|(name, version)| format!("{name}={version}"))
        .collect()
}

/// A link to `/usr/…` would lead out of the tree: it is made to lead to the same file within.
fn make_links_relative(tree: &Path, folder: &Path) -> Outcome {
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
    Err(ErrorKind::Unsupported.into())
}

/// The folders of the tree that hold its libraries, relative to it: `usr/lib/x86_64-linux-gnu` and the like.
fn library_folders(tree: &Path) -> Outcome<Vec<String>> {
    let mut folders = Vec::new();
    for above in ["lib", "usr/lib"] {
        for entry in fs::read_dir(tree.join(above)).into_iter().flatten() {
            let name = entry?.file_name().to_string_lossy().into_owned();
            if name.contains("-linux-") {
                folders.push(format!("{above}/{name}"));
            }
        }
    }
    Ok(folders)
}

/// A script that starts a program with the tree's libraries, wherever the tree has been moved.
fn wrapper(program: &str, libraries: &[String]) -> String {
    let path: Vec<_> = libraries
        .iter()
        .map(|folder| format!("$tree/{folder}"))
        .collect();
    format!(
        "#!/bin/sh\n\
         # Starts {program} from the packages unpacked here, with their libraries.\n\
         tree=$(dirname \"$(dirname \"$(readlink -f \"$0\")\")\")\n\
         export LD_LIBRARY_PATH=\"{}${{LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}}\"\n\
         exec \"$tree/usr/bin/{program}\" \"$@\"\n",
        path.join(":")
    )
}

fn wrap(tree: &Path, program: &str, libraries: &[String]) -> Outcome {
    let path = tree.join(STARTERS).join(program);
    fs::write(&path, wrapper(program, libraries))?;
    output(Command::new("chmod").arg("755").arg(&path)).map(drop)
}

/// What the program says of its version; an error if it cannot: a library is missing, say.
fn version(program: &Path) -> Outcome<String> {
    output(Command::new(program).arg("--version"))
        .map(|text| text.lines().next().unwrap_or_default().to_owned())
}

/// A program's standard output; on failure the last line it wrote, an error of apt's rather than a warning.
fn output(command: &mut Command) -> Outcome<String> {
    let program = command.get_program().to_string_lossy().into_owned();
    let output = command
        .stdin(Stdio::null())
        .output()
        .map_err(|e| format!("cannot start {program}: {e}"))?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let lines = || said.lines().map(str::trim).filter(|line| !line.is_empty());
    let reason = lines()
        .find(|line| line.starts_with("E:"))
        .or_else(|| lines().last());
    Err(reason
        .map_or_else(
            || format!("{program} ended with {}", output.status),
            |reason| reason.trim_start_matches("E:").trim().into(),
        )
        .into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_simulation_gives_names_and_versions_without_the_systems_own() {
        let text = "Reading package lists...\n\
            Inst libc6 (2.36-9+deb12u14 Debian:12.11/oldstable [amd64]) []\n\
            Inst gcc-12-base (12.2.0-14+deb12u1 Debian:12 [amd64])\n\
            Inst libfdt1 (1.6.1-4+b1 Debian:12.11/oldstable [amd64])\n\
            Inst qemu-system-arm (1:7.2+dfsg-7+deb12u18+b3 Debian:12 [amd64])\n\
            Conf libfdt1 (1.6.1-4+b1 Debian:12.11/oldstable [amd64])\n";
        assert_eq!(
            resolved(text),
            [
                "libfdt1=1.6.1-4+b1",
                "qemu-system-arm=1:7.2+dfsg-7+deb12u18+b3"
            ]
        );
    }

    #[test]
    fn no_wanted_package_is_left_to_the_system() {
        for bundle in [QEMU, RUST, LLD] {
            for package in bundle.packages {
                assert!(!FROM_SYSTEM.iter().any(|start| package.starts_with(start)));
            }
        }
    }

    #[test]
    fn a_failure_is_told_by_apts_error() {
        let script =
            "echo 'W: slow' >&2; echo 'E: no such package' >&2; echo 'W: more' >&2; exit 100";
        let error = output(Command::new("sh").args(["-c", script])).unwrap_err();
        assert_eq!(error.to_string(), "no such package");
    }

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
