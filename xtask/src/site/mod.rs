//! The site: the pages of `docs/` and those beside them as HTML that needs no network, the documentation of the crates and of
//! the Python package, and the page, in `target/site`. Every link within is followed.
//!
//! The pages are those of the repository, unchanged; `docs/SUMMARY.md` is their order. A small generator upon `pulldown-cmark`
//! does it: mdBook takes no pages from outside one folder, and would be compiled for every `cargo xtask`.

mod book;
mod page;

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use book::{Part, file_name};
use page::{Goal, Page, Section, render};
use serde::Serialize;

use crate::{
    Outcome,
    command::{self, cargo, root},
    python, web,
};

/// What is asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum Plan {
    /// Everything.
    Whole,
    /// The pages alone, with their links.
    Check,
}

impl Plan {
    /// Reads the options behind `cargo xtask site`.
    pub fn parse(words: &[&str]) -> Result<Self, String> {
        match words {
            [] => Ok(Self::Whole),
            ["--check"] => Ok(Self::Check),
            [other, ..] => Err(format!("no option `{other}`; see `cargo xtask help`")),
        }
    }
}

/// Pages that are made elsewhere: the name in the list, and the file in the site.
type Elsewhere = Vec<(&'static str, String)>;

/// Builds it.
pub fn run(plan: &Plan) -> Outcome {
    let place = match plan {
        Plan::Whole => root().join("target/site"),
        Plan::Check => root().join("target/site-check"),
    };
    let part = place.with_extension("part");
    for folder in [&place, &part] {
        if folder.exists() {
            fs::remove_dir_all(folder)?;
        }
    }
    fs::create_dir_all(&part)?;
    let elsewhere = match plan {
        Plan::Whole => elsewhere(&part)?,
        Plan::Check => Vec::new(),
    };
    let count = pages(&part, &elsewhere)?;
    fs::rename(&part, &place)?;
    println!(
        "{count} pages, no dead link: {}",
        place.join("index.html").display()
    );
    Ok(())
}

/// Writes the pages alone into a folder of `target`, whatever it held; for a browser's tests.
pub fn pages_for_tests() -> Outcome<PathBuf> {
    let place = root().join("target/site-in-browser");
    if place.exists() {
        fs::remove_dir_all(&place)?;
    }
    fs::create_dir_all(&place)?;
    pages(&place, &Vec::new())?;
    Ok(place)
}

/// The documentation that other programs make, and the page, each left out with a line where it cannot be had.
fn elsewhere(place: &Path) -> Outcome<Elsewhere> {
    let mut found = Elsewhere::new();
    if let Some(page) = web::build_if_possible()? {
        fs::copy(page, place.join("page.html"))?;
        fs::write(place.join("explore.html"), "")?;
        found.push(("The page", "explore.html".into()));
    }
    let mut doc = cargo();
    doc.args(["doc", "--workspace", "--no-deps"]);
    command::run(doc.env("RUSTDOCFLAGS", "-D warnings"))?;
    copy_folder(&target_folder().join("doc"), &place.join("rust"))?;
    found.push(("Rust crates", "rust/numerics/index.html".into()));
    match python_docs(place) {
        Ok(file) => found.push(("Python package", file)),
        Err(error) => println!("the Python package's documentation is left out: {error}"),
    }
    Ok(found)
}

/// Written by pdoc from the installed package.
fn python_docs(place: &Path) -> Outcome<String> {
    let environment = python::own_environment()?;
    command::run(python::pip(&environment).arg("pdoc>=15,<17"))?;
    python::install(&environment)?;
    let mut pdoc = Command::new(environment.join("bin/pdoc"));
    pdoc.args(["--docformat", "numpy", "--output-directory"]);
    command::run(pdoc.arg(place.join("python-api")).arg("vibroimpact"))?;
    Ok("python-api/vibroimpact.html".into())
}

fn target_folder() -> PathBuf {
    let set = std::env::var_os("CARGO_TARGET_DIR");
    set.map_or_else(|| root().join("target"), PathBuf::from)
}

fn copy_folder(from: &Path, to: &Path) -> Outcome {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let goal = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy_folder(&entry.path(), &goal)?;
        } else {
            fs::copy(entry.path(), goal)?;
        }
    }
    Ok(())
}

