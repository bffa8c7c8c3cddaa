//! The rows of an unfinished answer, on disk: so that a run that was cut off goes on where it was.
//!
//! One file: eight letters that name the format, then (packed by postcard) the request and the rows, then a CRC-32 over
//! all before it. It is written under a temporary name and renamed after each row. A file of another request, of another
//! program, or a damaged one is as good as none.

use std::fs;
use std::path::PathBuf;
use std::sync::OnceLock;

use crc::{CRC_32_ISO_HDLC, CRC_64_XZ, Crc};
use serde::Serialize;
use serde::de::DeserializeOwned;

use files::{UserError, read_bytes};

const MAGIC: &[u8; 8] = b"HSROWS01";
/// A row has some hundred bytes, and there are a hundred thousand at most.
const MOST_BYTES: u64 = 256 << 20;
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// The rows that are done.
#[derive(Debug)]
pub struct Kept<T> {
    /// Where they are kept; nowhere without an output folder.
    path: Option<PathBuf>,
    request: String,
    rows: Vec<T>,
}

impl<T: Serialize + DeserializeOwned> Kept<T> {
    /// Those in the file at `path`, if it is of this `request` and this very program; else none.
    ///
    /// # Errors
    /// If this program's own file cannot be read.
    pub fn open(path: Option<PathBuf>, request: &str) -> Result<Self, UserError> {
        let request = format!("{} {request}", this_program()?);
        let rows = path.as_ref().and_then(|path| {
            let bytes = read_bytes(path, MOST_BYTES).ok()?;
            let (content, crc) = bytes.split_last_chunk::<4>()?;
            let content = content.strip_prefix(MAGIC)?;
            let whole = CRC.checksum(content) == u32::from_le_bytes(*crc);
            let (theirs, rows): (String, Vec<T>) = postcard::from_bytes(content).ok()?;
            (whole && theirs == request).then_some(rows)
        });
        Ok(Self {
            path,
            request,
            rows: rows.unwrap_or_default(),
        })
    }

    /// The rows, in the order they came.
    pub fn rows(&self) -> &[T] {
        &self.rows
    }

    /// Adds a row.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn push(&mut self, row: T) -> Result<(), UserError> {
        self.rows.push(row);
        let Some(path) = &self.path else {
            return Ok(());
        };
        let packed = postcard::to_stdvec(&(&self.request, &self.rows));
        let content = packed.map_err(|e| UserError::new(format!("cannot keep rows: {e}")))?;
        let crc = CRC.checksum(&content).to_le_bytes();
        let bytes = [MAGIC, content.as_slice(), &crc].concat();
        Ok(files::write::write_unsynced(path, bytes)?)
    }

    /// Removes the file, and gives the rows.
    pub fn finish(self) -> Vec<T> {
        if let Some(path) = &self.path {
            // What is left costs room and nothing else.
            let _ = fs::remove_file(path);
        }
        self.rows
    }
}

/// This very program: version, and CRC-64 of its file.
///
/// # Errors
/// The file cannot be read.
pub fn this_program() -> Result<String, UserError> {
    // The file is large, and stays the same while it runs.
    static PROGRAM: OnceLock<Result<String, String>> = OnceLock::new();
    let read = || {
        let program = std::env::current_exe().and_then(fs::read);
        let program = program.map_err(|e| {
            format!(
                "cannot read this program's own file to tell its version: {e}; start it by its path"
            )
        })?;
        let version = env!("CARGO_PKG_VERSION");
        Ok(format!("host-sim {version} {}", checksum(&program)))
    };
    PROGRAM.get_or_init(read).clone().map_err(UserError::new)
}

/// CRC-64 of `bytes`, hexadecimal.
pub fn checksum(bytes: &[u8]) -> String {
    format!("{:016x}", Crc::<u64>::new(&CRC_64_XZ).checksum(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_back_for_the_same_request_alone_and_damage_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows");
        let open = |request: &str| Kept::<f64>::open(Some(path.clone()), request).unwrap();
        let mut kept = open("a");
        assert!(kept.rows().is_empty());
        for row in [0.1, 0.3 - 0.2] {
            kept.push(row).unwrap();
        }
        assert_eq!(open("a").rows(), [0.1, 0.3 - 0.2]);
        assert!(open("b").rows().is_empty());
        let whole = fs::read(&path).unwrap();
        for i in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[i] ^= 0x10;
            fs::write(&path, bytes).unwrap();
            assert!(open("a").rows().is_empty(), "byte {i}");
        }
        fs::write(&path, &whole).unwrap();
        assert_eq!(open("a").finish(), [0.1, 0.3 - 0.2]);
        assert!(!path.exists());
    }
}
