//! The command lines of the tutorials, executed in their order. What takes long has a test of its own.

use std::fs;

use crate::support::Folder;

/// Beginnings of lines that other tests execute, and what needs a board.
const ELSEWHERE: &[&str] = &["figures", "chapter", "link PORT", "emulate mine-run.toml"];

/// The lines of a page that begin with `host-sim`, without that word.
fn lines(page: &str) -> Vec<String> {
    let path = format!("{}/../docs/{page}", env!("CARGO_MANIFEST_DIR"));
    let text = fs::read_to_string(path).expect(page);
    let lines = text.lines().filter_map(|l| l.strip_prefix("    host-sim "));
    lines.map(str::to_owned).collect()
}

fn executed(page: &str, folder: Folder) {
    let mut folder = folder;
    let mut count = 0;
    for line in lines(page) {
        if ELSEWHERE.iter().any(|start| line.starts_with(start)) {
            continue;
        }
        let (words, file) = line.split_once(" > ").unwrap_or((&line, ""));
        let ran = folder.run(words).well();
        if !file.is_empty() {
            folder = folder.with(file.trim(), ran.out);
        }
        count += 1;
    }
    assert!(count >= 2, "{page} has {count} lines");
}

#[test]
fn the_chapter_again() {
    executed("tutorial-chapter.md", Folder::new());
}

#[test]
fn explore_the_plane() {
    executed("tutorial-explore.md", Folder::new());
}

#[test]
fn an_emulated_rig() {
    executed("tutorial-emulate.md", Folder::new());
}

#[test]
fn to_a_running_board() {
    // As `link PORT sweep --csv` writes it.
    let curve = "frequency_hz,force_n\n3.0,60.0\n3.5,80.0\n4.0,75.0\n";
    let folder = Folder::new().with("curve.csv", curve);
    executed(
        "tutorial-board.md",
        folder.with("mine.toml", "preset = \"wires\"\n"),
    );
}
