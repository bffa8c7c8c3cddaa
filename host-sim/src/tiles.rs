//! The tiles of an unfinished map, on disk: so that a run that was cut off goes on, and several share one map.
//!
//! A folder holds `request.txt`, the request the tiles belong to, and one file per tile: eight letters that name
//! the format and its version, then (packed by postcard) the request's fingerprint, the tile's number and its cells,
//! then a CRC-32 over all before it. A file is written under a temporary name and renamed. It is not forced to the
//! disk's surface: one that a power failure leaves damaged is found by its CRC and computed again.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use crc::{CRC_32_ISO_HDLC, CRC_64_XZ, Crc};
use serde::{Deserialize, Serialize};

use files::{UserError, read_bytes, read_text};
use numerics::Error;
use numerics::error::MapError;
use numerics::map::{KERNEL_FINGERPRINT, MapCell, MapRequest, Tiles};

const MAGIC: &[u8; 8] = b"HSTILE01";
const REQUEST: &str = "request.txt";
/// Name of the line with the fingerprint of the sources.
const KERNEL: &str = "kernel";
/// A tile has some hundred cells of some hundred bytes; a file larger than this is none.
const MOST_BYTES: u64 = 64 << 20;
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// A folder of tiles that belong to one request.
#[derive(Debug)]
pub struct Store {
    dir: PathBuf,
    fingerprint: u64,
    lines: String,
}

#[derive(Serialize, Deserialize)]
struct Tile {
    fingerprint: u64,
    index: u64,
    cells: Vec<MapCell>,
}

impl Store {
    /// The folder `dir` for the tiles of `request`; it is not made yet. If it holds the tiles of another request, which
    /// this one never takes for its own, the second value says which part differs.
    ///
    /// # Errors
    /// If the folder cannot be used.
    pub fn open(dir: &Path, request: &MapRequest) -> Result<(Self, Option<String>), UserError> {
        let lines = lines(request);
        let path = dir.join(REQUEST);
        let there = match path.try_exists() {
            Ok(false) => None,
            _ => Some(read_text(&path)?),
        };
        let there = there.filter(|there| *there != lines);
        let another = there.map(|there| another(dir, &there, &lines));
        let store = Self {
            dir: dir.to_owned(),
            fingerprint: Crc::<u64>::new(&CRC_64_XZ).checksum(lines.as_bytes()),
            lines,
        };
        Ok((store, another))
    }

    /// Where the tiles are.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    fn path(&self, index: usize) -> PathBuf {
        self.dir.join(format!("tile-{index:06}.bin"))
    }

    /// After a failure: what was begun and holds no tile goes, so that it is in nobody's way.
    pub fn remove_if_empty(self) {
        let entries = fs::read_dir(&self.dir).into_iter().flatten().flatten();
        let mut names = entries.map(|entry| entry.file_name());
        if !names.any(|name| is_tile(&name.to_string_lossy())) {
            self.remove();
        }
    }

    /// Removes the tiles and, when nothing else is in it, the folder.
    pub fn remove(self) {
        let entries = fs::read_dir(&self.dir).into_iter().flatten().flatten();
        for entry in entries {
            let name = entry.file_name();
            let name = name.to_string_lossy();
            if is_tile(&name) || name == REQUEST || name.starts_with(files::write::TEMPORARY) {
                // What is left costs room and nothing else.
                let _ = fs::remove_file(entry.path());
            }
        }
        let _ = fs::remove_dir(&self.dir);
    }
}

impl Tiles for Store {
    /// Makes the folder and says in it whose tiles these will be.
    fn begin(&self) -> Result<(), Error> {
        let written = files::write::write(self.dir.join(REQUEST), &self.lines);
        written.map(drop).map_err(kept)
    }

    fn read(&self, index: usize, cells: usize) -> Option<Vec<MapCell>> {
        let bytes = read_bytes(&self.path(index), MOST_BYTES).ok()?;
        let (content, crc) = bytes.split_last_chunk::<4>()?;
        if CRC.checksum(content) != u32::from_le_bytes(*crc) {
            return None;
        }
        let tile: Tile = postcard::from_bytes(content.strip_prefix(MAGIC)?).ok()?;
        let ours = tile.fingerprint == self.fingerprint && tile.index == index as u64;
        (ours && tile.cells.len() == cells).then_some(tile.cells)
    }

