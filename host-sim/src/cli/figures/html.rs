//! The page a person reads: every figure with its picture, what the chapter says of it, and whether that is so.

use std::fmt::Write;

use super::record::{PageRecord, PartRecord};
use crate::chapter::Statement;
use crate::figures::{AREAS, DRAWINGS, Effort};

const STYLE: &str = "\
:root{color-scheme:light}\
body{font:16px/1.5 'Noto Sans','Segoe UI',Helvetica,Arial,sans-serif;color:#222;background:#fff;\
max-width:1120px;margin:0 auto;padding:1.5rem}\
h1{font-size:1.7rem;margin:0 0 .5rem}h2{font-size:1.2rem;margin:0 0 .6rem}\
section{border-top:1px solid #ccc;padding:1.4rem 0}\
nav ol{columns:2;column-gap:2rem;padding-left:0;list-style:none;font-size:.92rem}\
nav li{break-inside:avoid;padding:.1rem 0}nav b{display:inline-block;min-width:3.2rem}\
a{color:#0072b2}img{max-width:100%;height:auto;border:1px solid #ddd;margin:.3rem 0}\
dl{display:grid;grid-template-columns:9rem 1fr;gap:.35rem 1rem;margin:.6rem 0}\
dt{font-weight:600;color:#555}dd{margin:0}\
code{background:#f2f2f2;padding:.1rem .3rem;border-radius:3px;font-size:.9rem}\
table{border-collapse:collapse;margin:.6rem 0}th,td{text-align:left;vertical-align:top;\
padding:.25rem .8rem .25rem 0;border-bottom:1px solid #e4e4e4}th{color:#555}td:last-child{white-space:nowrap}\
.later{color:#777}.rough{background:#fff4d6;border:1px solid #e6c25c;padding:.6rem 1rem}\
@media(max-width:700px){nav ol{columns:1}dl{grid-template-columns:1fr}table{display:block;overflow-x:auto}\
dd,code{overflow-wrap:anywhere}}";

/// The whole page. There is one of `records` for each part, in order; none where it is not made.
pub fn page(effort: Effort, records: &[Option<PartRecord>]) -> String {
    let mut pages: Vec<&PageRecord> = records.iter().flatten().flat_map(|r| &r.pages).collect();
    pages.sort_by_key(|page| order(&page.figure));
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
         <title>The chapter's figures, made again</title>\n<style>{STYLE}</style></head><body>\n\
         <h1>The chapter's figures, made again</h1>\n\
         <p>Every computed figure of <i>Study of an embarked vibro-impact system: mathematical modeling and \
         nonlinear analysis</i>, from its model and parameters alone. Nothing here was measured on a rig. \
         Under each picture: what the chapter says of it, what is computed here, and whether they are the same \
         (<code>host-sim chapter</code> has every statement in one table).</p>\n"
    );
    if effort == Effort::Coarse {
        out += "<p class=\"rough\">Made with <code>--coarse</code>: few points and few cycles, for a first \
                look. Numbers below are rough; run without it for the real ones.</p>\n";
    }
    contents(&mut out, &pages, records);
    let statements: Vec<&Statement> = (records.iter().flatten())
        .flat_map(|r| &r.statements)
        .collect();
    for page in &pages {
        section(&mut out, page, &statements);
    }
    let key = records.iter().flatten().next().map_or("", |r| &r.key);
    out + &format!("<p>Computed by {}.</p></body></html>\n", escaped(key))
}

/// The conclusion first, then the chapter's numbers, then what goes beyond.
fn order(figure: &str) -> (u8, u32, u32) {
    let number = figure.split_once('.').and_then(|(chapter, rest)| {
        let (chapter, number) = (chapter.parse::<u32>(), rest.parse::<u32>());
        chapter.ok().zip(number.ok())
    });
    match number {
        Some((chapter, number)) => (1, chapter, number),
        None if figure == "conclusion" => (0, 0, 0),
        None => (2, 0, 0),
    }
}

fn contents(out: &mut String, pages: &[&PageRecord], records: &[Option<PartRecord>]) {
    let mut lines: Vec<((u8, u32, u32), String)> = Vec::new();
    for page in pages {
        let (id, figure) = (anchor(&page.figure), escaped(&page.figure));
        let title = escaped(&page.title);
        let line = format!("<a href=\"#{id}\"><b>{figure}</b> {title}</a>");
        lines.push((order(&page.figure), line));
    }
    for (figure, what) in DRAWINGS {
        let line = format!(
            "<span class=\"later\"><b>{figure}</b> {}; not computed</span>",
            escaped(what)
        );
        lines.push((order(figure), line));
    }
    let absent = AREAS.iter().zip(records).filter(|(_, r)| r.is_none());
    for figure in absent.flat_map(|(part, _)| part.figures) {
        let line = format!(
            "<span class=\"later\"><b>{}</b> not made yet</span>",
            escaped(figure)
        );
        lines.push((order(figure), line));
    }
    lines.sort_by_key(|line| line.0);
    *out += "<nav><h2>Contents</h2><ol>\n";
    for (_, line) in lines {
        let _ = writeln!(out, "<li>{line}</li>");
    }
    *out += "</ol></nav>\n";
}

