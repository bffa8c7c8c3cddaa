//! The site in `target/site`: the pages of `docs/` and those beside them, the documentation of the crates and of the Python
//! package, and the page. None of it needs a network.
//!
//! Sphinx makes the pages as `conf.py` says; `contents.md` is their order. Whatever it warns of is an error: a link, anchor or
//! picture that is not there, a page that is not in the order, a mistake in an equation.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

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

/// Builds it.
pub fn run(plan: &Plan) -> Outcome {
    let place = match plan {
        Plan::Whole => root().join("target/site"),
        Plan::Check => root().join("target/site-check"),
    };
    let part = emptied(place.with_extension("part"))?;
    let made = match plan {
        Plan::Whole => made_elsewhere(&part)?,
        Plan::Check => Vec::new(),
    };
    pages(&part, &made)?;
    fs::rename(&part, emptied(place.clone())?)?;
    println!("no dead link: {}", place.join("index.html").display());
    Ok(())
}

/// Writes the pages alone into a folder of `target`; for a browser's tests.
pub fn pages_for_tests() -> Outcome<PathBuf> {
    let place = emptied(root().join("target/site-in-browser"))?;
    pages(&place, &[])?;
    Ok(place)
}

/// A folder with nothing in it.
fn emptied(place: PathBuf) -> Outcome<PathBuf> {
    if place.exists() {
        fs::remove_dir_all(&place)?;
    }
    fs::create_dir_all(&place)?;
    Ok(place)
}

/// Has Sphinx write every page into `place`, with links to what was `made` elsewhere.
fn pages(place: &Path, made: &[&str]) -> Outcome {
    let own = root().join("xtask/src/site");
    let packages = own.join("requirements.txt").display().to_string();
    let environment = python::environment("sphinx", &["--requirement", &packages])?;
    let mut sphinx = Command::new(environment.join("bin/sphinx-build"));
    // Nothing is kept of the run before: what it warned of would be forgotten.
    let kept = emptied(place.with_extension("doctrees"))?;
    sphinx.args(["-q", "-n", "-W", "--keep-going"]);
    for name in made {
        sphinx.args(["-A", &format!("{name}=1")]);
    }
    sphinx.arg("-d").arg(&kept).arg("-c").arg(own);
    command::run(sphinx.arg(root()).arg(place))?;
    Ok(fs::remove_dir_all(kept)?)
}

/// The documentation that other programs make, and the page, each left out with a line where it cannot be had. Their names are
/// those of `elsewhere.html`.
fn made_elsewhere(place: &Path) -> Outcome<Vec<&'static str>> {
    let mut made = vec!["rust"];
    if let Some(page) = web::build_if_possible()? {
        fs::copy(page, place.join("explore.html"))?;
        made.push("page");
    }
    let mut doc = cargo();
    doc.args(["doc", "--workspace", "--no-deps"]);
    command::run(doc.env("RUSTDOCFLAGS", "-D warnings"))?;
    copy_folder(&target_folder().join("doc"), &place.join("rust"))?;
    match python_docs(place) {
        Ok(()) => made.push("python"),
        Err(error) => println!("the Python package's documentation is left out: {error}"),
    }
    Ok(made)
}

/// Written by pdoc from the installed package.
fn python_docs(place: &Path) -> Outcome {
    let environment = python::own_environment()?;
    command::run(python::pip(&environment).arg("pdoc>=15,<17"))?;
    python::install(&environment)?;
    let mut pdoc = Command::new(environment.join("bin/pdoc"));
    pdoc.args(["--docformat", "numpy", "--output-directory"]);
    command::run(pdoc.arg(place.join("python-api")).arg("vibroimpact"))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_read() {
        assert_eq!(Plan::parse(&[]), Ok(Plan::Whole));
        assert_eq!(Plan::parse(&["--check"]), Ok(Plan::Check));
        assert!(Plan::parse(&["--chek"]).is_err());
    }
}
