//! Writing files whole or not at all.
//!
//! A file is written under a temporary name beside its final place and then renamed, so a reader never meets half of
//! it and a failure leaves the old one untouched. A program that is killed leaves its temporary files.

use std::fmt;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

use crate::UserError;

#[cfg(test)]
mod tests;

/// Files that have their names.
#[derive(Debug)]
pub struct Written {
    /// Where they are, in the order given.
    pub paths: Vec<PathBuf>,
    /// Whether a file or a link of one of the names was there before.
    pub replaced: bool,
}

/// Why a file was not written: what, where, and how to mend it.
#[derive(Debug)]
pub struct WriteError {
    /// The file or folder that could not be made.
    pub path: PathBuf,
    /// What the operating system said.
    pub source: io::Error,
}

impl fmt::Display for WriteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mend = match self.source.kind() {
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
                "choose a folder you may write to"
            }
            io::ErrorKind::FileTooLarge => {
                "the system limits the size of a file here (ulimit -f): raise the limit or write elsewhere"
            }
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
                "free some space or choose another folder"
            }
            io::ErrorKind::NotADirectory | io::ErrorKind::AlreadyExists => {
                "a file stands where a folder is needed: choose another folder"
            }
            io::ErrorKind::IsADirectory => "move it away or write elsewhere",
            io::ErrorKind::InvalidInput => "choose another file name",
            _ => "check the path and try again",
        };
        let path = self.path.display();
        let source = self.source.to_string();
        // The temporary name is no business of the reader's.
        let source = match source.split_once(" at path ") {
            Some((why, name)) if name.contains(TEMPORARY) => why,
            _ => &source,
        };
        write!(f, "cannot write {path}: {source}; {mend}")
    }
}

impl std::error::Error for WriteError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.source)
    }
}

impl From<WriteError> for UserError {
    fn from(error: WriteError) -> Self {
        Self::new(error.to_string())
    }
}

/// Writes `bytes` as the file `path`; makes the folder. Returns whether it replaced one.
///
/// A link of that name is replaced, not what it points to. On Unix the new file gets
/// the permissions a plainly created one would (`0666` less the umask).
///
/// # Errors
/// [`WriteError`]; nothing is left behind then, and an older file stays as it was.
pub fn write(path: impl AsRef<Path>, bytes: impl AsRef<[u8]>) -> Result<bool, WriteError> {
    Ok(commit_all(vec![prepare(path.as_ref(), bytes.as_ref())?])?.replaced)
}

/// Writes `bytes` as the file `path` if nothing is there; makes the folder. It appears whole.
///
/// # Errors
/// [`WriteError`], also when something is there: that stays as it was.
pub fn write_new(path: impl AsRef<Path>, bytes: impl AsRef<[u8]>) -> Result<(), WriteError> {
    let path = path.as_ref();
    if path.symlink_metadata().is_ok() {
        return Err(invalid(
            path.to_owned(),
            "it exists already and is not replaced",
        ));
    }
    let Staged { file, .. } = prepare(path, bytes.as_ref())?;
    let kept = file.persist_noclobber(path);
    kept.map(drop).map_err(|e| failed(path, e.error))
}

/// Writes as [`write()`] does, without a sync: for files that can be computed again if a power failure damages them.
///
/// # Errors
/// As [`write()`].
pub fn write_unsynced(path: impl AsRef<Path>, bytes: impl AsRef<[u8]>) -> Result<(), WriteError> {
    let mut staged = Staged::new(path)?;
    let written = staged.write_all(bytes.as_ref());
    written.map_err(|source| failed(&staged.path, source))?;
    staged.rename().map(drop)
}

/// Writes the files of one answer into `dir`: `(name, bytes)` each.
///
/// See [`commit_all`].
///
/// # Errors
/// [`WriteError`], also when a name is not a plain file name or comes twice.
pub fn write_all<N, B>(dir: impl AsRef<Path>, files: &[(N, B)]) -> Result<Written, WriteError>
where
    N: AsRef<str>,
    B: AsRef<[u8]>,
{
    commit_all(stage_all(dir, files)?)
}

/// Writes the files of one answer under temporary names: `(name, bytes)` each.
///
/// # Errors
/// [`WriteError`], also when a name is not a plain file name or comes twice; nothing is left then.
pub fn stage_all<N, B>(dir: impl AsRef<Path>, files: &[(N, B)]) -> Result<Vec<Staged>, WriteError>
where
    N: AsRef<str>,
    B: AsRef<[u8]>,
{
    let dir = dir.as_ref();
    let mut ready: Vec<Staged> = Vec::with_capacity(files.len());
    for (name, bytes) in files {
        let path = dir.join(name.as_ref());
        let plain = Path::new(name.as_ref()).file_name() == Some(name.as_ref().as_ref());
        if !plain {
            return Err(invalid(path, "not a plain file name"));
        }
        if ready.iter().any(|staged| staged.path == path) {
            return Err(invalid(path, "named twice in one answer"));
        }
        ready.push(prepare(&path, bytes.as_ref())?);
    }
    Ok(ready)
}

/// Gives files their names once all are whole; an interrupt waits for the last. The JSON is first: it says whose the
/// files beside it are.
///
/// # Errors
/// [`WriteError`]. A rename that the system refuses after the first leaves some files new and some old, each whole.
pub fn commit_all(mut staged: Vec<Staged>) -> Result<Written, WriteError> {
    for one in &staged {
        one.sync().map_err(|source| failed(&one.path, source))?;
    }
    let paths = staged.iter().map(|one| one.path.clone()).collect();
    staged.sort_by_key(|one| one.path.extension() != Some("json".as_ref()));
    let _all = locked();
    let mut replaced = false;
    for one in staged {
        replaced |= one.rename()?;
    }
    Ok(Written { paths, replaced })
}

