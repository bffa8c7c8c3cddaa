//! apt with package lists, cache and an empty list of installed packages of its own, but the system's sources.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use crate::{Outcome, command::output};

/// Dependencies taken from the system: the C library (two of them in one process do not work), the C compiler, which
/// Rust needs on every machine anyway, and what serves installation only. Beginnings of package names.
pub const FROM_SYSTEM: &[&str] = &[
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

/// A package and its version, as apt writes it.
pub type Package = String;

/// Where it finds its configuration, and puts what it downloads.
pub struct Apt {
    config: PathBuf,
    debs: PathBuf,
}

impl Apt {
    /// With all that it writes in `folder`.
    pub fn new(folder: &Path) -> Outcome<Self> {
        let debs = folder.join("debs");
        for inner in ["lists/partial", "cache/archives/partial", "debs"] {
            fs::create_dir_all(folder.join(inner))?;
        }
        fs::write(folder.join("status"), "")?;
        let config = folder.join("apt.conf");
        fs::write(&config, apt_config(folder))?;
        Ok(Self { config, debs })
    }

    /// The same for another release of the system's mirror.
    pub fn of_release(folder: &Path, release: &str) -> Outcome<Self> {
        let apt = Self::new(folder)?;
        // apt tells of the places whose lists it has read.
        apt.update()?;
        let mut ask = apt.command("apt-get");
        let places = output(ask.args(["indextargets", "--format", "$(REPO_URI)"]))?;
        let mirror = mirror(&places).ok_or("apt's sources name no mirror of Debian")?;
        let sources = folder.join("sources.list");
        fs::write(&sources, format!("deb {mirror} {release} main\n"))?;
        let mut config = fs::read_to_string(&apt.config)?;
        config += &format!(
            "Dir::Etc::SourceList \"{}\";\nDir::Etc::SourceParts \"/dev/null\";\n",
            sources.display()
        );
        fs::write(&apt.config, config)?;
        Ok(apt)
    }

    fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.env("LC_ALL", "C").current_dir(&self.debs);
        command.arg("-c").arg(&self.config).arg("-q");
        command
    }

    /// Reads the sources' package lists.
    pub fn update(&self) -> Outcome {
        output(self.command("apt-get").arg("update")).map(drop)
    }

    /// The packages asked for and all they depend on, each as `name=version`, without what the system has.
    pub fn resolve(&self, packages: &[&str]) -> Outcome<Vec<Package>> {
        let mut apt = self.command("apt-get");
        apt.args(["-s", "install", "--no-install-recommends"]);
        Ok(resolved(&output(apt.args(packages))?))
    }

    /// Downloads the packages and unpacks them into `tree`.
    pub fn unpack(&self, packages: &[Package], tree: &Path) -> Outcome {
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
        Ok(())
    }
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

/// The mirror of Debian itself among the places that apt's sources name, a line each.
fn mirror(places: &str) -> Option<&str> {
    places
        .lines()
        .find(|place| place.trim_end_matches('/').ends_with("/debian"))
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
    fn the_mirror_is_the_one_of_debian_itself() {
        let places = "http://x.example/debian-security/\nhttp://x.example/debian/\n";
        assert_eq!(mirror(places), Some("http://x.example/debian/"));
        assert_eq!(mirror("http://x.example/ubuntu/"), None);
    }

    #[test]
    fn what_apt_writes_stays_in_the_folder() {
        let config = apt_config(Path::new("/p/apt"));
        for setting in [
            "Dir::State",
            "Dir::State::Lists",
            "Dir::State::status",
            "Dir::Cache",
            "Dir::Log",
        ] {
            assert!(config.contains(&format!("{setting} \"/p/apt")), "{setting}");
        }
        assert!(config.contains("#clear APT::Update::Post-Invoke;"));
    }
}
