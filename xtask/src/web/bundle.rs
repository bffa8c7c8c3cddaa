//! Puts the page into one file: its style, its scripts and the module stand in it, so that it opens from a disk, from a
//! server and without a network alike.
//!
//! A script is a module in the sense of the language, in a narrow form, so that a few lines can join them: whole lines
//! `import { a, b as c } from "./other.js";` at the top, and `export` before `function`, `async function`, `class` or
//! `const`. Each becomes a function that is run once, after those that it imports from.

use std::{
    fs,
    path::{Component, Path, PathBuf},
};

use crate::JobResult;

/// The page in `folder` with the module's letters in it.
pub fn page(folder: &Path, module: &str) -> JobResult<String> {
    let template = fs::read_to_string(folder.join("index.html"))?;
    let mut page = String::new();
    for line in template.lines() {
        let indented = line.trim();
        if let Some(name) = between(indented, r#"<link rel="stylesheet" href=""#, r#"">"#) {
            page += &format!(
                "<style>\n{}</style>",
                fs::read_to_string(folder.join(name))?
            );
        } else if let Some(rest) = between(indented, "<script", "></script>") {
            page += &script(folder, rest, module)?;
        } else {
            page += line;
        }
        page.push('\n');
    }
    Ok(page)
}

/// The script element with these attributes: ` src="main.js" …` has its code, ` … id="module"` the module's letters.
fn script(folder: &Path, attributes: &str, module: &str) -> JobResult<String> {
    if attributes.contains(r#"id="module""#) {
        return Ok(format!("<script{attributes}>{module}</script>"));
    }
    let (before, rest) = attributes
        .split_once(r#" src=""#)
        .ok_or_else(|| format!("a script without src: {attributes}"))?;
    let (name, after) = rest.split_once('"').ok_or("a src without end")?;
    let code = Joined::from(folder, name)?;
    if code.to_ascii_lowercase().contains("</script") {
        return Err(format!("{name}: a script may not say </script").into());
    }
    Ok(format!("<script{before}{after}>\n{code}</script>"))
}

fn between<'a>(line: &'a str, before: &str, after: &str) -> Option<&'a str> {
    line.strip_prefix(before)?.strip_suffix(after)
}

/// Scripts, each after those it needs.
#[derive(Default)]
struct Joined {
    /// Those that are in, as paths from the folder.
    names: Vec<PathBuf>,
    /// Those that wait for what they import: to find circles.
    waiting: Vec<PathBuf>,
    code: String,
}

impl Joined {
    fn from(folder: &Path, name: &str) -> JobResult<String> {
        let mut joined = Self::default();
        joined.add(folder, Path::new(name))?;
        Ok(format!(
            "\"use strict\";\n(() => {{\nconst modules = [];\n{}}})();\n",
            joined.code
        ))
    }

    /// Adds a script; its number.
    fn add(&mut self, folder: &Path, path: &Path) -> JobResult<usize> {
        if let Some(number) = self.names.iter().position(|known| known == path) {
            return Ok(number);
        }
        let shown = path.display();
        if self.waiting.iter().any(|known| known == path) {
            return Err(format!("{shown} imports itself, by way of others").into());
        }
        self.waiting.push(path.into());
        let text = fs::read_to_string(folder.join(path)).map_err(|e| format!("{shown}: {e}"))?;
        let mut exports = Vec::new();
        let mut body = String::new();
        for (number, line) in text.lines().enumerate() {
            let wrong = |what: &str| format!("{shown}, line {}: {what}: {line}", number + 1);
            if line.starts_with("import") {
                let (names, from) = import(line).ok_or_else(|| {
                    wrong("an import must read: import { a, b as c } from \"./other.js\";")
                })?;
                let above = path.parent().unwrap_or(Path::new(""));
                let other = self.add(folder, &tidied(&above.join(from)))?;
                body += &format!(
                    "const {{ {} }} = modules[{other}];",
                    names.replace(" as ", ": ")
                );
            } else if let Some(rest) = line.strip_prefix("export ") {
                let name = exported(rest).ok_or_else(|| {
                    wrong("export must stand before function, async function, class or const")
                })?;
                exports.push(name.to_owned());
                body += rest;
            } else {
                body += line;
            }
            body.push('\n');
        }
        self.waiting.pop();
        let number = self.names.len();
        self.names.push(path.into());
        self.code += &format!(
            "modules[{number}] = (() => {{ // {shown}\n{body}return {{ {} }};\n}})();\n",
            exports.join(", ")
        );
        Ok(number)
    }
}

