//! Which Rust builds the firmware, and which linker links it.
//!
//! The ordinary way is a Rust that has `core` for the microcontroller
//! (`rustup target add`). Where the target cannot be had, Debian's Rust packages
//! bring the sources of `core` along and can build it themselves.

use std::{
    path::{Path, PathBuf},
    process::Command,
};

use super::debian;
use crate::command;

/// The microcontroller, as Rust calls it: Cortex-M4 with a single-precision FPU.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// The browser, as Rust calls it.
pub const WASM: &str = "wasm32-unknown-unknown";

/// Where Debian installs its Rust.
const DEBIAN_BIN: &str = "/usr/bin";

/// What this machine has.
#[derive(Clone, Debug, Default)]
pub struct ToolsFound {
    /// The Rust in use has `core` for the target.
    pub target_core: bool,
    /// The Rust in use finds its own `rust-lld` when it links.
    pub own_linker: bool,
    /// The folder of Debian's rustc and cargo, recent enough, with the sources of `core`.
    pub debian_rust: Option<PathBuf>,
    /// A linker that can be named to either.
    pub lld: Option<PathBuf>,
    /// The `rust-lld` of the Rust in use: as new as its objects, and it links for a browser, too.
    pub own_lld: Option<PathBuf>,
}

/// How the firmware gets built, or the page's module.
#[derive(Debug, PartialEq)]
pub enum Toolchain {
    /// The Rust in use, as it is; with a linker where it has none.
    InUse(Option<PathBuf>),
    /// Debian's Rust, which builds `core` too.
    Debian {
        /// Where rustc and cargo are started from.
        bin: PathBuf,
        /// The linker named to it.
        linker: PathBuf,
    },
}

/// What must be installed before the firmware can be built.
#[derive(Debug, PartialEq)]
pub enum Missing {
    /// A Rust for the target.
    Rust,
    /// A linker for it.
    Linker,
}

/// Chooses the way that needs least: the Rust in use, then Debian's.
pub fn choose(found: &ToolsFound) -> Result<Toolchain, Missing> {
    if found.target_core && found.own_linker {
        return Ok(Toolchain::InUse(None));
    }
    let bin = match (&found.debian_rust, found.target_core) {
        (None, false) => return Err(Missing::Rust),
        (bin, _) => bin.clone(),
    };
    let linker = found.lld.clone().ok_or(Missing::Linker)?;
    Ok(match bin {
        Some(bin) if !found.target_core => Toolchain::Debian { bin, linker },
        _ => Toolchain::InUse(Some(linker)),
    })
}

/// Chooses for the page's module. Its linker is a `rust-lld`: Debian's `ld.lld` is too old for the objects.
pub fn choose_for_wasm(found: &ToolsFound) -> Result<Toolchain, Missing> {
    if found.target_core {
        return Ok(Toolchain::InUse(None));
    }
    let bin = found.debian_rust.clone().ok_or(Missing::Rust)?;
    let linker = found.own_lld.clone().ok_or(Missing::Linker)?;
    Ok(Toolchain::Debian { bin, linker })
}

/// Looks around on this machine for what builds for `target`.
pub fn look(target: &str) -> ToolsFound {
    let rustc = || Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()));
    let own_tools = command::ask(rustc().args(["--print", "target-libdir"]))
        .map(|libdir| Path::new(&libdir).with_file_name("bin"));
    let own_lld = own_tools
        .map(|bin| bin.join("rust-lld"))
        .filter(|file| file.is_file());
    let libdir = command::ask(rustc().args(["--print", "target-libdir", "--target", target]));
    let unpacked_lld = Some(debian::LLD.starters().join("ld.lld")).filter(|file| file.is_file());
    ToolsFound {
        target_core: libdir.is_some_and(|libdir| holds_core(Path::new(&libdir))),
        own_linker: own_lld.is_some() || command::find("rust-lld").is_some(),
        debian_rust: [PathBuf::from(DEBIAN_BIN), debian::RUST.starters()]
            .into_iter()
            .find(|bin| is_debian_rust(bin)),
        lld: command::find("ld.lld").or(own_lld.clone()).or(unpacked_lld),
        own_lld: own_lld.or_else(|| command::find("rust-lld")),
    }
}

fn holds_core(libdir: &Path) -> bool {
    let files = std::fs::read_dir(libdir).into_iter().flatten().flatten();
    files
        .map(|file| file.file_name())
        .any(|name| name.to_string_lossy().starts_with("libcore-"))
}

