//! Writing files whole or not at all.
//!
//! A file is first written beside its final place and then renamed, so a
//! reader never meets half of it and a failure leaves the old one untouched.

use std::fmt;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

use crate::UserError;

/// Why a file was not written: what, where, and how to mend it.
#[derive(Debug)]
pub struct WriteError {
    /// The file or folder that could not be made.
    pub path: PathBuf,
    /// What the system answered.
    pub source: io::Error,
}

impl fmt::Display for WriteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mend = match self.source.kind() {
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
                "choose a folder you may write to"
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
        let (path, source) = (self.path.display(), &self.source);
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

/// Writes `bytes` as the file `path`, replacing what was there; makes the folder.
///
/// A link is followed: the file it names is replaced. On Unix the new file gets
/// the permissions a plainly created one would (`0666` less the umask).
///
/// # Errors
/// [`WriteError`]; nothing is left behind then, and an older file stays as it was.
pub fn write(path: impl AsRef<Path>, bytes: impl AsRef<[u8]>) -> Result<(), WriteError> {
    prepare(path.as_ref(), bytes.as_ref())?.commit().map(drop)
}

/// The same for what can be made again when a power failure damages it: nothing is forced to the disk's surface.
///
/// # Errors
/// As [`write()`].
pub fn write_unsynced(path: impl AsRef<Path>, bytes: impl AsRef<[u8]>) -> Result<(), WriteError> {
    let mut staged = Staged::new(path)?;
    let written = staged.write_all(bytes.as_ref());
    written.map_err(|source| failed(&staged.target, source))?;
    let Staged { file, target, .. } = staged;
    match file.persist(&target) {
        Ok(_) => Ok(()),
        Err(refused) => Err(failed(&target, refused.error)),
    }
}

/// Writes the files of one answer into `dir`: `(name, bytes)` each.
///
/// All are written under other names before the first is renamed, so running
/// out of space or a bad name leaves every older file as it was. Only a failure
/// of a rename itself, after all that, can leave some files new and some old.
/// Returns the paths in the order given.
///
/// # Errors
/// [`WriteError`], also when a name is not a plain file name or comes twice.
pub fn write_all<N, B>(dir: impl AsRef<Path>, files: &[(N, B)]) -> Result<Vec<PathBuf>, WriteError>
where
    N: AsRef<str>,
    B: AsRef<[u8]>,
{
    let dir = dir.as_ref();
    let mut ready: Vec<Staged> = Vec::with_capacity(files.len());
    let mut paths: Vec<PathBuf> = Vec::with_capacity(files.len());
    for (name, bytes) in files {
        let path = dir.join(name.as_ref());
        let plain = Path::new(name.as_ref()).file_name() == Some(name.as_ref().as_ref());
        if !plain {
            return Err(invalid(path, "not a plain file name"));
        }
        if paths.contains(&path) {
            return Err(invalid(path, "named twice in one answer"));
        }
        ready.push(prepare(&path, bytes.as_ref())?);
        paths.push(path);
    }
    for staged in ready {
        staged.commit()?;
    }
    Ok(paths)
}

/// Whether files can be made in the folder `dir`, which need not exist yet: asked before hours of work. Leaves nothing.
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
    let tried = passing_file(there);
    tried.map(drop).map_err(|source| failed(dir, source))
}

/// A file under a passing name beside its final place, for what is too long to be held in memory. It gets
/// its name when it is committed; dropped before, it is removed.
#[derive(Debug)]
pub struct Staged {
    file: NamedTempFile,
    /// As it was asked for, and where that is once links are followed.
    path: PathBuf,
    target: PathBuf,
}

impl Staged {
    /// Begins the file that is to be called `path`; makes its folder.
    ///
    /// # Errors
    /// [`WriteError`], also when a folder or a device stands there.
    pub fn new(path: impl AsRef<Path>) -> Result<Self, WriteError> {
        let path = path.as_ref();
        let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let dir = match target.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            Some(_) => Path::new("."),
            None => return Err(invalid(target, "not a file name")),
        };
        fs::create_dir_all(dir).map_err(|source| failed(dir, source))?;
        match fs::metadata(&target) {
            Ok(found) if found.is_dir() => {
                let source = io::Error::new(io::ErrorKind::IsADirectory, "it is a folder");
                return Err(failed(path, source));
            }
            // A device or pipe must not be replaced by a file.
            Ok(found) if !found.is_file() => {
                return Err(invalid(target, "it is not an ordinary file"));
            }
            _ => {}
        }
        // Locked before the file is there, so that `end` misses none.
        let mut staged = locked();
        let file = passing_file(dir).map_err(|source| failed(path, source))?;
        staged.push(file.path().to_owned());
        drop(staged);
        Ok(Self {
            file,
            path: path.to_owned(),
            target,
        })
    }

    /// The path it will have, as it was asked for.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Gives the file its name, replacing what was there; returns its path as it was asked for.
    ///
    /// # Errors
    /// [`WriteError`]; an older file stays as it was then.
    pub fn commit(self) -> Result<PathBuf, WriteError> {
        let Self { file, path, target } = self;
        let synced = file.as_file().sync_all();
        synced.map_err(|source| failed(&target, source))?;
        match file.persist(&target) {
            Ok(_) => Ok(path),
            Err(refused) => Err(failed(&target, refused.error)),
        }
    }
}

