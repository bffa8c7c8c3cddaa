//! The archive and the checksums. The same files give the same bytes: names are sorted, all times are one, and no owner is
//! named.

use std::{
    collections::BTreeMap,
    fmt::Write as _,
    fs,
    io::Write as _,
    path::{Path, PathBuf},
};

use flate2::{Compression, GzBuilder};
use sha2::{Digest, Sha256};
use tar::{Builder, EntryType, Header};

use crate::{JobResult, command};

/// What goes into the archive, by its path in there.
#[derive(Debug, Default)]
pub struct Files(BTreeMap<String, File>);

#[derive(Debug)]
struct File {
    bytes: Vec<u8>,
    program: bool,
}

impl Files {
    /// Adds a file of that path.
    pub fn add(&mut self, path: impl Into<String>, bytes: impl Into<Vec<u8>>) {
        self.put(path.into(), bytes.into(), false);
    }

    /// Adds a program of that path.
    pub fn add_program(&mut self, path: impl Into<String>, bytes: impl Into<Vec<u8>>) {
        self.put(path.into(), bytes.into(), true);
    }

    fn put(&mut self, path: String, bytes: Vec<u8>, program: bool) {
        self.0.insert(path, File { bytes, program });
    }

    /// Adds every file below `folder`, below `path`.
    pub fn add_folder(&mut self, path: &str, folder: &Path) -> JobResult {
        for entry in fs::read_dir(folder)? {
            let entry = entry?.path();
            let name = entry.file_name().unwrap_or_default().to_string_lossy();
            let inner = format!("{path}/{name}");
            if entry.is_dir() {
                self.add_folder(&inner, &entry)?;
            } else {
                self.add(inner, fs::read(&entry)?);
            }
        }
        Ok(())
    }

    /// The paths of the files, sorted.
    pub fn paths(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }

    /// The archive, all of it in a folder called `root`, with the time `seconds` since 1970.
    pub fn archive(&self, root: &str, seconds: u64) -> JobResult<Vec<u8>> {
        // 255: no operating system is named.
        let gzip = GzBuilder::new().mtime(0).operating_system(255);
        let mut tar = Builder::new(gzip.write(Vec::new(), Compression::best()));
        for (path, file) in &self.0 {
            let mut header = Header::new_ustar();
            header.set_entry_type(EntryType::Regular);
            header.set_mode(if file.program { 0o755 } else { 0o644 });
            header.set_mtime(seconds);
            header.set_uid(0);
            header.set_gid(0);
            header.set_size(file.bytes.len() as u64);
            tar.append_data(&mut header, format!("{root}/{path}"), &file.bytes[..])?;
        }
        Ok(tar.into_inner()?.finish()?)
    }
}

/// The time that stands in the archive: `SOURCE_DATE_EPOCH` if it is set, else that of the last commit, else the start of
/// 1980, the first that every format can hold.
pub fn time() -> JobResult<u64> {
    if let Ok(text) = std::env::var("SOURCE_DATE_EPOCH") {
        return text
            .parse()
            .map_err(|_| format!("SOURCE_DATE_EPOCH is '{text}', must be a whole number").into());
    }
    let mut git = std::process::Command::new("git");
    git.args(["log", "-1", "--format=%ct"]);
    let commit = command::ask(git.current_dir(command::root()));
    Ok(commit
        .and_then(|text| text.parse().ok())
        .unwrap_or(315_532_800))
}

/// Writes a file beside its place and renames it, so that none is ever there by half.
pub fn write(path: &Path, bytes: &[u8]) -> JobResult {
    let part = PathBuf::from(format!("{}.part", path.display()));
    let written = fs::File::create(&part).and_then(|mut file| {
        file.write_all(bytes)?;
        file.sync_all()?;
        fs::rename(&part, path)
    });
    written.map_err(|error| {
        let _ = fs::remove_file(&part);
        format!("cannot write {}: {error}", path.display()).into()
    })
}

/// A line for each file, as `sha256sum --check` reads it.
pub fn sums(files: &[PathBuf]) -> JobResult<String> {
    let mut text = String::new();
    for file in files {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        for byte in Sha256::digest(fs::read(file)?) {
            write!(text, "{byte:02x}")?;
        }
        writeln!(text, "  {name}")?;
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use flate2::read::GzDecoder;

    use super::*;

    fn two() -> Files {
        let mut files = Files::default();
        files.add_program("bin/b", *b"program");
        files.add("a", *b"text");
        files
    }

    #[test]
    fn the_same_files_give_the_same_bytes_and_come_out_again() {
        let bytes = two().archive("top", 1_000_000_000).unwrap();
        let mut other = Files::default();
        other.add("a", *b"text");
        other.add_program("bin/b", *b"program");
        assert_eq!(bytes, other.archive("top", 1_000_000_000).unwrap());
        assert_ne!(bytes, other.archive("top", 1_000_000_001).unwrap());

        let mut archive = tar::Archive::new(GzDecoder::new(&bytes[..]));
        let mut found = Vec::new();
        for entry in archive.entries().unwrap() {
            let mut entry = entry.unwrap();
            let path = entry.path().unwrap().display().to_string();
            let mode = entry.header().mode().unwrap();
            assert_eq!(entry.header().mtime().unwrap(), 1_000_000_000);
            let mut text = String::new();
            entry.read_to_string(&mut text).unwrap();
            found.push((path, mode, text));
        }
        assert_eq!(
            found,
            [
                ("top/a".into(), 0o644, "text".into()),
                ("top/bin/b".into(), 0o755, "program".into())
            ]
        );
    }

    #[test]
    fn sums_are_what_sha256sum_reads() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("abc.txt");
        write(&file, b"abc").unwrap();
        // The example of FIPS 180-2, appendix B.1.
        assert_eq!(
            sums(&[file]).unwrap(),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad  abc.txt\n"
        );
    }
}