fn is_debian_rust(bin: &Path) -> bool {
    let rustc = bin.join("rustc");
    let version = command::ask(on_its_own(&mut Command::new(&rustc)).arg("--version"));
    let sysroot = command::ask(on_its_own(&mut Command::new(&rustc)).args(["--print", "sysroot"]));
    let (Some(version), Some(sysroot)) = (version, sysroot) else {
        return false;
    };
    version_of(&version)
        .is_some_and(|found| Some(found) >= version_of(env!("CARGO_PKG_RUST_VERSION")))
        && Path::new(&sysroot)
            .join("lib/rustlib/src/rust/library/core")
            .is_dir()
        && bin.join("cargo").is_file()
}

/// Major and minor version in `rustc 1.96.0 (…)` or `1.88`.
pub fn version_of(text: &str) -> Option<(u32, u32)> {
    let number = text
        .split_whitespace()
        .find(|word| word.starts_with(|c: char| c.is_ascii_digit()))?;
    let mut parts = number.split('.');
    Some((parts.next()?.parse().ok()?, parts.next()?.parse().ok()?))
}

/// Takes from a command what the cargo that started us left in the environment
/// for its own toolchain, and flags meant for the host.
pub fn on_its_own(command: &mut Command) -> &mut Command {
    for name in [
        "RUSTUP_TOOLCHAIN",
        "LD_LIBRARY_PATH",
        "CARGO",
        "RUSTC",
        "RUSTDOC",
        "RUSTC_WRAPPER",
        "RUSTC_WORKSPACE_WRAPPER",
    ] {
        command.env_remove(name);
    }
    command
}

impl Toolchain {
    /// `cargo SUBCOMMAND` for the target, to be run in the root of the project,
    /// with a target folder of its own.
    pub fn cargo(&self, subcommand: &str) -> Command {
        self.cargo_for(TARGET, subcommand, "core", "target/thumb")
    }

    /// `cargo SUBCOMMAND` for a browser. The module needs 128-bit vectors, which every browser since 2023 has.
    pub fn wasm_cargo(&self, subcommand: &str) -> Command {
        let mut command = self.cargo_for(WASM, subcommand, "std,panic_abort", "target/wasm");
        command.env(
            "CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS",
            "-Ctarget-feature=+simd128",
        );
        command
    }

    fn cargo_for(&self, target: &str, subcommand: &str, std: &str, folder: &str) -> Command {
        let mut command = match self {
            Self::InUse(_) => {
                let mut command = command::cargo();
                command.arg(subcommand);
                command
            }
            Self::Debian { bin, .. } => debian_cargo(bin, subcommand, std),
        };
        if let Some(linker) = self.linker() {
            let name = target.to_uppercase().replace('-', "_");
            command.env(format!("CARGO_TARGET_{name}_LINKER"), linker);
        }
        // Flags in the environment are the host's (a `target-cpu`, say).
        command
            .env_remove("RUSTFLAGS")
            .env_remove("CARGO_ENCODED_RUSTFLAGS");
        command.args(["--target", target, "--target-dir", folder]);
        command
    }

    /// The linker that is named to rustc; `None` where it has its own.
    pub fn linker(&self) -> Option<&Path> {
        match self {
            Self::InUse(linker) => linker.as_deref(),
            Self::Debian { linker, .. } => Some(linker),
        }
    }

    /// Whether `cargo clippy` can be asked for the target.
    pub fn has_clippy(&self) -> bool {
        match self {
            Self::InUse(_) => {
                command::ask(command::cargo().args(["clippy", "--version"])).is_some()
            }
            Self::Debian { bin, .. } => ["cargo-clippy", "clippy-driver"]
                .iter()
                .all(|tool| bin.join(tool).is_file()),
        }
    }

    /// Its compiler, to be asked something.
    pub fn rustc(&self) -> Command {
        match self {
            Self::InUse(_) => {
                Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()))
            }
            Self::Debian { bin, .. } => {
                let mut rustc = Command::new(bin.join("rustc"));
                on_its_own(&mut rustc);
                rustc
            }
        }
    }

    /// One line for the log.
    pub fn describe(&self) -> String {
        match self {
            Self::InUse(_) => format!("the Rust in use (it has {TARGET})"),
            Self::Debian { bin, .. } => {
                format!(
                    "Debian's Rust in {} (it builds `core` itself)",
                    bin.display()
                )
            }
        }
    }
}