/// Checks, before hours of work, that files can be made in the folder `dir`, which need not exist yet. Leaves nothing.
///
/// # Errors
/// [`WriteError`] as writing there would give.
pub fn check_folder(dir: &Path) -> Result<(), WriteError> {
    let there = dir.ancestors().find(|a| a.exists());
    let there = match there {
        Some(there) if !there.as_os_str().is_empty() => there,
        _ => Path::new("."),
    };
    if !there.is_dir() {
        return Err(failed(there, io::ErrorKind::NotADirectory.into()));
    }
    let _staged = locked();
    let tried = temporary_file(there);
    tried.map(drop).map_err(|source| failed(dir, source))
}

/// A file under a temporary name beside its final place, for what is too long to be held in memory. It gets
/// its name when it is committed; dropped before, it is removed.
#[derive(Debug)]
pub struct Staged {
    file: NamedTempFile,
    path: PathBuf,
}

impl Staged {
    /// Begins the file that is to be called `path`; makes its folder.
    ///
    /// # Errors
    /// [`WriteError`], also when a folder or a device stands there.
    pub fn new(path: impl AsRef<Path>) -> Result<Self, WriteError> {
        let path = path.as_ref();
        let dir = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            Some(_) => Path::new("."),
            None => return Err(invalid(path.to_owned(), "not a file name")),
        };
        let made = step().and_then(|()| fs::create_dir_all(dir));
        made.map_err(|source| failed(dir, source))?;
        match fs::symlink_metadata(path) {
            Ok(found) if found.is_dir() => {
                let source = io::Error::new(io::ErrorKind::IsADirectory, "it is a folder");
                return Err(failed(path, source));
            }
            // A device or pipe must not be replaced by a file.
            Ok(found) if !found.is_file() && !found.is_symlink() => {
                return Err(invalid(path.to_owned(), "it is not an ordinary file"));
            }
            _ => {}
        }
        // Locked before the file is there, so that `end` misses none.
        let mut staged = locked();
        let file = temporary_file(dir).map_err(|source| failed(path, source))?;
        staged.push(file.path().to_owned());
        drop(staged);
        Ok(Self {
            file,
            path: path.to_owned(),
        })
    }

    /// The path it will have.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Gives the file its name, replacing what was there; returns its path.
    ///
    /// # Errors
    /// [`WriteError`]; an older file stays as it was then.
    pub fn commit(self) -> Result<PathBuf, WriteError> {
        let path = self.path.clone();
        commit_all(vec![self])?;
        Ok(path)
    }

    fn sync(&self) -> io::Result<()> {
        step()?;
        self.file.as_file().sync_all()
    }

    /// Returns whether something of that name was there.
    fn rename(self) -> Result<bool, WriteError> {
        let Self { file, path } = self;
        let replaced = path.symlink_metadata().is_ok();
        let renamed = match step() {
            Ok(()) => file.persist(&path).map(drop).map_err(|e| e.error),
            Err(error) => Err(error),
        };
        renamed.map_err(|source| failed(&path, source))?;
        Ok(replaced)
    }
}

impl Write for Staged {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        step()?;
        // Past the wrapper that would add the temporary name to an error.
        self.file.as_file_mut().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        step()?;
        self.file.flush()
    }
}

impl io::Seek for Staged {
    fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
        step()?;
        self.file.seek(to)
    }
}

/// Where every file was staged. Names are never used twice.
static STAGED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn locked() -> MutexGuard<'static, Vec<PathBuf>> {
    STAGED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the files that are staged and not committed and ends the program: for one that is to stop at once.
/// No other file is staged meanwhile.
pub fn end(code: i32) -> ! {
    for path in locked().iter() {
        // What was committed is no longer there.
        let _ = fs::remove_file(path);
    }
    std::process::exit(code)
}

fn prepare(path: &Path, bytes: &[u8]) -> Result<Staged, WriteError> {
    let mut staged = Staged::new(path)?;
    staged
        .write_all(bytes)
        .and_then(|()| staged.sync())
        .map_err(|source| failed(path, source))?;
    Ok(staged)
}

/// How the temporary names of files begin that are not whole yet.
pub const TEMPORARY: &str = ".writing-";

/// A new file under a temporary name.
fn temporary_file(dir: &Path) -> io::Result<NamedTempFile> {
    step()?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMPORARY);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(dir).map_err(without_path)
}

/// The system's error alone: the temporary name around it is nothing that a person gave.
fn without_path(error: io::Error) -> io::Error {
    let inner = error.get_ref().and_then(|wrapped| wrapped.source());
    let code = inner.and_then(|inner| inner.downcast_ref::<io::Error>()?.raw_os_error());
    code.map_or(error, io::Error::from_raw_os_error)
}

/// Comes before everything that is asked of the disk. A test can make it fail.
#[cfg(not(test))]
#[inline(always)]
fn step() -> io::Result<()> {
    Ok(())
}

#[cfg(test)]
use tests::faults::step;

fn failed(path: &Path, source: io::Error) -> WriteError {
    WriteError {
        path: path.to_owned(),
        source,
    }
}

fn invalid(path: PathBuf, why: &str) -> WriteError {
    WriteError {
        path,
        source: io::Error::new(io::ErrorKind::InvalidInput, why),
    }
}