/// Writes every page and what they show into `place`; an error names every dead link.
fn pages(place: &Path, elsewhere: &Elsewhere) -> Outcome<usize> {
    let parts = book::parts(&fs::read_to_string(root().join("docs/SUMMARY.md"))?);
    let sources: Vec<&str> = parts
        .iter()
        .flat_map(|part| part.entries.iter().map(|entry| entry.source.as_str()))
        .collect();
    let mut shown: BTreeSet<String> = BTreeSet::new();
    let mut rendered: BTreeMap<String, Page> = BTreeMap::new();
    for source in &sources {
        let text = fs::read_to_string(root().join(source))
            .map_err(|error| format!("docs/SUMMARY.md names {source}: {error}"))?;
        let mut find = |path: &str| goal(path, &sources, elsewhere, &mut shown);
        rendered.insert(file_name(source), render(source, &text, &mut find)?);
    }
    refuse_dead(&rendered)?;
    for path in &shown {
        let goal = place.join(path.strip_prefix("docs/").unwrap_or(path));
        fs::create_dir_all(goal.parent().unwrap_or(place))?;
        fs::copy(root().join(path), goal)?;
    }
    fs::write(place.join("style.css"), include_str!("style.css"))?;
    fs::write(place.join("search.js"), include_str!("search.js"))?;
    fs::write(place.join("search-index.js"), index(&rendered)?)?;
    for (at, source) in sources.iter().enumerate() {
        let name = file_name(source);
        let page = &rendered[&name];
        let neighbours = [at.checked_sub(1), Some(at + 1)].map(|at| {
            let source = sources.get(at?)?;
            Some((
                file_name(source),
                rendered[&file_name(source)].title.as_str(),
            ))
        });
        let inner = format!(
            "<main id=\"text\">\n{}{}</main>",
            page.body,
            turn(&neighbours)
        );
        let html = framed(&page.title, &inner, &parts, elsewhere, &name);
        fs::write(place.join(&name), html)?;
    }
    if place.join("explore.html").is_file() {
        let inner = "<main id=\"text\" class=\"whole\"><iframe src=\"page.html\" title=\"Explore the model\"></iframe></main>";
        let html = framed("The page", inner, &parts, elsewhere, "explore.html");
        fs::write(place.join("explore.html"), html)?;
    }
    Ok(sources.len())
}

/// A section of a page, for the search.
#[derive(Serialize)]
struct Found<'a> {
    page: &'a str,
    title: &'a str,
    #[serde(flatten)]
    section: &'a Section,
}

/// All sections as a script, which a page opened from a folder can load.
fn index(rendered: &BTreeMap<String, Page>) -> Outcome<String> {
    let mut found = Vec::new();
    for (name, page) in rendered {
        found.extend(page.sections.iter().map(|section| Found {
            page: name,
            title: &page.title,
            section,
        }));
    }
    let json = serde_json::to_string(&found)?;
    Ok(format!("globalThis.searchSections = {json};\n"))
}

/// Where a path of the project stands in the site.
fn goal(
    path: &str,
    sources: &[&str],
    elsewhere: &Elsewhere,
    shown: &mut BTreeSet<String>,
) -> Outcome<Goal> {
    if sources.contains(&path) {
        return Ok(Goal::To(file_name(path)));
    }
    let full = root().join(path);
    if full.is_dir() {
        // A package of ours leads to its documentation, where that is in the site.
        let crates = ["shared", "host-sim", "xtask"];
        let there = elsewhere.iter().any(|(_, file)| file.starts_with("rust/"));
        return Ok(match crates.iter().find(|name| **name == path) {
            Some(name) if there => Goal::To(format!("rust/{}/index.html", name.replace('-', "_"))),
            _ => Goal::Words,
        });
    }
    if !full.is_file() {
        return Err(format!("a dead link: there is no {path}").into());
    }
    if path.ends_with(".md") {
        return Err(format!("{path} is linked to and is not in docs/SUMMARY.md").into());
    }
    if !path.starts_with("docs/") {
        return Ok(Goal::Words);
    }
    shown.insert(path.into());
    Ok(Goal::To(path["docs/".len()..].into()))
}