    fn write(&self, index: usize, cells: &[MapCell]) -> Result<(), Error> {
        let tile = Tile {
            fingerprint: self.fingerprint,
            index: index as u64,
            cells: cells.to_vec(),
        };
        let mut bytes = postcard::to_extend(&tile, MAGIC.to_vec()).map_err(kept)?;
        bytes.extend(CRC.checksum(&bytes).to_le_bytes());
        files::write::write_unsynced(self.path(index), bytes).map_err(kept)
    }
}

/// A tile that could not be kept, with the words of whoever refused it.
fn kept(error: impl std::fmt::Display) -> Error {
    MapError::Store(error.to_string()).into()
}

fn is_tile(name: &str) -> bool {
    name.starts_with("tile-") && name.ends_with(".bin")
}

/// The request as text, a line for each part of it, and first the sources that compute the cells. Numbers are exact.
fn lines(request: &MapRequest) -> String {
    let mut text = format!("{KERNEL} {KERNEL_FINGERPRINT}\n");
    let parts: [(&str, &dyn std::fmt::Debug); 8] = [
        ("rig", &request.params_at(0.0)),
        ("gaps_mm", &request.grid.gaps_mm),
        ("frequencies_hz", &request.grid.frequencies_hz),
        ("engine", &request.runner),
        ("cycles", &(request.plan.cycles, request.plan.recorded)),
        ("settle", &request.settle),
        ("from", &request.from),
        ("tile_cells", &request.tile_cells()),
    ];
    for (name, value) in parts {
        let _ = writeln!(text, "{name} {value:?}");
    }
    text
}

/// The tiles belong to another request: says which part of it differs.
fn another(dir: &Path, there: &str, ours: &str) -> String {
    let whole = there.ends_with('\n') && there.lines().count() == ours.lines().count();
    let name = |line: &str| line.split(' ').next().unwrap_or_default().to_owned();
    let differs = there.lines().zip(ours.lines()).find(|(a, b)| a != b);
    let Some((a, b)) = differs.filter(|(a, b)| whole && name(a) == name(b)) else {
        return format!(
            "{} is damaged, so it cannot be known whose tiles these are",
            dir.join(REQUEST).display()
        );
    };
    if name(a) == KERNEL {
        return format!(
            "{} holds an unfinished map begun by another version of this program, whose cells may differ",
            dir.display()
        );
    }
    let what = if a.len() + b.len() < 120 {
        let value = |line: &str| line[name(line).len()..].trim().to_owned();
        format!("{} {} where this one has {}", name(a), value(a), value(b))
    } else {
        format!("another {}", name(a))
    };
    format!("{} holds an unfinished map with {what}", dir.display())
}

#[cfg(test)]
mod tests {
    use super::*;
    use numerics::NamedRig;
    use numerics::lanes::CellPlan;
    use numerics::map::{Grid, Runner};
    use numerics::sweep::Direction;
    use shared::model::params::WIRES;

    #[test]
    fn tiles_of_another_version_are_told_in_one_clear_line() {
        let request = MapRequest {
            rig: NamedRig::new("wires", WIRES),
            grid: Grid {
                gaps_mm: vec![0.0, 1.0],
                frequencies_hz: vec![3.0, 4.0],
            },
            runner: Runner::Lanes,
            plan: CellPlan::CHAPTER,
            settle: None,
            from: Direction::Rest,
        };
        let folder = tempfile::tempdir().unwrap();
        let dir = folder.path();
        Store::open(dir, &request).unwrap().0.begin().unwrap();
        assert_eq!(Store::open(dir, &request).unwrap().1, None);
        let ours = fs::read_to_string(dir.join(REQUEST)).unwrap();
        assert!(ours.starts_with(&format!("{KERNEL} {KERNEL_FINGERPRINT}\n")));
        let other = ours.replace(KERNEL_FINGERPRINT, "0123456789abcdef");
        fs::write(dir.join(REQUEST), other).unwrap();
        let (_, told) = Store::open(dir, &request).unwrap();
        let told = told.unwrap();
        assert!(told.contains("another version of this program"), "{told}");
        assert_eq!(told.lines().count(), 1);
    }
}
