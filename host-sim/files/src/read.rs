//! Reading files, within bounds: no file, however large, endless or strange, takes all memory or all time.

use std::fs::{File, FileType, Metadata};
use std::io::{self, Read};
use std::path::Path;

use crate::UserError;

/// Most bytes of a file that a person writes: rigs, scenarios, settings. The longest that comes with the program has
/// 4 kB; what a parser makes of a file has a hundred times its size.
pub const MOST_TEXT: u64 = 1 << 20;

/// Most bytes of a table: ten minutes of three sensors at 20 kHz have half of it.
pub const MOST_TABLE: u64 = 1 << 30;

/// The text of the file `path`, of at most `MOST_TEXT` bytes. A shell's `<(command)` is read to its end; a pipe with a
/// name of its own, which may never have a writer, and a device are refused.
///
/// # Errors
/// There is no such file, it is a folder, a pipe or a device, too large, or not UTF-8.
pub fn read_text(path: &Path) -> Result<String, UserError> {
    read_text_of(path, MOST_TEXT)
}

/// The text of a table, a file of at most `MOST_TABLE` bytes: in UTF-8, in UTF-16 with its mark, or in Latin-1, as
/// instruments and spreadsheets write it. The error names the kind of a known file that is no text, such as a MAT file.
///
/// # Errors
/// There is no such file, it is a folder or a device, too large, or no text.
pub fn read_table(path: &Path) -> Result<String, UserError> {
    let bytes = read_bytes(path, MOST_TABLE)?;
    if let Some((_, kind)) = NO_TABLES.iter().find(|(start, _)| bytes.starts_with(start)) {
        let what = format!("it is {kind}");
        let mend = "write it as CSV: docs/recordings.md has the lines of Python for it";
        return Err(cannot(path, &what, mend));
    }
    table_text(bytes).ok_or_else(|| cannot(path, &"it is no text", "give a CSV file"))
}

/// The text in UTF-8, UTF-16 with a byte order mark, or Latin-1. None if it can be neither.
fn table_text(bytes: Vec<u8>) -> Option<String> {
    let wide = |order: fn([u8; 2]) -> u16| {
        let (units, odd) = bytes[2..].as_chunks();
        let units = units.iter().map(|unit| order(*unit));
        let text = char::decode_utf16(units).collect::<Result<_, _>>();
        text.ok().filter(|_| odd.is_empty())
    };
    match bytes[..] {
        [0xff, 0xfe, ..] => return wide(u16::from_le_bytes),
        [0xfe, 0xff, ..] => return wide(u16::from_be_bytes),
        _ => {}
    }
    let latin = |bytes: Vec<u8>| {
        let is_text = |byte: &u8| *byte >= b' ' || byte.is_ascii_whitespace();
        let text = bytes.iter().all(is_text);
        // The first 256 characters of Unicode are those of Latin-1.
        text.then(|| bytes.into_iter().map(char::from).collect())
    };
    String::from_utf8(bytes)
        .or_else(|e| latin(e.into_bytes()).ok_or(()))
        .ok()
}

/// How files begin that people have in place of a CSV.
const NO_TABLES: &[(&[u8], &str)] = &[
    (b"MATLAB 5.0 MAT-file", "a MAT file"),
    (
        b"\x89HDF\r\n\x1a\n",
        "an HDF5 file (or a MAT file of version 7.3)",
    ),
    (b"TDSm", "a TDMS file"),
    (b"PK\x03\x04", "a workbook or a zip file"),
    (b"\x0f\x0f:WFM#", "a WFM file"),
    (b"\xf0\xf0:WFM#", "a WFM file"),
    (
        b"PAR1",
        "a Parquet file whose name does not end in .parquet",
    ),
];

/// Opens the ordinary file `path`, for what is not read in one go.
///
/// # Errors
/// There is no such file, or it is a folder, a pipe or a device.
pub fn open_file(path: &Path) -> Result<File, UserError> {
    let found = path
        .metadata()
        .map_err(|e| cannot(path, &e, "check the path"))?;
    if !found.is_file() {
        let what = kind(found.file_type());
        return Err(cannot(path, &what, "give an ordinary file"));
    }
    File::open(path).map_err(|e| cannot(path, &e, "check the path"))
}

/// The number, from 1, of the line of `text` in which this byte is.
pub fn line_at(text: &str, byte: usize) -> usize {
    let before = text.as_bytes().iter().take(byte);
    before.filter(|byte| **byte == b'\n').count() + 1
}

fn read_text_of(path: &Path, most: u64) -> Result<String, UserError> {
    String::from_utf8(read_bytes(path, most)?)
        .map_err(|_| cannot(path, &"it is not UTF-8 text", "save it as UTF-8 text"))
}

