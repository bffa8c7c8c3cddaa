//! The oldest Rust the project supports: `rust-version` in Cargo.toml.

use std::process::Command;

use crate::{
    JobResult,
    checks::skipped,
    command::{self, cargo},
    tools::toolchain::{on_its_own, version_of},
};

/// As in the root's Cargo.toml.
pub const OLDEST: &str = env!("CARGO_PKG_RUST_VERSION");

/// Checks the workspace with that Rust where it is installed; else says that it did not. Returns a remark.
pub fn run() -> JobResult<String> {
    let Some(mut cargo) = oldest_cargo() else {
        return skipped(format!(
            "Rust {OLDEST} is not installed; type: rustup toolchain install --profile minimal {OLDEST}"
        ));
    };
    cargo.args(["check", "--workspace", "--all-targets", "--locked"]);
    cargo.args(["--target-dir", "target/msrv"]);
    command::run(&mut cargo)?;
    Ok(format!("with Rust {OLDEST}"))
}

/// The cargo in use if its Rust is that old, or that of a toolchain rustup has.
fn oldest_cargo() -> Option<Command> {
    let in_use = command::ask(cargo().arg("--version"))?;
    if version_of(&in_use) == version_of(OLDEST) {
        return Some(cargo());
    }
    let toolchains = command::ask(Command::new("rustup").args(["toolchain", "list"]))?;
    let name = toolchain(&toolchains)?;
    let mut command = Command::new("rustup");
    // What the cargo that started us has set is for its own Rust.
    on_its_own(&mut command);
    command.current_dir(command::root());
    command.args(["run", name, "cargo"]);
    Some(command)
}

/// The installed toolchain of that version, in rustup's list: `1.89-x86_64-unknown-linux-gnu (active)`.
fn toolchain(list: &str) -> Option<&str> {
    let names = list.lines().filter_map(|line| line.split(' ').next());
    names
        .filter(|name| name.starts_with(|first: char| first.is_ascii_digit()))
        .find(|name| {
            let number = name.split('-').next().unwrap_or_default();
            version_of(number) == version_of(OLDEST)
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_toolchain_is_found_by_its_version() {
        let minor = version_of(OLDEST).unwrap().1;
        let list = format!(
            "stable-x86_64-unknown-linux-gnu (active, default)\n1.{}.0-x86_64-unknown-linux-gnu\n\
             1.{minor}0-x86_64-unknown-linux-gnu\n1.{minor}.1-x86_64-unknown-linux-gnu (override)",
            minor + 1
        );
        let name = format!("1.{minor}.1-x86_64-unknown-linux-gnu");
        assert_eq!(toolchain(&list), Some(&*name));
        assert_eq!(toolchain("stable-x86_64-unknown-linux-gnu"), None);
        assert_eq!(toolchain("no installed toolchains"), None);
    }
}
