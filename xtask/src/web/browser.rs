//! The page in headless Chromium: what its controls do, and its numbers against those of `host-sim`. The site's search, too.

use std::{path::PathBuf, process::Command};

use crate::{
    JobResult,
    command::{self, root},
    desktop::{self, Build},
    python, site, tools,
};

/// What drives the browser and runs the tests.
const PACKAGES: &[&str] = &["axe-playwright-python", "playwright", "pytest"];

/// The environment in `target/page`.
pub fn environment() -> JobResult<PathBuf> {
    python::environment("page", PACKAGES)
}

/// Builds the page and tests it, with the words given to pytest.
pub fn test(words: &[String], build: &Build) -> JobResult {
    let browser = tools::chromium()?;
    let environment = environment()?;
    let page = super::build()?;
    let program = desktop::program("host-sim", build)?;
    let mut tests = Command::new(environment.join("bin/python"));
    tests.current_dir(root().join("web"));
    tests.env("HOST_SIM", program).env("PAGE", &page);
    tests.env("CHROMIUM", browser);
    tests.env("SITE", site::run(true)?);
    tests.env("SHOTS", page.with_file_name("shots"));
    command::run(
        tests
            .args(["-m", "pytest", "-q", "-s", "tests"])
            .args(words),
    )
}