/// Every place in a page that is linked to must be there.
fn refuse_dead(rendered: &BTreeMap<String, Page>) -> Outcome {
    let mut dead = Vec::new();
    for (name, page) in rendered {
        for (to, fragment) in &page.links {
            let goal = if to.is_empty() { name } else { to };
            let (Some(fragment), Some(there)) = (fragment, rendered.get(goal)) else {
                continue;
            };
            if !there.anchors.contains(fragment) {
                dead.push(format!("{name}: {goal} has no heading #{fragment}"));
            }
        }
    }
    if dead.is_empty() {
        Ok(())
    } else {
        Err(format!("dead links:\n  {}", dead.join("\n  ")).into())
    }
}

/// The links to the page before and the page after.
fn turn(neighbours: &[Option<(String, &str)>; 2]) -> String {
    let [before, after] = neighbours;
    let link = |neighbour: &Option<(String, &str)>, arrow: [&str; 2]| {
        neighbour
            .as_ref()
            .map_or("<span></span>".into(), |(file, title)| {
                format!(
                    "<a href=\"{file}\">{}{}{}</a>",
                    arrow[0],
                    escaped(title),
                    arrow[1]
                )
            })
    };
    format!(
        "<div class=\"turn\">{}{}</div>\n",
        link(before, ["← ", ""]),
        link(after, ["", " →"])
    )
}

/// A page with what stands around it: the list of all pages, this one marked.
fn framed(title: &str, inner: &str, parts: &[Part], elsewhere: &Elsewhere, own: &str) -> String {
    let item = |file: &str, title: &str| {
        let mark = if file == own {
            " aria-current=\"page\""
        } else {
            ""
        };
        format!("<li><a href=\"{file}\"{mark}>{}</a></li>\n", escaped(title))
    };
    let mut list = String::new();
    for part in parts {
        list += &format!("<h2>{}</h2>\n<ul>\n", escaped(&part.title));
        for entry in &part.entries {
            list += &item(&file_name(&entry.source), &entry.title);
        }
        list += "</ul>\n";
    }
    if !elsewhere.is_empty() {
        list += "<h2>Made by other tools</h2>\n<ul>\n";
        for (title, file) in elsewhere {
            list += &item(file, title);
        }
        list += "</ul>\n";
    }
    let title = escaped(title);
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title} – vibroimpact</title>\n<link rel=\"stylesheet\" href=\"style.css\">\n<script defer src=\"search.js\"></script>\n</head>\n<body>\n\
         <a class=\"skip\" href=\"#text\">To the text</a>\n<a class=\"contents\" href=\"#contents\">Contents</a>\n\
         <div class=\"frame\">\n{inner}\n<nav class=\"book\" id=\"contents\" aria-label=\"Contents\">\n{list}</nav>\n</div>\n\
         </body>\n</html>\n"
    )
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_read() {
        assert_eq!(Plan::parse(&[]), Ok(Plan::Whole));
        assert_eq!(Plan::parse(&["--check"]), Ok(Plan::Check));
        assert!(Plan::parse(&["--chek"]).is_err());
    }

    #[test]
    fn every_page_of_docs_is_in_the_list_and_no_link_is_dead() {
        let folder = tempfile::tempdir().unwrap();
        let count = pages(folder.path(), &Vec::new()).unwrap();
        let summary = fs::read_to_string(root().join("docs/SUMMARY.md")).unwrap();
        for entry in fs::read_dir(root().join("docs")).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            let known = !name.ends_with(".md") || name == "SUMMARY.md";
            assert!(known || summary.contains(&format!("({name})")), "{name}");
        }
        let pages = fs::read_dir(folder.path()).unwrap();
        let names = pages.map(|page| page.unwrap().file_name().into_string().unwrap());
        assert_eq!(names.filter(|name| name.ends_with(".html")).count(), count);
        let theory = fs::read_to_string(folder.path().join("theory.html")).unwrap();
        assert!(theory.contains("<math") && !theory.contains("$$"));
    }

    #[test]
    fn a_dead_place_in_a_page_is_named() {
        let page = |links| Page {
            body: String::new(),
            title: String::new(),
            anchors: vec!["here".into()],
            links,
            sections: Vec::new(),
        };
        let with = |fragment: &str| {
            let links = vec![("b.html".to_owned(), Some(fragment.to_owned()))];
            let pages = [("a.html", page(links)), ("b.html", page(Vec::new()))];
            refuse_dead(&pages.map(|(name, page)| (name.to_owned(), page)).into())
        };
        assert!(with("here").is_ok());
        let error = with("there").unwrap_err().to_string();
        assert!(
            error.contains("a.html: b.html has no heading #there"),
            "{error}"
        );
    }
}
