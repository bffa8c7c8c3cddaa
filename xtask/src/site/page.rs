//! A page: Markdown to HTML, with the links turned to those of the site and equations as MathML.

use std::collections::HashMap;

use pulldown_cmark::{CowStr, Event, Options, Parser, Tag, TagEnd, html};
use serde::Serialize;

use super::book::resolved;
use crate::Outcome;

/// What a link leads to in the site.
pub enum Goal {
    /// A file of the site, or an address elsewhere.
    To(String),
    /// Nothing in the site: its words stay.
    Words,
}

/// A rendered page.
pub struct Page {
    /// Its text, without what stands around it.
    pub body: String,
    /// Its first heading.
    pub title: String,
    /// What can be linked to in it.
    pub anchors: Vec<String>,
    /// The pages and places in them that it links to.
    pub links: Vec<(String, Option<String>)>,
    /// What can be searched for.
    pub sections: Vec<Section>,
}

/// A heading with the words below it, as far as the next.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Section {
    pub anchor: String,
    pub heading: String,
    pub text: String,
}

/// Renders `text`, the page `source`; `find` says where a path of the project stands in the site.
pub fn render(
    source: &str,
    text: &str,
    find: &mut dyn FnMut(&str) -> Outcome<Goal>,
) -> Outcome<Page> {
    let options = Options::ENABLE_TABLES | Options::ENABLE_FOOTNOTES | Options::ENABLE_MATH;
    let mut events: Vec<Event> = Parser::new_ext(text, options).collect();
    let (title, anchors) = name_headings(&mut events);
    let sections = sections(&events);
    let folder = source.rsplit_once('/').map_or("", |(folder, _)| folder);
    let mut links = Vec::new();
    // Whether each open link is kept.
    let mut open = Vec::new();
    let mut kept = Vec::with_capacity(events.len());
    for mut event in events {
        match &mut event {
            Event::Start(Tag::Link { dest_url, .. }) => {
                let goal = turned(folder, dest_url, find, &mut links)
                    .map_err(|error| format!("{source}: {error}"))?;
                open.push(goal.is_some());
                match goal {
                    Some(goal) => *dest_url = goal.into(),
                    None => continue,
                }
            }
            Event::End(TagEnd::Link) if open.pop() == Some(false) => continue,
            Event::Start(Tag::Image { dest_url, .. }) => {
                match find(&resolved(folder, dest_url)).map_err(|e| format!("{source}: {e}"))? {
                    Goal::To(to) => *dest_url = to.into(),
                    Goal::Words => return Err(format!("{source}: no picture {dest_url}").into()),
                }
            }
            Event::InlineMath(math) => event = Event::InlineHtml(mathml(source, math, false)?),
            Event::DisplayMath(math) => event = Event::InlineHtml(mathml(source, math, true)?),
            // A wide table scrolls by itself.
            Event::Start(Tag::Table(_)) => kept.push(Event::Html("<div class=\"table\">".into())),
            _ => {}
        }
        let ends = matches!(event, Event::End(TagEnd::Table));
        kept.push(event);
        if ends {
            kept.push(Event::Html("</div>".into()));
        }
    }
    let mut body = String::new();
    html::push_html(&mut body, kept.into_iter());
    Ok(Page {
        body,
        title,
        anchors,
        links,
        sections,
    })
}

/// Where a link leads in the site; none if only its words stay.
fn turned(
    folder: &str,
    link: &str,
    find: &mut dyn FnMut(&str) -> Outcome<Goal>,
    links: &mut Vec<(String, Option<String>)>,
) -> Outcome<Option<String>> {
    if link.contains("://") || link.starts_with("mailto:") {
        return Ok(Some(link.to_owned()));
    }
    let (path, fragment) = match link.split_once('#') {
        Some((path, fragment)) => (path, Some(fragment.to_owned())),
        None => (link, None),
    };
    if path.is_empty() {
        links.push((String::new(), fragment));
        return Ok(Some(link.to_owned()));
    }
    Ok(match find(&resolved(folder, path))? {
        Goal::Words => None,
        Goal::To(to) => {
            links.push((to.clone(), fragment.clone()));
            Some(fragment.map_or(to.clone(), |fragment| format!("{to}#{fragment}")))
        }
    })
}

/// Gives every heading the name that a repository's host gives it; returns the first heading and all names.
fn name_headings(events: &mut [Event]) -> (String, Vec<String>) {
    let mut title = String::new();
    let mut names = Vec::new();
    let mut seen: HashMap<String, u32> = HashMap::new();
    for at in 0..events.len() {
        if !matches!(events[at], Event::Start(Tag::Heading { .. })) {
            continue;
        }
        let mut text = String::new();
        for event in &events[at..] {
            match event {
                Event::Text(more) | Event::Code(more) => text += more,
                Event::End(TagEnd::Heading(_)) => break,
                _ => {}
            }
        }
        let mut name = slug(&text);
        let count = seen.entry(name.clone()).or_default();
        *count += 1;
        if *count > 1 {
            name = format!("{name}-{}", *count - 1);
        }
        if let Event::Start(Tag::Heading { id, .. }) = &mut events[at] {
            *id = Some(name.clone().into());
        }
        names.push(name);
        if title.is_empty() {
            title = text;
        }
    }
    (title, names)
}

