//! `host-sim map` in tiles: cut up, interrupted and put together.

use std::fs;
use std::process::{Child, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::map::{outputs, run, tiles};
use crate::support::{Folder, wait};

#[test]
fn threads_and_tiles_do_not_change_a_byte() {
    let whole = Folder::new();
    // Slow engines have small tiles: 6 × 50 cells are three.
    let line = "map --gap 0:2.5:0.5 --ratio 1:3.45:0.05 --cycles 20 --reference --format text";
    run(&whole, &format!("{line} --quiet --out o --threads 1"));
    let expected = outputs(&whole);
    assert_eq!(expected.len(), 6);
    let split = Folder::new();
    for share in ["2/2", "1/2"] {
        let said = split.run(&format!("{line} --out o --tiles {share}")).well();
        assert!(said.err.contains("--merge"), "{said:?}");
        assert!(outputs(&split).is_empty());
    }
    assert_eq!(tiles(&split), 3);
    run(
        &split,
        &format!("{line} --quiet --out o --merge --threads 2"),
    );
    assert_eq!(outputs(&split), expected);
    assert_eq!(tiles(&split), 0);
}

/// Tiles that are missing, of another map, or damaged.
#[test]
fn tiles_that_do_not_serve_are_told_or_made_again() {
    let rig = |mass_kg: f64| format!("preset = \"wires\"\nmass_kg = {mass_kg}\n");
    let folder = Folder::new().with("mine.toml", rig(0.3));
    let line =
        "map --rig mine.toml --gap 0:2.5:0.5 --ratio 1:3.45:0.05 --reference --format text --out o";
    run(&folder, &format!("{line} --cycles 20 --quiet --tiles 0..2"));
    let refused = |extra: &str, says: &[&str]| {
        let before = folder.names();
        let ran = folder.run(&format!("{line} {extra}"));
        assert_eq!(ran.code, Some(2), "{ran:?}");
        assert_eq!(ran.err.lines().count(), 1, "{ran:?}");
        assert!(says.iter().all(|s| ran.err.contains(s)), "{ran:?}");
        assert_eq!(folder.names(), before);
    };
    refused("--cycles 20 --merge", &["1 of 3 tiles missing", ": 2..3;"]);
    refused("--cycles 20 --tiles 2..4", &["the map has tiles 0..3"]);
    let names = folder.names();
    let request = names.iter().find(|name| name.ends_with("/request.txt"));
    let request = folder.path(request.expect("the request"));
    let told = fs::read(&request).expect("the request");
    fs::write(&request, &told[..10]).expect("the request");
    refused("--cycles 20 --merge", &["request.txt is damaged"]);
    fs::write(&request, told).expect("the request");
    // The rig file was edited: shares of the other rig stay, and a map alone takes none of them.
    let folder = folder.with("mine.toml", rig(0.31));
    let refused = |extra: &str, says: &[&str]| {
        let ran = folder.run(&format!("{line} {extra}"));
        assert_eq!(ran.code, Some(2), "{ran:?}");
        assert!(says.iter().all(|s| ran.err.contains(s)), "{ran:?}");
    };
    refused("--cycles 20 --merge", &["unfinished map with another rig"]);
    refused(
        "--cycles 20 --tiles 2..3",
        &["another rig; finish that one"],
    );
    let anew = folder.run(&format!("{line} --cycles 20")).well();
    assert!(
        anew.err.contains("another rig; this map is begun anew"),
        "{anew:?}"
    );
    let whole = Folder::new().with("mine.toml", rig(0.31));
    run(&whole, &format!("{line} --cycles 20 --quiet"));
    assert_eq!(outputs(&folder), outputs(&whole));
    assert_eq!(tiles(&folder), 0);
    run(&folder, &format!("{line} --cycles 20 --quiet --tiles 0..2"));
    let tile = request.with_file_name("tile-000000.bin");
    let good = fs::read(&tile).expect("a tile");
    for position in [0, 9, good.len() / 2, good.len() - 1] {
        let mut bad = good.clone();
        bad[position] ^= 1;
        fs::write(&tile, bad).expect("a tile");
        refused(
            "--cycles 20 --merge",
            &["2 of 3 tiles missing", ": 0..1, 2..3;"],
        );
    }
    fs::write(&tile, &good[..good.len() / 2]).expect("a tile");
    run(&folder, &format!("{line} --cycles 20 --quiet"));
    assert_eq!(outputs(&folder), outputs(&whole));
}

/// Starts `line` in `folder` and comes back when it has kept some tiles and not all.
fn underway(folder: &Folder, line: &str, all: usize) -> Child {
    let words: Vec<_> = line.split_whitespace().collect();
    let mut child = folder
        .command(&words)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let before = tiles(folder);
    let began = Instant::now();
    while tiles(folder) < before + 2 {
        assert!(began.elapsed() < Duration::from_secs(100), "no tiles");
        let ended = child.try_wait().expect("a child");
        assert!(ended.is_none(), "it was to be cut off in the middle");
        thread::sleep(Duration::from_millis(2));
    }
    assert!(tiles(folder) < all, "it was to be cut off in the middle");
    child
}

#[test]
fn a_killed_map_goes_on_and_ends_in_the_same_bytes() {
    // 16 × 50 cells are seven tiles of the reference.
    let line =
        "map --gap 0:3:0.2 --ratio 1:3.45:0.05 --cycles 40 --reference --format text --out o";
    let folder = Folder::new();
    let mut child = underway(&folder, line, 7);
    // On Unix this is SIGKILL: nothing is cleaned up.
    child.kill().expect("a child to kill");
    assert!(!wait(child).success());
    assert!(outputs(&folder).is_empty());
    let kept = tiles(&folder);
    assert!(kept >= 2);
    run(&folder, &format!("{line} --quiet"));
    let whole = Folder::new();
    run(&whole, &format!("{line} --quiet"));
    assert_eq!(outputs(&folder), outputs(&whole));
    assert_eq!(outputs(&folder).len(), 6);
    assert_eq!(tiles(&folder), 0);
}

#[cfg(unix)]
#[test]
fn an_interrupted_map_says_how_to_go_on() {
    let line = "map --gap 0:3:0.2 --ratio 1:3.45:0.05 --cycles 40 --reference --out o";
    let folder = Folder::new();
    let mut child = underway(&folder, line, 7);
    let interrupt = std::process::Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(interrupt.expect("kill").success());
    let mut stderr = child.stderr.take().expect("a pipe");
    assert_eq!(wait(child).code(), Some(130));
    let mut said = String::new();
    std::io::Read::read_to_string(&mut stderr, &mut said).expect("UTF-8");
    assert_eq!(said.lines().count(), 1, "{said}");
    assert!(said.contains("the same command goes on"), "{said}");
    assert!(tiles(&folder) >= 2);
    assert!(!folder.names().iter().any(|n| n.contains(".writing-")));
}