impl Write for Staged {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl io::Seek for Staged {
    fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

/// Where every file was staged. Names are never used twice.
static STAGED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn locked() -> MutexGuard<'static, Vec<PathBuf>> {
    STAGED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the files that are staged and not committed and ends the program: for one that is told to stop at once.
/// No other file is staged meanwhile.
pub fn end(code: i32) -> ! {
    let staged = locked();
    for path in staged.iter() {
        // What was committed is no longer there.
        let _ = fs::remove_file(path);
    }
    std::process::exit(code)
}

fn prepare(path: &Path, bytes: &[u8]) -> Result<Staged, WriteError> {
    let mut staged = Staged::new(path)?;
    staged
        .write_all(bytes)
        .and_then(|()| staged.file.as_file().sync_all())
        .map_err(|source| failed(path, source))?;
    Ok(staged)
}

/// How the names of files begin that are not whole yet.
pub const PASSING: &str = ".writing-";

fn passing_file(dir: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PASSING);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
        builder.tempfile_in(dir)
    }
    #[cfg(not(unix))]
    builder.tempfile_in(dir)
}

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

#[cfg(test)]
mod tests {
    use super::*;

    fn names(dir: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(dir)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn writes_replaces_and_makes_folders() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a/b/force.svg");
        write(&path, "old and longer").unwrap();
        write(&path, "new").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(names(path.parent().unwrap()), ["force.svg"]);
    }

    #[cfg(unix)]
    #[test]
    fn permissions_are_those_of_a_plain_file_and_links_survive() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().unwrap();
        let [plain, ours, link] = ["plain", "ours", "link"].map(|name| dir.path().join(name));
        fs::write(&plain, "").unwrap();
        write(&ours, "").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
        std::os::unix::fs::symlink(&ours, &link).unwrap();
        write(&link, "through").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&ours).unwrap(), "through");
    }

    #[test]
    fn a_folder_in_the_way_is_refused_without_a_trace() {
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir(dir.path().join("taken")).unwrap();
        let error = write(dir.path().join("taken"), "x")
            .unwrap_err()
            .to_string();
        assert!(error.contains("taken: it is a folder"), "{error}");
        assert!(error.ends_with("write elsewhere"), "{error}");
        assert_eq!(names(dir.path()), ["taken"]);
        assert!(names(&dir.path().join("taken")).is_empty());
    }

    #[test]
    fn a_file_in_place_of_the_folder_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("out"), "keep").unwrap();
        for path in ["out/a.csv", "out/deep/a.csv"] {
            let error = write(dir.path().join(path), "x").unwrap_err().to_string();
            assert!(error.contains("choose another folder"), "{error}");
        }
        assert_eq!(fs::read(dir.path().join("out")).unwrap(), b"keep");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn devices_and_closed_folders_are_refused() {
        assert!(write("/dev/null", "x").is_err());
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
        // Nobody may make files here, root included.
        assert!(write("/proc/hammer.csv", "x").is_err());
        assert!(check_folder(Path::new("/proc/hammer")).is_err());
        assert!(check_folder(Path::new("/dev/null/deep")).is_err());
    }

    #[test]
    fn a_folder_is_asked_before_it_is_needed() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("file"), "keep").unwrap();
        assert!(check_folder(&dir.path().join("new/deep")).is_ok());
        let error = check_folder(&dir.path().join("file/deep")).unwrap_err();
        assert!(error.to_string().contains("choose another folder"));
        assert_eq!(names(dir.path()), ["file"]);
    }

    #[test]
    fn one_bad_file_of_an_answer_spoils_none() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("a.csv"), "old").unwrap();
        fs::create_dir(dir.path().join("b.svg")).unwrap();
        assert!(write_all(dir.path(), &[("a.csv", "new"), ("b.svg", "x")]).is_err());
        for bad in ["../escape", "sub/file", "", "."] {
            assert!(write_all(dir.path(), &[("a.csv", "new"), (bad, "x")]).is_err());
        }
        assert!(write_all(dir.path(), &[("a.csv", "1"), ("a.csv", "2")]).is_err());
        assert_eq!(fs::read_to_string(dir.path().join("a.csv")).unwrap(), "old");
        assert_eq!(names(dir.path()), ["a.csv", "b.svg"]);
    }

    #[test]
    fn a_staged_file_has_no_name_until_it_is_whole() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("run.parquet");
        let mut staged = Staged::new(&path).unwrap();
        staged.write_all(b"half").unwrap();
        assert!(!path.exists());
        drop(staged);
        assert!(names(dir.path()).is_empty());
        let mut staged = Staged::new(&path).unwrap();
        staged.write_all(b"whole").unwrap();
        staged.commit().unwrap();
        assert_eq!(names(dir.path()), ["run.parquet"]);
    }

    #[test]
    fn a_whole_answer_is_written_in_order() {
        let dir = tempfile::tempdir().unwrap();
        let out = dir.path().join("answer");
        let files = [("z.csv", b"1".to_vec()), ("a.png", vec![0, 255])];
        let paths = write_all(&out, &files).unwrap();
        assert_eq!(paths, [out.join("z.csv"), out.join("a.png")]);
        assert_eq!(names(&out), ["a.png", "z.csv"]);
        assert_eq!(fs::read(&paths[1]).unwrap(), [0, 255]);
    }
}