/// Building `core` (or all of `std`) is not a stable feature of cargo: `RUSTC_BOOTSTRAP` allows it,
/// on this one command and nowhere else.
fn debian_cargo(bin: &Path, subcommand: &str, std: &str) -> Command {
    // cargo would find another toolchain's clippy first: start Debian's directly.
    let clippy = subcommand == "clippy";
    let mut command = Command::new(bin.join(if clippy { "cargo-clippy" } else { "cargo" }));
    on_its_own(&mut command)
        .current_dir(command::root())
        .env("RUSTC", bin.join("rustc"))
        .env("RUSTC_BOOTSTRAP", "1");
    if clippy {
        command.env("CARGO", bin.join("cargo"));
    }
    command.arg(subcommand).arg(format!("-Zbuild-std={std}"));
    command
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lld() -> Option<PathBuf> {
        Some("/usr/bin/ld.lld".into())
    }

    fn debian() -> Toolchain {
        Toolchain::Debian {
            bin: DEBIAN_BIN.into(),
            linker: "/usr/bin/ld.lld".into(),
        }
    }

    #[test]
    fn a_rust_with_the_target_is_used_as_it_is() {
        let found = ToolsFound {
            target_core: true,
            own_linker: true,
            debian_rust: Some(DEBIAN_BIN.into()),
            lld: lld(),
            own_lld: None,
        };
        assert_eq!(choose(&found), Ok(Toolchain::InUse(None)));
    }

    #[test]
    fn a_rust_without_linker_is_given_one() {
        let found = ToolsFound {
            target_core: true,
            lld: lld(),
            ..ToolsFound::default()
        };
        assert_eq!(choose(&found), Ok(Toolchain::InUse(lld())));
    }

    #[test]
    fn debian_steps_in_where_the_target_is_missing() {
        let found = ToolsFound {
            own_linker: true,
            debian_rust: Some(DEBIAN_BIN.into()),
            lld: lld(),
            ..ToolsFound::default()
        };
        assert_eq!(choose(&found), Ok(debian()));
    }

    #[test]
    fn a_browser_s_module_is_linked_by_the_rust_lld_of_the_rust_in_use() {
        let found = ToolsFound {
            debian_rust: Some(DEBIAN_BIN.into()),
            lld: lld(),
            ..ToolsFound::default()
        };
        assert_eq!(choose_for_wasm(&found), Err(Missing::Linker));
        let own_lld: PathBuf = "/rust/bin/rust-lld".into();
        let found = ToolsFound {
            own_lld: Some(own_lld.clone()),
            ..found
        };
        let chosen = choose_for_wasm(&found).unwrap();
        assert_eq!(chosen.linker(), Some(own_lld.as_path()));
        let words: Vec<_> = chosen
            .wasm_cargo("build")
            .get_args()
            .map(|w| w.to_owned())
            .collect();
        assert!(
            words.contains(&"-Zbuild-std=std,panic_abort".into()),
            "{words:?}"
        );
        let found = ToolsFound {
            target_core: true,
            ..found
        };
        assert_eq!(choose_for_wasm(&found), Ok(Toolchain::InUse(None)));
    }

    #[test]
    fn what_is_missing_is_named() {
        assert_eq!(
            choose(&ToolsFound {
                lld: lld(),
                ..ToolsFound::default()
            }),
            Err(Missing::Rust)
        );
        assert_eq!(
            choose(&ToolsFound {
                debian_rust: Some(DEBIAN_BIN.into()),
                ..ToolsFound::default()
            }),
            Err(Missing::Linker)
        );
        assert_eq!(
            choose(&ToolsFound {
                target_core: true,
                ..ToolsFound::default()
            }),
            Err(Missing::Linker)
        );
    }

    #[test]
    fn versions_are_read_and_compared() {
        assert_eq!(
            version_of("rustc 1.96.0 (ac68faa20 2026-05-25)"),
            Some((1, 96))
        );
        assert_eq!(version_of("1.88"), Some((1, 88)));
        assert_eq!(version_of("rustc"), None);
        assert!(version_of("rustc 1.63.0") < version_of("1.88"));
    }

    #[test]
    fn bootstrap_and_the_callers_toolchain_stay_off_each_others_commands() {
        let envs = |toolchain: Toolchain| -> Vec<(String, bool)> {
            let command = toolchain.cargo("build");
            command
                .get_envs()
                .map(|(name, value)| (name.to_string_lossy().into_owned(), value.is_some()))
                .collect()
        };
        let envs_of_debian = envs(debian());
        assert!(envs_of_debian.contains(&("RUSTC_BOOTSTRAP".into(), true)));
        for dropped in ["RUSTUP_TOOLCHAIN", "LD_LIBRARY_PATH", "CARGO"] {
            assert!(
                envs_of_debian.contains(&(dropped.into(), false)),
                "{dropped} is inherited"
            );
        }
        assert!(
            !envs(Toolchain::InUse(None))
                .iter()
                .any(|(name, _)| name == "RUSTC_BOOTSTRAP")
        );
    }
}