/// The names and the file of `import { … } from "…";`.
fn import(line: &str) -> Option<(&str, &str)> {
    let (names, from) = line.strip_prefix("import { ")?.split_once(" } from \"")?;
    Some((names, from.strip_suffix("\";")?))
}

/// The name that is declared at the beginning of `rest`.
fn exported(rest: &str) -> Option<&str> {
    let kinds = ["function ", "async function ", "class ", "const "];
    let rest = kinds.iter().find_map(|kind| rest.strip_prefix(kind))?;
    let end = rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_'))?;
    (end > 0).then_some(&rest[..end])
}

/// A path without `.` and `..`.
fn tidied(path: &Path) -> PathBuf {
    let mut tidied = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => drop(tidied.pop()),
            other => tidied.push(other),
        }
    }
    tidied
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        folder
    }

    #[test]
    fn each_script_stands_once_after_those_it_needs() {
        let folder = folder(&[
            (
                "main.js",
                "import { a } from \"./one/a.js\";\nimport { b as c } from \"./b.js\";\na(c);\n",
            ),
            (
                "one/a.js",
                "import { b } from \"../b.js\";\nexport function a() { return b; }\n",
            ),
            ("b.js", "export const b = 1;\n"),
        ]);
        let code = Joined::from(folder.path(), "main.js").unwrap();
        let at = |text: &str| code.find(text).unwrap_or_else(|| panic!("{text}: {code}"));
        assert!(at("// b.js") < at("// one/a.js") && at("// one/a.js") < at("// main.js"));
        assert_eq!(code.matches("const b = 1").count(), 1);
        assert!(code.contains("const { b: c } = modules[0];"), "{code}");
        assert!(code.contains("return { a };"), "{code}");
    }

    #[test]
    fn what_cannot_be_joined_is_named_with_its_line() {
        for (text, part) in [
            ("import \"./b.js\";\n", "line 1"),
            ("let a;\nexport default a;\n", "line 2"),
            ("import { a } from \"./main.js\";\n", "imports itself"),
            ("import { a } from \"./gone.js\";\n", "gone.js"),
        ] {
            let folder = folder(&[("main.js", text)]);
            let line = Joined::from(folder.path(), "main.js")
                .unwrap_err()
                .to_string();
            assert!(line.contains(part), "{line}");
        }
    }

    #[test]
    fn style_scripts_and_module_stand_in_the_page() {
        let template = "<link rel=\"stylesheet\" href=\"a.css\">\n<script type=\"text/plain\" id=\"module\"></script>\n\
                        <script type=\"text/plain\" id=\"w\" src=\"main.js\"></script>\n<p>on</p>\n";
        let folder = folder(&[
            ("index.html", template),
            ("a.css", "p {}\n"),
            ("main.js", "go();\n"),
        ]);
        let page = page(folder.path(), "QUJD").unwrap();
        assert!(page.contains("<style>\np {}\n</style>"), "{page}");
        assert!(page.contains("id=\"module\">QUJD</script>"), "{page}");
        assert!(page.contains("id=\"w\">\n\"use strict\";"), "{page}");
        assert!(
            page.contains("<p>on</p>") && !page.contains("src="),
            "{page}"
        );
    }
}