fn section(out: &mut String, page: &PageRecord, statements: &[&Statement]) {
    let figure = escaped(&page.figure);
    let heading = if order(&page.figure).0 == 1 {
        format!("Figure {figure}: {}", escaped(&page.title))
    } else {
        escaped(&page.title)
    };
    let _ = writeln!(
        out,
        "<section id=\"{}\"><h2>{heading}</h2>",
        anchor(&page.figure)
    );
    let ends = |end: &str| {
        let end = end.to_owned();
        page.files.iter().filter(move |f| f.name.ends_with(&end))
    };
    // A picture is there as SVG and as PNG of the same name.
    for png in ends(".png") {
        let svg = png.name.replace(".png", ".svg");
        let has_svg = page.files.iter().any(|f| f.name == svg);
        let large = if has_svg { &svg } else { &png.name };
        let _ = writeln!(
            out,
            "<a href=\"{}\"><img loading=\"lazy\" src=\"{}\" alt=\"{}\"></a>",
            escaped(large),
            escaped(&png.name),
            escaped(&page.title)
        );
    }
    let links: Vec<String> = page
        .files
        .iter()
        .map(|f| format!("<a href=\"{0}\">{0}</a>", escaped(&f.name)))
        .collect();
    judged(
        out,
        statements.iter().filter(|s| s.is_shown_by(&page.figure)),
    );
    let given = |name: &str, text: String| match text.as_str() {
        "" => String::new(),
        text => format!("<dt>{name}</dt><dd>{text}</dd>\n"),
    };
    let code = |line: &str| match line {
        "" => String::new(),
        line => format!("<code>{}</code>", escaped(line)),
    };
    let _ = writeln!(
        out,
        "<dl>{}{}{}{}</dl></section>",
        given("Note", escaped(&page.note)),
        given("Alone", code(&page.command)),
        given("Like it", code(&page.like)),
        given("Files", links.join(", "))
    );
}

/// What the chapter says of a figure, as a table.
fn judged<'a>(out: &mut String, statements: impl Iterator<Item = &'a &'a Statement>) {
    let rows: Vec<String> = statements
        .map(|s| {
            let cells = [&s.section, &s.words, &s.ours].map(|text| escaped(text));
            format!(
                "<tr><td>{}</td><td>{}</td></tr>\n",
                cells.join("</td><td>"),
                s.verdict.words()
            )
        })
        .collect();
    if !rows.is_empty() {
        let _ = writeln!(
            out,
            "<table><tr><th>Section</th><th>The chapter</th><th>Computed here</th><th>Verdict</th></tr>\n{}</table>",
            rows.concat()
        );
    }
}

fn anchor(figure: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() { c } else { '-' };
    format!("figure-{}", figure.chars().map(plain).collect::<String>())
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chapter::ChapterVerdict;

    #[test]
    fn figures_stand_in_the_order_of_their_numbers() {
        let mut names = ["orbits", "3.27", "3.4", "conclusion", "3.36"];
        names.sort_by_key(|n| order(n));
        assert_eq!(names, ["conclusion", "3.4", "3.27", "3.36", "orbits"]);
    }

    #[test]
    fn text_cannot_break_the_page() {
        let record = PartRecord {
            key: "k".into(),
            part: "p".into(),
            pages: vec![PageRecord {
                figure: "3.24".into(),
                title: "a < b".into(),
                note: "<script> \"x\" & y".into(),
                command: "host-sim".into(),
                like: String::new(),
                files: Vec::new(),
            }],
            statements: vec![Statement {
                number: 7,
                section: "3.3.6".into(),
                words: "<b>".into(),
                ours: "no".into(),
                verdict: ChapterVerdict::Differs,
                figures: "3.24, 3.25".into(),
            }],
        };
        let page = page(Effort::Full, &[Some(record)]);
        assert!(page.contains("a &lt; b") && page.contains("&lt;script&gt;"));
        assert!(page.contains("<td>&lt;b&gt;</td><td>no</td><td>differs</td>"));
        assert!(!page.contains("<script") && !page.contains("http"));
    }
}
