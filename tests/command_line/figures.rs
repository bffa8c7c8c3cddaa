//! `host-sim figures`.

use std::fs;

use crate::support::Folder;

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
        "Found here",
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
        ("figures", &["--out"]),
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
