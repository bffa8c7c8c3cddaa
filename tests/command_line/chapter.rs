//! `host-sim chapter`: every verdict of docs/chapter.md holds.

use std::fs;

use crate::support::Folder;

/// Section, words and verdict of each line of the table.
fn in_the_docs() -> Vec<[String; 3]> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/chapter.md");
    let page = fs::read_to_string(path).expect("docs/chapter.md");
    let lines = page.lines().filter(|line| line.starts_with("| "));
    let cells = lines.map(|line| line.split(" | ").map(str::to_owned).collect::<Vec<_>>());
    let rows = cells.filter(|cells| cells[0].trim_start_matches("| ").parse::<u32>().is_ok());
    rows.map(|cells| {
        let verdict = cells[cells.len() - 1].trim_end_matches(" |").to_owned();
        [cells[1].clone(), cells[2].clone(), verdict]
    })
    .collect()
}

#[test]
fn every_verdict_of_the_page_is_found_again_on_coarser_grids() {
    let folder = Folder::new()
        .with("chapter-coarse.json", "{\"made_from\": {}}")
        .with("chapter-coarse.csv", "older");
    let ran = folder.run("chapter --coarse --format json --out .").well();
    let wrote = ".md, .csv, .json (replaced)\n";
    assert!(ran.err.ends_with(wrote), "{ran:?}");
    let rows = ran.json();
    let rows = rows.as_array().expect("a list");
    let found: Vec<[String; 3]> = rows
        .iter()
        .map(|row| {
            let text = |key: &str| row[key].as_str().unwrap_or_default().to_owned();
            let verdict = text("verdict").replace("cannot-be-told", "cannot be told");
            [text("section"), text("words"), verdict]
        })
        .collect();
    let docs = in_the_docs();
    assert_eq!(found.len(), docs.len());
    for (found, docs) in found.iter().zip(&docs) {
        assert_eq!(found, docs);
    }
    for verdict in ["same", "differs", "cannot be told"] {
        assert!(docs.iter().any(|row| row[2] == verdict), "{verdict}");
    }
}