/// The words under each heading; the headings have their names.
fn sections(events: &[Event]) -> Vec<Section> {
    let mut found: Vec<Section> = Vec::new();
    let mut in_heading = false;
    for event in events {
        if let Event::Start(Tag::Heading { id, .. }) = event {
            in_heading = true;
            found.push(Section {
                anchor: id.as_deref().unwrap_or_default().into(),
                ..Section::default()
            });
        }
        let Some(section) = found.last_mut() else {
            continue;
        };
        match event {
            Event::Text(words) | Event::Code(words) if in_heading => section.heading += words,
            Event::Text(words) | Event::Code(words) => section.text += words,
            Event::End(TagEnd::Heading(_)) => in_heading = false,
            // Within a line of text these end no word.
            Event::End(TagEnd::Emphasis | TagEnd::Strong | TagEnd::Link) => {}
            Event::SoftBreak | Event::HardBreak | Event::End(_) => section.text.push(' '),
            _ => {}
        }
    }
    found
}

/// Small letters, hyphens for spaces, nothing else but digits and underscores.
fn slug(text: &str) -> String {
    let kept = text.chars().filter_map(|c| match c {
        ' ' | '-' => Some('-'),
        c if c.is_alphanumeric() || c == '_' => Some(c),
        _ => None,
    });
    kept.flat_map(char::to_lowercase).collect()
}

fn mathml(source: &str, latex: &str, display: bool) -> Outcome<CowStr<'static>> {
    let storage = pulldown_latex::Storage::new();
    let parser = pulldown_latex::Parser::new(latex, &storage);
    let mode = if display {
        pulldown_latex::config::DisplayMode::Block
    } else {
        pulldown_latex::config::DisplayMode::Inline
    };
    let config = pulldown_latex::RenderConfig {
        display_mode: mode,
        ..Default::default()
    };
    let mut text = String::new();
    // A mistake in an equation would be drawn as words.
    if let Some(error) = pulldown_latex::Parser::new(latex, &storage).find_map(Result::err) {
        return Err(format!("{source}: the equation '{latex}': {error}").into());
    }
    pulldown_latex::mathml::push_mathml(&mut text, parser, config)?;
    Ok(plain_greek(&text).into())
}

/// A browser slants a letter that stands alone by a sign of its own, for which many systems have no font if it is Greek: the
/// style sheet slants those.
fn plain_greek(mathml: &str) -> String {
    let mut text = mathml.to_owned();
    for letter in 'α'..='ω' {
        let own = format!("<mi class=\"greek\" mathvariant=\"normal\">{letter}</mi>");
        text = text.replace(&format!("<mi>{letter}</mi>"), &own);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rendered(text: &str) -> Outcome<Page> {
        render("docs/a.md", text, &mut |path| match path {
            "docs/b.md" => Ok(Goal::To("b.html".into())),
            "docs/p.png" => Ok(Goal::To("p.png".into())),
            "shared" => Ok(Goal::Words),
            other => Err(format!("no {other}").into()),
        })
    }

    #[test]
    fn links_pictures_and_headings_are_those_of_the_site() {
        let page = rendered(
            "# A `b` c!\n\n[x](b.md#y) [z](../shared) ![w](p.png) [h](https://h)\n\n## A b c\n",
        )
        .unwrap();
        for part in [
            "<h1 id=\"a-b-c\">",
            "<h2 id=\"a-b-c-1\">",
            "<a href=\"b.html#y\">x</a>",
            "<img src=\"p.png\" alt=\"w\" />",
            "<a href=\"https://h\">h</a>",
            " z ",
        ] {
            assert!(page.body.contains(part), "{part} is not in {}", page.body);
        }
        assert_eq!(page.title, "A b c!");
        assert_eq!(page.links, [("b.html".into(), Some("y".into()))]);
        assert!(rendered("[x](c.md)").is_err());
        assert!(rendered("![x](c.png)").is_err());
    }

    #[test]
    fn sections_have_the_words_below_their_headings() {
        let page = rendered(
            "# A `b`\n\nOne *t*wo\nthree.\n\n| x | y |\n|---|---|\n| 1 | 2 |\n\n## C\n\n    code\n",
        )
        .unwrap();
        let words =
            |at: usize| -> Vec<&str> { page.sections[at].text.split_whitespace().collect() };
        assert_eq!(page.sections.len(), 2);
        assert_eq!(
            (&*page.sections[0].anchor, &*page.sections[0].heading),
            ("a-b", "A b")
        );
        assert_eq!(words(0), ["One", "two", "three.", "x", "y", "1", "2"]);
        assert_eq!((&*page.sections[1].heading, words(1)), ("C", vec!["code"]));
    }

    #[test]
    fn greek_letters_need_no_font_of_their_own() {
        let page = rendered("$\\theta \\omega$").unwrap();
        assert!(
            page.body.contains(">θ<") && page.body.contains(">ω<"),
            "{}",
            page.body
        );
        assert!(!page.body.chars().any(|c| u32::from(c) > 0xffff));
    }

    #[test]
    fn equations_are_mathml_and_a_mistake_in_one_is_an_error() {
        let page = rendered("$\\omega^2$ and $$\\frac{a}{b}$$ cost 3 $ or 4 $.").unwrap();
        assert!(page.body.contains("<math") && page.body.contains("<mfrac>"));
        assert!(page.body.contains("3 $ or 4 $"), "{}", page.body);
        assert!(rendered("$\\nosuchthing$").is_err());
    }
}
