//! The site in `target/site`: the pages of `docs/` and those beside them, the documentation of the crates and of the Python
//! package, the chapter's figures, and the page. None of it needs a network.
//!
//! Sphinx makes the pages as `conf.py` says; `contents.md` is their order. Whatever it warns of is an error: a link, anchor or
//! picture that is not there, a page that is not in the order, a mistake in an equation.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use crate::{
    JobResult,
    command::{self, cargo, root},
    desktop, python, web,
};

/// Builds it, or for a check the pages alone; where it is.
pub fn run(check: bool) -> JobResult<PathBuf> {
    let name = if check { "site-check" } else { "site" };
    let place = root().join("target").join(name);
    command::remove_folder(&place)?;
    fs::create_dir_all(&place)?;
    if !check {
        made_elsewhere(&place)?;
    }
    let explore = root().join("target/web/index.html");
    if explore.exists() {
        fs::copy(explore, place.join("explore.html"))?;
    }
    pages(&place)?;
    println!("no dead link: {}", place.join("index.html").display());
    Ok(place)
}

/// Has Sphinx write every page into `place`, with links to what is there.
fn pages(place: &Path) -> JobResult {
    let own = root().join("xtask/src/site");
    let packages = own.join("requirements.txt").display().to_string();
    let environment = python::environment("sphinx", &["--requirement", &packages])?;
    let mut sphinx = Command::new(environment.join("bin/sphinx-build"));
    // Nothing is taken from the run before (`-E`): what it warned of would be forgotten.
    sphinx.args(["-E", "-n", "-q", "-W", "--keep-going", "-d"]);
    sphinx.arg(environment.join("doctrees")).arg("-c").arg(own);
    command::run(sphinx.arg(root()).arg(place))
}

/// The documentation that other programs make, and the page in `target/web`, each left out with a line where it cannot be had.
fn made_elsewhere(place: &Path) -> JobResult {
    web::build_if_possible()?;
    // The gallery: a later run makes only what has changed.
    let figures = root().join("target/figures");
    let mut make = Command::new(desktop::released()?);
    command::run(make.args(["figures", "--out"]).arg(&figures))?;
    gallery(&figures, &place.join("figures"))?;
    let mut doc = cargo();
    doc.args(["doc", "--workspace", "--no-deps"]);
    command::run(doc.env("RUSTDOCFLAGS", "-D warnings"))?;
    let target = std::env::var_os("CARGO_TARGET_DIR");
    let doc = target.map_or_else(|| root().join("target"), PathBuf::from);
    let mut copy = Command::new("cp");
    copy.arg("-r").arg(doc.join("doc"));
    command::run(copy.arg(place.join("rust")))?;
    if let Err(error) = python_docs(place) {
        println!("the Python package's documentation is left out: {error}");
    }
    Ok(())
}

/// The page of the figures with its pictures, without its tables, which are some 400 MB.
fn gallery(from: &Path, to: &Path) -> JobResult {
    fs::create_dir(to)?;
    for file in fs::read_dir(from)? {
        let path = file?.path();
        if path
            .extension()
            .is_some_and(|end| end == "png" || end == "svg")
        {
            fs::copy(&path, to.join(path.file_name().unwrap_or_default()))?;
        }
    }
    let page = fs::read_to_string(from.join("index.html"))?;
    let lines = page.lines().filter(|line| !line.contains("<dt>Files</dt>"));
    fs::write(to.join("index.html"), lines.collect::<Vec<_>>().join("\n"))?;
    Ok(())
}

/// Written by pdoc from the installed package.
fn python_docs(place: &Path) -> JobResult {
    let environment = python::own_environment()?;
    command::run(python::pip(&environment).arg("pdoc>=15,<17"))?;
    python::install(&environment)?;
    let mut pdoc = Command::new(environment.join("bin/pdoc"));
    pdoc.args(["--docformat", "numpy", "--output-directory"]);
    command::run(pdoc.arg(place.join("python-api")).arg("vibroimpact"))
}
