//! What of a part stands in the folder: written last, so that a record means complete files.

use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::chapter::Statement;
use crate::figures::{Effort, Page, alone};
use crate::kept::{checksum, this_program};
use files::UserError;

/// A part of the figures as it was made.
#[derive(Debug, Deserialize, Serialize)]
pub struct PartRecord {
    /// The program and the effort it was made with.
    pub key: String,
    /// Name of the part.
    pub part: String,
    pub pages: Vec<PageRecord>,
    /// What the chapter says, and whether that is so.
    pub statements: Vec<Statement>,
}

/// A page, its files by name.
#[derive(Debug, Deserialize, Serialize)]
pub struct PageRecord {
    pub figure: String,
    pub title: String,
    pub note: String,
    /// Makes this figure alone, to the same bytes.
    pub command: String,
    /// Makes the like of it for other rigs, gaps and ranges; empty if nothing does.
    pub like: String,
    pub files: Vec<FileRecord>,
}

#[derive(Debug, Deserialize, Serialize)]
pub struct FileRecord {
    pub name: String,
    pub bytes: usize,
    /// CRC-64/XZ of the content, hexadecimal.
    pub crc64: String,
}

impl PartRecord {
    pub fn new(
        (key, effort): (&str, Effort),
        part: &str,
        pages: &[Page],
        statements: Vec<Statement>,
    ) -> Self {
        let file = |(name, bytes): &(String, Vec<u8>)| FileRecord {
            name: name.clone(),
            bytes: bytes.len(),
            crc64: checksum(bytes),
        };
        let page = |page: &Page| PageRecord {
            figure: page.figure.to_owned(),
            title: page.title.clone(),
            note: page.note.clone(),
            command: alone(page.figure, effort),
            like: page.command.clone(),
            files: page.files.iter().map(file).collect(),
        };
        Self {
            key: key.to_owned(),
            part: part.to_owned(),
            pages: pages.iter().map(page).collect(),
            statements,
        }
    }
}

/// What figures depend on: this very program and the effort.
///
/// # Errors
/// The program cannot be read.
pub fn key(effort: Effort) -> Result<String, UserError> {
    Ok(format!("{} {effort:?}", this_program()?))
}

/// Where the record of a part is kept.
pub fn file_name(part: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() { c } else { '-' };
    format!("part-{}.json", part.chars().map(plain).collect::<String>())
}

/// The record of `part`, if it was made with `key` and every file is still as it was written.
pub fn standing(dir: &Path, part: &str, key: &str) -> Option<PartRecord> {
    let text = fs::read_to_string(dir.join(file_name(part))).ok()?;
    let record: PartRecord = serde_json::from_str(&text).ok()?;
    let whole = |file: &FileRecord| {
        fs::read(dir.join(&file.name)).is_ok_and(|bytes| checksum(&bytes) == file.crc64)
    };
    let mut files = record.pages.iter().flat_map(|page| &page.files);
    (record.key == key && record.part == part && files.all(whole)).then_some(record)
}
