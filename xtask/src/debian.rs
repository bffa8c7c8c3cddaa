//! What must be installed for the firmware, and installing it where that is ours
//! to do: on Debian, as root. Elsewhere the exact line to type is printed.

use std::{path::Path, process::Command};

use crate::{
    Outcome,
    command::{self, find},
    toolchain::{self, Missing, TARGET},
};

/// Debian's Rust with the sources of `core`, and the linker it needs.
const RUST: &[&str] = &[
    "rustc-web",
    "cargo-web",
    "rust-web-src",
    "rust-web-clippy",
    "lld",
];
/// The emulator.
const QEMU: &[&str] = &["qemu-system-arm"];

/// What is missing, as Debian packages and as a sentence for everybody else.
struct Lack {
    packages: Vec<&'static str>,
    advice: Vec<String>,
}

/// Says what a missing piece is called where one does not install Debian's Rust.
pub fn advice(missing: &Missing) -> String {
    match missing {
        Missing::Rust => format!(
            "no Rust here builds for {TARGET}; type: rustup target add {TARGET}\n\
             or, on Debian: sudo apt-get install --no-install-recommends {}",
            RUST.join(" ")
        ),
        Missing::Linker => {
            "no linker for the firmware; install lld (Debian: sudo apt-get install lld)".into()
        }
    }
}

/// What to install where there is no emulator.
pub fn qemu_advice() -> String {
    "no qemu-system-arm here; install QEMU for Arm (Debian: sudo apt-get install --no-install-recommends qemu-system-arm)".into()
}

fn lacking() -> Lack {
    let mut lack = Lack {
        packages: Vec::new(),
        advice: Vec::new(),
    };
    match toolchain::choose(&toolchain::look()) {
        Ok(toolchain::Toolchain::Debian(_)) if !toolchain::debian_clippy() => {
            lack.packages.push("rust-web-clippy")
        }
        Ok(_) => {}
        Err(missing) => {
            let packages = if missing == Missing::Linker {
                &["lld"]
            } else {
                RUST
            };
            lack.packages.extend(packages);
            lack.advice.push(advice(&missing));
        }
    }
    if find("qemu-system-arm").is_none() {
        lack.packages.extend(QEMU);
        lack.advice.push(qemu_advice());
    }
    lack
}

/// Sees to it that everything can be checked here.
pub fn provide() -> Outcome {
    for tool in ["fmt", "clippy"] {
        if command::ask(command::cargo().args([tool, "--version"])).is_none() {
            return Err(
                format!("no cargo {tool} here; type: rustup component add rustfmt clippy").into(),
            );
        }
    }
    let lack = lacking();
    if lack.packages.is_empty() {
        println!("all there");
        return Ok(());
    }
    if may_install() {
        install(&lack.packages).map_err(|error| format!("{error}\n{}", lack.advice.join("\n")))?;
        let still = lacking();
        return if still.advice.is_empty() {
            Ok(())
        } else {
            Err(still.advice.join("\n").into())
        };
    }
    if lack.advice.is_empty() {
        println!(
            "note: without {} the firmware is built but not linted",
            lack.packages.join(" ")
        );
        return Ok(());
    }
    Err(lack.advice.join("\n").into())
}

fn may_install() -> bool {
    let debian = Path::new("/etc/debian_version").exists() && find("apt-get").is_some();
    debian && command::ask(Command::new("id").arg("-u")).as_deref() == Some("0")
}

fn install(packages: &[&str]) -> Outcome {
    let apt = |args: &[&str]| {
        let mut command = Command::new("apt-get");
        command
            .env("DEBIAN_FRONTEND", "noninteractive")
            .args(["-q", "-o", "DPkg::Lock::Timeout=120"])
            .args(args);
        command
    };
    command::run(&mut apt(&["update"]))?;
    // Nothing that is installed may have to go for it.
    command::run(apt(&["install", "-y", "--no-install-recommends", "--no-remove"]).args(packages))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn advice_can_be_typed() {
        assert!(advice(&Missing::Rust).contains("rustup target add thumbv7em-none-eabihf\n"));
        assert!(advice(&Missing::Rust).contains("rustc-web cargo-web rust-web-src"));
        assert!(advice(&Missing::Linker).contains("apt-get install lld"));
    }
}
