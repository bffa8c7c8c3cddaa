//! The order of the pages: `docs/SUMMARY.md`, a list of links under headings.

use std::path::{Component, Path, PathBuf};

use pulldown_cmark::{Event, Parser, Tag, TagEnd};

/// A page of the book.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Its title in the list.
    pub title: String,
    /// Its file, from the root of the project.
    pub source: String,
}

/// A heading of the list with the pages below it.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    pub title: String,
    pub entries: Vec<Entry>,
}

/// Reads the list. Its first heading is its own title.
pub fn parts(summary: &str) -> Vec<Part> {
    let mut parts: Vec<Part> = Vec::new();
    let (mut text, mut link) = (String::new(), None);
    for event in Parser::new(summary) {
        match event {
            Event::Start(Tag::Heading { .. }) => text.clear(),
            Event::Start(Tag::Link { dest_url, .. }) => {
                text.clear();
                link = Some(dest_url.into_string());
            }
            Event::Text(more) | Event::Code(more) => text += &more,
            Event::End(TagEnd::Heading(_)) => parts.push(Part {
                title: text.clone(),
                entries: Vec::new(),
            }),
            Event::End(TagEnd::Link) => {
                if let (Some(part), Some(link)) = (parts.last_mut(), link.take()) {
                    part.entries.push(Entry {
                        title: text.clone(),
                        source: resolved("docs", &link),
                    });
                }
            }
            _ => {}
        }
    }
    parts.retain(|part| !part.entries.is_empty());
    parts
}

/// The path, from the root of the project, of what a page in `folder` calls `link`.
pub fn resolved(folder: &str, link: &str) -> String {
    let mut path = PathBuf::new();
    for component in Path::new(folder).join(link).components() {
        match component {
            Component::ParentDir => drop(path.pop()),
            Component::CurDir => {}
            other => path.push(other),
        }
    }
    path.to_string_lossy().into_owned()
}

/// The name of a page's file in the site, which has one folder.
pub fn file_name(source: &str) -> String {
    if source == "README.md" {
        return "index.html".into();
    }
    let inner = source.strip_prefix("docs/").unwrap_or(source);
    let name = inner.replace('/', "-").to_lowercase();
    format!("{}.html", name.strip_suffix(".md").unwrap_or(&name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_is_read_in_its_order() {
        let text = "# Contents\n\n- [Start](../README.md)\n\n## One\n\n- [The `map`](map.md)\n- [Board](../a/README.md)\n";
        let entry = |title: &str, source: &str| Entry {
            title: title.into(),
            source: source.into(),
        };
        let found = parts(text);
        assert_eq!(found[0].entries, [entry("Start", "README.md")]);
        assert_eq!(
            found[1].entries,
            [
                entry("The map", "docs/map.md"),
                entry("Board", "a/README.md")
            ]
        );
        assert_eq!(found[1].title, "One");
    }

    #[test]
    fn every_page_has_a_name_of_its_own() {
        assert_eq!(file_name("README.md"), "index.html");
        assert_eq!(file_name("docs/map.md"), "map.html");
        assert_eq!(file_name("a/b/README.md"), "a-b-readme.html");
        assert_eq!(resolved("docs", "../README.md"), "README.md");
        assert_eq!(resolved("docs/a", "./b.png"), "docs/a/b.png");
    }
}
