//! The program and the wheel, built to be handed out. Zig links them against an old C library, so that they start on old
//! systems; where there is no Zig, they are linked against this system's.

use std::{
    path::{Path, PathBuf},
    process::Command,
};

use crate::{
    JobResult,
    command::{self, cargo, root},
    python,
};

/// What links against another C library than this system's.
const ZIG: &[&str] = &["cargo-zigbuild>=0.20,<1", "ziglang>=0.13,<1"];

/// The C library that is linked against: the oldest for which Rust itself is built.
const GLIBC: &str = "2.17";

/// The tag of wheels for systems with that C library.
const MANYLINUX: &str = "manylinux2014";

/// How both are linked.
pub struct Linking {
    environment: PathBuf,
    zig: bool,
}

impl Linking {
    /// With Zig where the system has the GNU C library and Zig can be had.
    pub fn choose(target: &str) -> JobResult<Self> {
        let environment = python::own_environment()?;
        let gnu = target.ends_with("-linux-gnu");
        let zig = gnu && {
            let got = command::run(python::pip(&environment).args(ZIG));
            if let Err(error) = &got {
                println!("no Zig here ({error}): linked against this system's C library");
            }
            got.is_ok()
        };
        Ok(Self { environment, zig })
    }

    /// What the program needs of the system, as the end of a sentence.
    pub fn needs(&self) -> String {
        if self.zig {
            format!("needs glibc {GLIBC} or newer")
        } else {
            "needs a system as new as the one it was built on".into()
        }
    }

    /// A command with the environment's programs in the path, and no folder of this machine in what is built.
    fn prepared(&self, mut command: Command) -> JobResult<Command> {
        let inherited = std::env::var_os("PATH").unwrap_or_default();
        let folders =
            std::iter::once(self.environment.join("bin")).chain(std::env::split_paths(&inherited));
        command.env("PATH", std::env::join_paths(folders)?);
        let home = home()?;
        let flags = [
            format!("--remap-path-prefix={}=/cargo", home.display()),
            format!("--remap-path-prefix={}=/vibroimpact", root().display()),
        ];
        command.env("CARGO_ENCODED_RUSTFLAGS", flags.join("\x1f"));
        // The folder that Cargo calls like the profile would be where the archive goes.
        command.env("CARGO_TARGET_DIR", target_folder());
        for name in ["RUSTFLAGS", "CARGO_BUILD_TARGET"] {
            command.env_remove(name);
        }
        Ok(command)
    }

    /// Builds `host-sim`, with the page in it if there is one; where it is.
    pub fn program(&self, target: &str, page: bool) -> JobResult<PathBuf> {
        let mut build = self.prepared(cargo())?;
        let (job, triple) = if self.zig {
            ("zigbuild", format!("{target}.{GLIBC}"))
        } else {
            ("build", target.to_owned())
        };
        build.args([job, "--locked", "--profile", "dist"]);
        build.args(["--package", "host-sim", "--target", &triple]);
        if page {
            build.args(["--features", "page"]);
        }
        command::run(&mut build)?;
        let name = format!("host-sim{}", std::env::consts::EXE_SUFFIX);
        Ok(target_folder().join(target).join("dist").join(name))
    }

    /// Builds the wheel into `place`; its time is `seconds` since 1970.
    pub fn wheel(&self, target: &str, place: &Path, seconds: u64) -> JobResult<PathBuf> {
        let maturin = Command::new(self.environment.join("bin/maturin"));
        let mut build = self.prepared(maturin)?;
        build.env("SOURCE_DATE_EPOCH", seconds.to_string());
        build.args(["build", "--locked", "--profile", "dist"]);
        build.args(["--target", target]);
        if self.zig {
            build.args(["--zig", "--compatibility", MANYLINUX]);
        }
        python::wheel(build, &self.environment, place)
    }
}

/// Where Cargo keeps the sources of crates.
fn home() -> JobResult<PathBuf> {
    if let Some(home) = std::env::var_os("CARGO_HOME") {
        return Ok(home.into());
    }
    let user = std::env::var_os("HOME").ok_or("neither CARGO_HOME nor HOME is set")?;
    Ok(PathBuf::from(user).join(".cargo"))
}

fn target_folder() -> PathBuf {
    root().join("target/dist-build")
}

/// The system that the Rust in use builds for, `x86_64-unknown-linux-gnu` say.
pub fn target() -> JobResult<String> {
    let about = command::output(Command::new("rustc").arg("-vV"))?;
    let host = about.lines().find_map(|line| line.strip_prefix("host: "));
    Ok(host.ok_or("rustc does not say what it builds for")?.into())
}
