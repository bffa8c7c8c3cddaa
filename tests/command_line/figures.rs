//! `host-sim figures`.

use std::fs;

use serde_json::Value;

use crate::support::{Folder, finish};

#[test]
fn asked_for_alone_a_figure_is_made_with_its_page_and_not_made_again() {
    let folder = Folder::new();
    let line = "figures --coarse --quiet --only 3.6 --out made";
    let first = folder.run(line).well();
    assert!(first.out.contains("3.5, 3.6 made in"), "{first:?}");
    for name in ["figure-3-5", "figure-3-6"] {
        for end in ["svg", "png", "csv"] {
            assert!(
                folder.path(&format!("made/{name}.{end}")).is_file(),
                "{name}.{end}"
            );
        }
    }
    let page = fs::read_to_string(folder.path("made/index.html")).unwrap();
    for part in [
        "Figure 3.6",
        "figure-3-6.png",
        "Note",
        "not made yet",
        "a photograph",
    ] {
        assert!(page.contains(part), "{part}");
    }
    // Self-contained: no scripts, nothing from elsewhere, every link beside it.
    assert!(!page.contains("<script") && !page.contains("http"));
    for link in page
        .split("href=\"")
        .skip(1)
        .map(|l| l.split('"').next().unwrap())
    {
        let there = link.starts_with('#') || folder.path(&format!("made/{link}")).is_file();
        assert!(there, "{link}");
    }
    let again = folder.run(line).well();
    assert!(again.out.contains("3.5, 3.6 already made"), "{again:?}");
    // A damaged file is noticed and its part made again, to the same bytes.
    let path = folder.path("made/figure-3-6.csv");
    let whole = fs::read(&path).unwrap();
    fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    let mended = folder.run(line).well();
    assert!(mended.out.contains("made in"), "{mended:?}");
    assert_eq!(fs::read(&path).unwrap(), whole);
    // In another folder, at another time: the same bytes in every file.
    folder.run(&line.replace("made", "other")).well();
    let names = folder.names();
    for name in names.iter().filter_map(|name| name.strip_prefix("made/")) {
        let bytes = ["made", "other"].map(|dir| fs::read(folder.path(&format!("{dir}/{name}"))));
        let [made, other] = bytes.map(Result::unwrap);
        assert!(made == other, "{name}");
    }
}

#[test]
fn what_cannot_be_made_is_refused_in_one_line() {
    let folder = Folder::new().with("taken", "");
    for (line, parts) in [
        ("figures --out x --only 3.7", &["3.7", "photograph"][..]),
        (
            "figures --out x --only 9.9",
            &["9.9", "choose from", "3.12"],
        ),
        ("figures --out taken", &["taken", "is a file"]),
    ] {
        let ran = folder.run(line);
        assert_eq!(ran.code, Some(2), "{line}: {ran:?}");
        assert_eq!(ran.err.trim().lines().count(), 1, "{ran:?}");
        for part in parts {
            assert!(ran.err.contains(part), "{line}: {}", ran.err);
        }
        assert!(!folder.path("x").exists());
    }
}

#[test]
fn the_command_under_a_picture_makes_exactly_it() {
    let folder = Folder::new();
    folder
        .run("figures --coarse --quiet --only 3.3,3.6,3.12,3.22 --out all")
        .well();
    let index: Value = serde_json::from_str(&folder.read("all/index.json")).unwrap();
    let parts = index["parts"].as_array().unwrap().iter();
    let pages: Vec<&Value> = parts.flat_map(|p| p["pages"].as_array().unwrap()).collect();
    let mut compared = 0;
    for (figure, file) in [
        ("3.3", "figure-3-3"),
        ("contact laws", "figure-contact-laws"),
        ("3.5", "figure-3-5"),
        ("3.13", "figure-3-13"),
        ("3.22", "figure-3-22"),
    ] {
        let page = pages.iter().find(|page| page["figure"] == figure).unwrap();
        let command = page["command"].as_str().unwrap();
        let line = command.strip_prefix("host-sim ").unwrap();
        let words = line.replace("'contact laws'", "contact_laws");
        let words: Vec<String> = words
            .split(' ')
            .map(|word| word.replace('_', " "))
            .collect();
        let out = format!("alone-{file}");
        let mut words: Vec<&str> = words.iter().map(String::as_str).collect();
        words.extend(["--quiet", "--out", &out]);
        finish(folder.command(&words)).well();
        for file in page["files"].as_array().unwrap() {
            let name = file["name"].as_str().unwrap();
            let [all, alone] = ["all", &out].map(|dir| {
                let path = folder.path(&format!("{dir}/{name}"));
                fs::read(path).unwrap_or_else(|e| panic!("{name}: {e}"))
            });
            assert!(all == alone, "{name}: {line} makes other bytes");
            compared += 1;
        }
        assert!(folder.path(&format!("{out}/{file}.svg")).is_file());
    }
    assert!(compared >= 15, "{compared}");
}
