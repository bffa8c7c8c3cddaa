//! What an answer was made from: program, command line, rigs and input files, one value for every kind of file.
//!
//! The time of writing is not in it, nor the folder written to: the same request gives the same bytes.

mod embed;
mod names;
mod owner;
#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::rigfile;
use numerics::NamedRig;
use shared::model::cart::CartDrive;

pub use embed::{into_csv, into_json, into_png, into_svg, pair, stamped};
pub use names::{file_name, in_name};
pub use owner::{refuse_others, says};

/// The field's name in JSON, the key in Parquet and MCAP, the keyword in PNG.
pub const KEY: &str = "made_from";

/// What an answer was made from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MadeFrom {
    /// Name of the program that gave the answer.
    pub program: String,
    /// Version of that program.
    pub version: String,
    /// The command line that makes it again: what was given, without the options that only say where and how to
    /// answer.
    pub command: String,
    /// Every option with its value, whether given or left at its default.
    pub options: Map<String, Value>,
    /// The seed of what is drawn at random, if anything is.
    pub seed: Option<u64>,
    /// The uncertainty of the parameters, if the command uses one.
    pub uncertainty: Option<Map<String, Value>>,
    /// The rigs, with every parameter.
    pub rigs: Vec<RigUsed>,
    /// The files that were read.
    pub inputs: Vec<InputFile>,
    /// Whether the command has `--cart`: its tables say how the cart is moved.
    #[serde(skip)]
    pub has_cart: bool,
}

/// A rig as it was computed with.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RigUsed {
    /// Its name, as it stands in titles.
    pub name: String,
    /// What the command line set over the preset or the rig file, `key=value`.
    pub overridden: Vec<String>,
    /// How the cart is moved: `prescribed` or `recoil`.
    pub cart: String,
    /// Values that look like ones in another unit; none in most rigs.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// Every parameter, by the keys of a rig file.
    pub parameters: Map<String, Value>,
}

/// A file that was read.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InputFile {
    /// Its path as it was given.
    pub file: String,
    /// Length of the file, bytes.
    pub bytes: u64,
    /// CRC-32 of its bytes, hexadecimal.
    pub crc32: String,
}

impl MadeFrom {
    /// Of this program, at this version.
    pub fn this_program() -> Self {
        Self {
            program: "host-sim".to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            ..Self::default()
        }
    }

    /// Replaces the rigs by these.
    #[must_use]
    pub fn with_rigs<'a>(mut self, rigs: impl IntoIterator<Item = &'a NamedRig>) -> Self {
        self.rigs = rigs.into_iter().map(RigUsed::from).collect();
        self
    }
}

impl From<&NamedRig> for RigUsed {
    fn from(rig: &NamedRig) -> Self {
        let cart = match rig.params.cart {
            CartDrive::Prescribed => "prescribed",
            CartDrive::Loop(_) => "recoil",
        };
        let parameters = rigfile::parameters_of(&rig.params).into_iter();
        let parameters = parameters.filter_map(|(key, value)| {
            let value = serde_json::to_value(value).ok()?;
            Some((key, value))
        });
        Self {
            name: rig.name.clone(),
            overridden: rig.overridden.clone(),
            cart: cart.to_owned(),
            warnings: rigfile::doubts(&rig.params),
            parameters: parameters.collect(),
        }
    }
}

impl InputFile {
    /// The file at `path`, if there is one and it can be read.
    pub fn at(path: &str) -> Option<Self> {
        use std::io::Read;
        if !std::path::Path::new(path).is_file() {
            return None;
        }
        let mut file = std::fs::File::open(path).ok()?;
        let (mut hash, mut bytes) = (crc32fast::Hasher::new(), 0);
        let mut part = vec![0; 1 << 16];
        loop {
            let n = file.read(&mut part).ok()?;
            if n == 0 {
                break;
            }
            hash.update(&part[..n]);
            bytes += n as u64;
        }
        Some(Self {
            file: path.to_owned(),
            bytes,
            crc32: format!("{:08x}", hash.finalize()),
        })
    }
}
