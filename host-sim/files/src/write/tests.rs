use super::*;

/// Faults of the disk, one thread at a time: the n-th thing asked of it fails.
pub(super) mod faults {
    use std::cell::Cell;
    use std::io;

    thread_local! {
        /// How many more steps succeed; none: all do.
        static LEFT: Cell<Option<u32>> = const { Cell::new(None) };
        static TAKEN: Cell<u32> = const { Cell::new(0) };
    }

    pub fn step() -> io::Result<()> {
        TAKEN.set(TAKEN.get() + 1);
        match LEFT.get() {
            Some(0) => Err(io::ErrorKind::StorageFull.into()),
            left => {
                LEFT.set(left.map(|n| n - 1));
                Ok(())
            }
        }
    }

    /// What `run` returns when every step after the first `good` fails, and how many steps it tried.
    pub fn after<T>(good: Option<u32>, run: impl FnOnce() -> T) -> (T, u32) {
        TAKEN.set(0);
        LEFT.set(good);
        let done = run();
        LEFT.set(None);
        (done, TAKEN.get())
    }
}

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
    assert!(!write(&path, "old and longer").unwrap());
    assert!(write(&path, "new").unwrap());
    assert_eq!(fs::read_to_string(&path).unwrap(), "new");
    assert_eq!(names(path.parent().unwrap()), ["force.svg"]);
}

#[cfg(unix)]
#[test]
fn permissions_are_those_of_a_plain_file_and_a_link_is_replaced_not_followed() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let dir = tempfile::tempdir().unwrap();
    let [plain, ours, link] = ["plain", "ours", "link"].map(|name| dir.path().join(name));
    fs::write(&plain, "old").unwrap();
    write(&ours, "").unwrap();
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&ours), mode(&plain));
    for target in [&plain, &dir.path().join("nowhere"), dir.path()] {
        symlink(target, &link).unwrap();
        assert!(write(&link, "new").unwrap());
        assert!(fs::symlink_metadata(&link).unwrap().is_file());
        assert_eq!(fs::read(&link).unwrap(), b"new");
        fs::remove_file(&link).unwrap();
    }
    assert_eq!(fs::read(&plain).unwrap(), b"old");
    assert_eq!(names(dir.path()), ["ours", "plain"]);
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

/// Fails if a path goes through text on its way: then another folder is made.
#[cfg(target_os = "linux")]
#[test]
fn a_path_that_is_not_utf_8_is_kept_byte_for_byte() {
    use std::os::unix::ffi::OsStrExt;
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join(std::ffi::OsStr::from_bytes(b"o\xff"));
    let made = write_all(&out, &[("a.csv", "1")]).unwrap();
    assert_eq!(made.paths, [out.join("a.csv")]);
    assert_eq!(fs::read(out.join("a.csv")).unwrap(), b"1");
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
}

/// A socket stands for all that is no ordinary file: a device would be lost, were the test to fail as root.
#[cfg(unix)]
#[test]
fn what_is_no_ordinary_file_is_not_replaced() {
    use std::os::unix::fs::FileTypeExt;
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("socket");
    let _socket = std::os::unix::net::UnixListener::bind(&path).unwrap();
    let line = write(&path, "x").unwrap_err().to_string();
    assert!(line.contains("it is not an ordinary file"), "{line}");
    assert!(fs::metadata(&path).unwrap().file_type().is_socket());
    assert!(check_folder(&path.join("deep")).is_err());
}

#[cfg(target_os = "linux")]
#[test]
fn a_closed_folder_is_refused() {
    // Nobody may make files here, root included.
    for refused in [
        write("/proc/hammer.csv", "x").unwrap_err(),
        check_folder(Path::new("/proc/hammer")).unwrap_err(),
    ] {
        let line = refused.to_string();
        assert!(line.starts_with("cannot write /proc/hammer"), "{line}");
        assert!(!line.contains(TEMPORARY), "{line}");
    }
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
    let paths = write_all(&out, &files).unwrap().paths;
    assert_eq!(paths, [out.join("z.csv"), out.join("a.png")]);
    assert_eq!(names(&out), ["a.png", "z.csv"]);
    assert_eq!(fs::read(&paths[1]).unwrap(), [0, 255]);
}

/// Runs `act`, first without a fault to count its steps, then with the disk failing at each in turn, in a folder that
/// holds `old`. Either nothing happened or all of it did: `files` are all old or all new, and nothing else is there.
fn at_every_step(files: &[&str], act: impl Fn(&Path) -> Result<(), WriteError>) {
    let fill = |dir: &Path| {
        for name in files {
            fs::write(dir.join(name), format!("old {name}")).unwrap();
        }
    };
    let read = |dir: &Path| -> Vec<_> {
        let bytes = |name: &&str| fs::read(dir.join(name)).unwrap();
        files.iter().map(bytes).collect()
    };
    let folder = tempfile::tempdir().unwrap();
    fill(folder.path());
    let old = read(folder.path());
    let (done, steps) = faults::after(None, || act(folder.path()));
    done.unwrap();
    let new = read(folder.path());
    assert!(steps > 3 && new != old, "{steps} steps");
    for good in 0..steps {
        let folder = tempfile::tempdir().unwrap();
        fill(folder.path());
        let (done, _) = faults::after(Some(good), || act(folder.path()));
        let line = done.unwrap_err().to_string();
        assert!(line.contains("free some space"), "{line}");
        assert_eq!(line.lines().count(), 1, "{line}");
        let left = read(folder.path());
        if files.len() == 1 {
            assert_eq!(left, old, "step {good} of {steps}");
        }
        for (left, (old, new)) in left.iter().zip(old.iter().zip(&new)) {
            assert!(left == old || left == new, "step {good} of {steps}");
        }
        assert_eq!(names(folder.path()), files, "step {good} of {steps}");
    }
}

#[test]
fn a_disk_that_fails_at_any_step_leaves_the_old_file_and_nothing_else() {
    at_every_step(&["a.csv"], |dir| write(dir.join("a.csv"), "new").map(drop));
    at_every_step(&["a.bin"], |dir| write_unsynced(dir.join("a.bin"), "new"));
    at_every_step(&["a.csv", "b.svg", "c.json"], |dir| {
        let files = ["a.csv", "b.svg", "c.json"].map(|name| (name, "new"));
        write_all(dir, &files).map(drop)
    });
    at_every_step(&["run.parquet"], |dir| {
        use crate::columns::{
            Column, ColumnField, ColumnKind, ColumnValue, Packing, ParquetWriter,
        };
        let path = dir.join("run.parquet");
        let field = ColumnField {
            name: "tick".into(),
            kind: ColumnKind::Long,
            optional: false,
            packing: Packing::Differences,
        };
        let mut column = Column::new(&field);
        for tick in 0..10 {
            column.push(Some(ColumnValue::Long(tick))).unwrap();
        }
        let refused = |_| failed(&path, io::ErrorKind::StorageFull.into());
        let staged = Staged::new(&path)?;
        let mut file = ParquetWriter::new(staged, "run", &[field], Vec::new()).map_err(refused)?;
        for _ in 0..3 {
            file.group([&column]).map_err(refused)?;
        }
        file.finish().map_err(refused)?.commit().map(drop)
    });
}
