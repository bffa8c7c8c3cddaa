//! Debian's packages without installing them: `xtask/unpack-debian.sh` unpacks them below `target/tools`.

use std::{fs, path::PathBuf, process::Command};

use crate::{
    JobResult,
    command::{self, find, root},
};

/// Packages that are unpacked together, with all their libraries.
#[derive(Debug)]
pub struct Bundle {
    /// Its folder below `target/tools`.
    name: &'static str,
    /// The packages asked for.
    packages: &'static str,
    /// The programs wanted of them: of `/usr/bin`, or as paths below `/usr`.
    programs: &'static str,
}

/// QEMU, which emulates the microcontroller.
pub const QEMU: Bundle = Bundle {
    name: "qemu",
    packages: "qemu-system-arm",
    programs: "qemu-system-arm",
};

/// Debian's Rust with the sources of `core`.
pub const RUST: Bundle = Bundle {
    name: "rust",
    packages: "rustc-web cargo-web rust-web-src rust-web-clippy",
    programs: "rustc cargo cargo-clippy clippy-driver",
};

/// A linker for the microcontroller.
pub const LLD: Bundle = Bundle {
    name: "lld",
    packages: "lld",
    programs: "ld.lld",
};

/// A browser without a window, and letters for it.
pub const CHROMIUM: Bundle = Bundle {
    name: "chromium",
    packages: "chromium-headless-shell fonts-dejavu-core",
    // What is in `bin` is a script that wants it installed.
    programs: "lib/chromium/chromium-headless-shell",
};

/// The folder below which every tool is unpacked.
pub fn tools() -> PathBuf {
    root().join("target/tools")
}

/// Whether this is a Debian, or one of its descendants.
pub fn here() -> bool {
    find("apt-get").is_some() && find("dpkg-deb").is_some()
}

impl Bundle {
    /// Where its programs are started from once it is unpacked.
    pub fn starters(&self) -> PathBuf {
        tools().join(self.name).join("starters")
    }

    /// The line that installs it into the system instead.
    pub fn install_line(&self) -> String {
        format!(
            "sudo apt-get install --no-install-recommends {}",
            self.packages
        )
    }

    /// Unpacks it where that has not been done; `Err` says in one line why not.
    pub fn provide(&self) -> JobResult {
        let folder = tools().join(self.name);
        let packages = fs::read_to_string(folder.join("packages")).unwrap_or_default();
        if packages.lines().next() == Some(&format!("wanted: {}", self.packages)) {
            return Ok(());
        }
        let mut unpack = Command::new("sh");
        unpack.arg(root().join("xtask/unpack-debian.sh"));
        unpack.arg(folder).args([self.packages, self.programs]);
        command::run(&mut unpack).map_err(|error| {
            format!(
                "cannot get Debian's {}: {error}; check the network and apt's sources",
                self.packages
            )
            .into()
        })
    }
}

#[cfg(all(test, unix))]
mod tests {
    use std::{os::unix::fs::PermissionsExt, path::Path};

    use super::*;

    /// Stands for apt and dpkg: one package with a program, a library and links out of the tree, and the C library.
    const APT: &str = r#"#!/bin/sh
case "$*" in
*-s*) echo 'Inst libc6 (2.36 Debian:12 [amd64]) []'; echo 'Inst say (1:2.0+b3 Debian:12 [amd64])' ;;
*download\ say=1:2.0+b3) touch say.deb ;;
esac
"#;
    const DPKG: &str = r#"#!/bin/sh
tree=$3
mkdir -p "$tree/usr/bin" "$tree/usr/lib/x-linux-gnu"
echo inside >"$tree/usr/lib/x-linux-gnu/one"
ln -s /usr/lib/x-linux-gnu/one "$tree/usr/lib/two"
ln -s /usr/lib "$tree/three"
ln -s /nowhere/else "$tree/usr/lib/four"
printf '#!/bin/sh\necho "$LD_LIBRARY_PATH $1"\n' >"$tree/usr/bin/say"
chmod 755 "$tree/usr/bin/say"
"#;

    #[test]
    fn packages_come_without_the_system_s_own_and_their_links_stay_within() {
        let place = tempfile::tempdir().unwrap();
        let path = |name: &str| place.path().join(name);
        for (name, text) in [("apt-get", APT), ("dpkg-deb", DPKG)] {
            fs::write(path(name), text).unwrap();
            fs::set_permissions(path(name), fs::Permissions::from_mode(0o755)).unwrap();
        }
        let folders = std::env::var_os("PATH").unwrap();
        let folders = std::env::split_paths(&folders);
        let folders = std::iter::once(place.path().to_owned()).chain(folders);
        let mut unpack = Command::new("sh");
        unpack.arg(root().join("xtask/unpack-debian.sh"));
        unpack.arg(path("tools/say")).args(["say", "say"]);
        unpack.env("PATH", std::env::join_paths(folders).unwrap());
        command::output(&mut unpack).unwrap();
        let made = |name: &str| path("tools/say").join(name);
        let packages = fs::read_to_string(made("packages")).unwrap();
        assert_eq!(packages, "wanted: say\nsay=1:2.0+b3\n");
        let link = |name: &str| fs::read_link(made(name)).unwrap();
        assert_eq!(fs::read_to_string(made("usr/lib/two")).unwrap(), "inside\n");
        assert_eq!(
            link("usr/lib/two"),
            Path::new("../../usr/lib/x-linux-gnu/one")
        );
        assert_eq!(link("three"), Path::new("./usr/lib"));
        assert_eq!(link("usr/lib/four"), Path::new("/nowhere/else"));
        // It may be moved.
        fs::rename(path("tools/say"), path("moved")).unwrap();
        let mut say = Command::new(path("moved/starters/say"));
        let said = command::output(say.env_remove("LD_LIBRARY_PATH").arg("on")).unwrap();
        let moved = fs::canonicalize(path("moved")).unwrap();
        assert_eq!(
            said,
            format!("{}/usr/lib/x-linux-gnu on\n", moved.display())
        );
    }
}