/// The bytes of the file or pipe `path`, of which there may be `most`.
///
/// # Errors
/// There is no such file, it is a folder or a device, or too large.
pub fn read_bytes(path: &Path, most: u64) -> Result<Vec<u8>, UserError> {
    let check = |e: io::Error| cannot(path, &e, "check the path");
    let found = path.metadata().map_err(check)?;
    if !is_readable(path, &found) {
        let what = kind(found.file_type());
        return Err(cannot(path, &what, "give a file"));
    }
    let too_large = || {
        let what = format!("it has more than {} MB", most >> 20);
        cannot(path, &what, "is it the right file?")
    };
    if found.len() > most {
        return Err(too_large());
    }
    let mut bytes = Vec::new();
    // A file's length may change while it is read, and a pipe has none.
    let mut rest = File::open(path).map_err(check)?.take(most + 1);
    rest.read_to_end(&mut bytes).map_err(check)?;
    if bytes.len() as u64 > most {
        return Err(too_large());
    }
    Ok(bytes)
}

/// The pipe of a shell's `<(command)` is below `/dev` or `/proc`, and somebody writes into it.
#[cfg(unix)]
fn is_readable(path: &Path, found: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    let by_a_shell = path.starts_with("/dev") || path.starts_with("/proc");
    found.is_file() || found.file_type().is_fifo() && by_a_shell
}

#[cfg(not(unix))]
fn is_readable(_: &Path, found: &Metadata) -> bool {
    found.is_file()
}

fn kind(of: FileType) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if of.is_fifo() {
            return "it is a pipe";
        }
        if of.is_char_device() || of.is_block_device() {
            return "it is a device";
        }
    }
    if of.is_dir() {
        "it is a folder"
    } else {
        "it is not an ordinary file"
    }
}

fn cannot(path: &Path, why: &dyn std::fmt::Display, mend: &str) -> UserError {
    UserError::new(format!("cannot read {}: {why}; {mend}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_up_to_its_limit_and_not_beyond() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.toml");
        std::fs::write(&path, "12345").unwrap();
        assert_eq!(read_text_of(&path, 5).unwrap(), "12345");
        let line = read_text_of(&path, 4).unwrap_err().to_string();
        assert!(line.contains("a.toml: it has more than"), "{line}");
        std::fs::write(&path, b"\xff").unwrap();
        let line = read_text(&path).unwrap_err().to_string();
        assert!(line.contains("UTF-8"), "{line}");
        for read in [read_text(dir.path()).err(), open_file(dir.path()).err()] {
            assert!(read.unwrap().to_string().contains("it is a folder"));
        }
    }

    #[test]
    fn a_table_is_read_in_the_letters_of_instruments_and_spreadsheets() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("scope.csv");
        let text = "Time (µs);Force (N)\r\n0;1,5\r\n";
        let wide = |order: fn(u16) -> [u8; 2]| -> Vec<u8> {
            let marked = format!("\u{feff}{text}");
            marked.encode_utf16().flat_map(order).collect()
        };
        let latin: Vec<u8> = text.chars().map(|c| u8::try_from(c).unwrap()).collect();
        for bytes in [
            text.as_bytes().to_vec(),
            latin,
            wide(u16::to_le_bytes),
            wide(u16::to_be_bytes),
        ] {
            std::fs::write(&path, bytes).unwrap();
            assert_eq!(read_table(&path).unwrap(), text);
        }
        let torn = &wide(u16::to_le_bytes)[..21];
        for bytes in [
            torn,
            b"\xff\xfe\x00\xd8",
            b"\xb5\x00\x01",
            b"\xfe\xff\xdc\x00",
        ] {
            std::fs::write(&path, bytes).unwrap();
            let line = read_table(&path).unwrap_err().to_string();
            assert!(line.ends_with("it is no text; give a CSV file"), "{line}");
        }
    }

    /// Waits for ever if the pipe is opened.
    #[cfg(unix)]
    #[test]
    fn a_pipe_without_a_writer_and_a_socket_are_refused_at_once() {
        let dir = tempfile::tempdir().unwrap();
        let [pipe, socket] = ["pipe", "socket"].map(|name| dir.path().join(name));
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        let _socket = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        for (path, what) in [(&pipe, "it is a pipe"), (&socket, "not an ordinary file")] {
            for read in [read_text(path).err(), read_table(path).err()] {
                let line = read.unwrap().to_string();
                assert!(line.contains(what), "{line}");
            }
        }
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_refused_and_an_endless_pipe_ends_at_the_limit() {
        for device in ["/dev/zero", "/dev/null"].map(Path::new) {
            for read in [read_text(device).err(), open_file(device).err()] {
                let line = read.expect("a device is refused").to_string();
                assert!(line.contains("it is a device"), "{line}");
            }
        }
        // What a shell's `<(yes)` gives.
        let mut yes = std::process::Command::new("yes")
            .stdout(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        let pipe = yes.stdout.take().unwrap();
        let path = format!("/dev/fd/{}", std::os::fd::AsRawFd::as_raw_fd(&pipe));
        let line = read_text(Path::new(&path)).unwrap_err().to_string();
        assert!(line.contains("more than 1 MB"), "{line}");
        let line = open_file(Path::new(&path)).unwrap_err().to_string();
        assert!(line.contains("it is a pipe"), "{line}");
        yes.kill().unwrap();
        yes.wait().unwrap();
    }
}
