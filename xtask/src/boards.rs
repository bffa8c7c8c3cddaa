//! The boards the firmware is built for: the folders of `firmware/src/hardware` that have a `board.toml`.

use std::path::{Path, PathBuf};

use serde::{Deserialize, de::Error};

use crate::{JobResult, command};

/// The board whose image is flashed and run in the model of the board.
pub const NUCLEO: &str = "nucleo";
/// The board that QEMU plays.
pub const QEMU: &str = "qemu";

/// A board as its `board.toml` describes it.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "kebab-case")]
pub struct BuiltBoard {
    /// Its folder's name, which is also that on the command line.
    #[serde(skip)]
    pub name: String,
    /// Its name for people.
    #[serde(rename = "name")]
    pub title: String,
    /// The programs built for it.
    pub programs: Vec<String>,
    /// Whether flip-link links it.
    pub flip_link: bool,
    /// The part, as probe-rs calls it; none for a board that nothing is flashed to.
    pub chip: Option<String>,
}

impl BuiltBoard {
    /// The feature of the package that stands for it.
    pub fn feature(&self) -> String {
        format!("board-{}", self.name)
    }

    fn read(folder: &Path) -> JobResult<Self> {
        let path = folder.join("board.toml");
        let text = std::fs::read_to_string(&path)
            .map_err(|e| format!("cannot read {}: {e}", path.display()))?;
        let name = folder.file_name().unwrap_or_default();
        Self::parse(&name.to_string_lossy(), &text)
            .map_err(|e| format!("{}: {e}", path.display()).into())
    }

    fn parse(name: &str, text: &str) -> Result<Self, toml::de::Error> {
        let board: Self = toml::from_str(text)?;
        if board.programs.is_empty() {
            return Err(Error::custom("`programs` is empty"));
        }
        let name = name.into();
        Ok(Self { name, ..board })
    }
}

fn folder() -> PathBuf {
    command::root().join("firmware/src/hardware")
}

/// Every board, by name.
pub fn all() -> JobResult<Vec<BuiltBoard>> {
    let mut folders = Vec::new();
    for entry in std::fs::read_dir(folder())? {
        let path = entry?.path();
        if path.join("board.toml").is_file() {
            folders.push(path);
        }
    }
    folders.sort();
    folders
        .iter()
        .map(|folder| BuiltBoard::read(folder))
        .collect()
}

/// The board of that name.
pub fn named(name: &str) -> JobResult<BuiltBoard> {
    let boards = all()?;
    let names: Vec<_> = boards.iter().map(|board| board.name.clone()).collect();
    let board = boards.into_iter().find(|board| board.name == name);
    board.ok_or_else(|| format!("no board `{name}`: choose one of {}", names.join(", ")).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(path: &str) -> String {
        std::fs::read_to_string(command::root().join(path)).unwrap()
    }

    #[test]
    fn boards_are_found_by_their_folder() {
        for board in all().unwrap() {
            assert_eq!(named(&board.name).unwrap(), board);
        }
        assert!(named(NUCLEO).unwrap().chip.is_some());
        assert!(named(QEMU).unwrap().chip.is_none());
        let error = named("uno").unwrap_err().to_string();
        assert!(error.contains("nucleo, qemu"), "{error}");
    }

    /// What a board needs beside its folder.
    #[test]
    fn every_board_has_its_feature_its_programs_its_module_and_its_memory() {
        let manifest = read("firmware/Cargo.toml");
        let modules = read("firmware/src/hardware/mod.rs");
        for board in all().unwrap() {
            let (name, feature) = (&board.name, board.feature());
            assert!(
                manifest.contains(&format!("\n{feature} = [")),
                "firmware/Cargo.toml has no feature {feature}"
            );
            for program in &board.programs {
                let line = format!("\nname = \"{program}\"\n");
                let required = format!("\nrequired-features = [\"{feature}\"]\n");
                let mut bins = manifest.split("[[bin]]");
                assert!(
                    bins.any(|bin| bin.contains(&line) && bin.contains(&required)),
                    "firmware/Cargo.toml has no program {program} that requires {feature}"
                );
            }
            let line = format!("#[cfg_attr(feature = \"{feature}\", path = \"{name}/mod.rs\")]\n");
            assert!(modules.contains(&line), "hardware/mod.rs lacks {line}");
            assert!(folder().join(name).join("memory.x").is_file(), "{name}");
        }
    }

    #[test]
    fn what_a_descriptor_lacks_is_named() {
        let good = "name = \"A\"\nprograms = [\"a\"]\nflip-link = true\n";
        let board = BuiltBoard::parse("a", good).unwrap();
        assert!(board.flip_link && board.chip.is_none());
        assert_eq!(board.feature(), "board-a");
        for (without, named) in [
            ("name = \"A\"\n", "`name`"),
            ("programs = [\"a\"]\n", "`programs`"),
            ("\"a\"", "`programs`"),
            ("flip-link = true\n", "`flip-link`"),
        ] {
            let error = BuiltBoard::parse("a", &good.replace(without, "")).unwrap_err();
            let error = error.to_string();
            assert!(error.contains(named), "{error}");
        }
    }
}
