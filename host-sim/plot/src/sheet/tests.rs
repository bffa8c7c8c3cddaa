//! Tests of the page as PDF.

use super::*;
use crate::{Axis, Color, Item, Panel};

fn page() -> (String, Vec<Block>) {
    let curve = (0..50).map(|i| (f64::from(i), f64::from(i * i))).collect();
    let panel = Panel::new(Axis::new("Hz"), Axis::new("N"))
        .item(Item::line("force", Color::BLUE, curve))
        .item(Item::band_x("band", 10.0, 20.0));
    let blocks = vec![
        Block::Heading("Answer".into()),
        Block::Paragraph("Run it at 3.68 Hz.".into()),
        Block::Picture(Figure::new("Force").panel(panel)),
        Block::Row("force".into(), "30 times the weight ".repeat(20)),
    ];
    ("wires".to_owned(), blocks)
}

/// The objects of a PDF file by the table at its end, and its trailer: read as a reader would, from the last line back.
fn objects(file: &[u8]) -> (Vec<&[u8]>, String) {
    let text = String::from_utf8_lossy(file);
    assert!(text.starts_with("%PDF-1."), "{}", &text[..20]);
    let tail = String::from_utf8_lossy(&file[file.len() - 60..]).into_owned();
    let at = tail.lines().rev().nth(1).unwrap().parse::<usize>().unwrap();
    assert_eq!(tail.lines().last(), Some("%%EOF"));
    let table = String::from_utf8_lossy(&file[at..]).into_owned();
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("xref"));
    let count = lines.next().unwrap().split(' ').nth(1).unwrap();
    let count = count.parse::<usize>().unwrap();
    let places: Vec<usize> = lines
        .by_ref()
        .take(count)
        .filter(|line| line.trim_end().ends_with('n'))
        .map(|line| line[..10].parse().unwrap())
        .collect();
    let objects = places.iter().enumerate().map(|(i, place)| {
        let head = format!("{} 0 obj", i + 1);
        assert!(
            file[*place..].starts_with(head.as_bytes()),
            "object {}",
            i + 1
        );
        &file[*place..]
    });
    (objects.collect(), lines.collect::<Vec<_>>().join(" "))
}

#[test]
fn every_object_is_where_the_table_says_and_the_page_has_its_text() {
    let (title, blocks) = page();
    let file = render_pdf(&title, &blocks).unwrap();
    let (objects, trailer) = objects(&file);
    assert!(trailer.contains("/Root 1 0 R"), "{trailer}");
    assert!(objects.len() >= 8);
    let text = String::from_utf8_lossy(&file).into_owned();
    assert_eq!(text.matches("/Type /Page\n").count(), 1);
    // The content stream is as long as it says.
    let stream = String::from_utf8_lossy(objects[3]).into_owned();
    let length = stream.split("/Length ").nth(1).unwrap();
    let length: usize = length.split_whitespace().next().unwrap().parse().unwrap();
    let find = |what: &[u8]| {
        objects[3]
            .windows(what.len())
            .position(|w| w == what)
            .unwrap()
    };
    let (begin, end) = (find(b"stream\n") + 7, find(b"\nendstream"));
    assert_eq!(end - begin, length);
    for said in ["(Answer) Tj", "(Run it at 3.68 Hz.) Tj"] {
        assert!(text.contains(said), "{said}");
    }
    // Every state and font used is in the resources.
    for name in ["/R ", "/B ", "/A1000 "] {
        assert!(text.matches(name).count() >= 2, "{name}");
    }
}

#[test]
fn what_is_too_long_for_a_page_is_made_smaller() {
    let (title, mut blocks) = page();
    let first = String::from_utf8_lossy(&render_pdf(&title, &blocks).unwrap()).into_owned();
    assert!(first.contains("\n1 0 0 -1 42 800 cm"), "not shrunk");
    for _ in 0..60 {
        blocks.push(Block::Row("name".into(), "text ".repeat(60)));
    }
    assert!(height(&title, &blocks) > PAGE.1);
    let long = String::from_utf8_lossy(&render_pdf(&title, &blocks).unwrap()).into_owned();
    assert!(!long.contains("\n1 0 0 -1 42 800 cm"), "shrunk");
}

#[test]
fn letters_are_written_so_that_every_reader_shows_them() {
    let line = |text: &str| text.chars().flat_map(encoded).collect::<Vec<u8>>();
    assert_eq!(
        line("±2 × Ω"),
        [0xb1, b'2', b' ', 0xd7, b' ', b'O', b'm', b'e', b'g', b'a']
    );
    assert_eq!(line("−1"), b"-1");
}
