//! The Python package: built as a wheel and installed into an environment of its own, or, after the host tests, with the library that
//! they have built; tested against the command line.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use crate::{
    JobResult,
    command::{self, find, root},
    desktop::{self, Build},
};

/// What builds the wheel and runs its tests, beside the package's own `numpy`.
const PACKAGES: &[&str] = &["maturin>=1.9,<2", "numpy", "pandas", "xarray", "pytest"];

/// What runs the notebooks, and the map that a Dask cluster makes. Without them those tests are left out.
const NOTEBOOKS: &[&str] = &[
    "matplotlib",
    "nbclient",
    "nbformat",
    "ipykernel",
    "distributed",
    "zarr",
];

/// Runs the package's tests with the words given: of a wheel installed into `target/python`, or with the library that the host tests
/// have built, which a wheel would build again.
pub fn run(words: &[String], build: &Build) -> JobResult {
    let environment = own_environment()?;
    if let Err(error) = command::run(pip(&environment).args(NOTEBOOKS)) {
        println!("the notebooks and the Dask cluster are left out: {error}");
    }
    let mut tests = Command::new(environment.join("bin/python"));
    match build {
        Build::Alone => install(&environment)?,
        Build::Tested => {
            tests.env(
                "PYTHONPATH",
                laid_out(&desktop::library("vibroimpact_native")?)?,
            );
        }
    }
    let program = desktop::program("host-sim", build)?;
    tests.current_dir(root().join("python"));
    tests.env("HOST_SIM", program);
    command::run(tests.args(["-m", "pytest", "-q"]).args(words))
}

/// The folder with the package and its library in it, as a wheel has them.
fn laid_out(library: &Path) -> JobResult<PathBuf> {
    let place = root().join("target/python-package");
    let package = place.join("vibroimpact");
    command::remove_folder(&place)?;
    fs::create_dir_all(&package)?;
    for file in fs::read_dir(root().join("python/package/vibroimpact"))? {
        let file = file?;
        if file.file_type()?.is_file() {
            fs::copy(file.path(), package.join(file.file_name()))?;
        }
    }
    fs::copy(library, package.join("_native.abi3.so"))?;
    Ok(place)
}

/// Builds the wheel and installs it into the environment.
pub fn install(environment: &Path) -> JobResult {
    let place = root().join("target/wheels");
    command::remove_folder(&place)?;
    let mut maturin = Command::new(environment.join("bin/maturin"));
    // In the profile of the tests: the same numbers as a release, compiled once for both.
    maturin.args(["build", "--locked", "--profile", "dev"]);
    let wheel = wheel(maturin, environment, &place)?;
    let mut install = pip(environment);
    command::run(install.args(["--force-reinstall", "--no-deps"]).arg(&wheel))
}

/// The environment in `target/python`, with what builds the package and runs its tests in it.
pub fn own_environment() -> JobResult<PathBuf> {
    environment("python", PACKAGES)
}

/// The environment in the folder `target/NAME`, with these packages in it.
pub fn environment(name: &str, packages: &[&str]) -> JobResult<PathBuf> {
    let place = root().join("target").join(name);
    if !place.join("bin/python").exists() {
        make_environment(&place)?;
    }
    command::run(pip(&place).args(packages))?;
    Ok(place)
}

/// Makes an empty environment.
pub fn make_environment(place: &Path) -> JobResult {
    let python = find("python3").ok_or(ADVICE)?;
    let mut make = Command::new(python);
    make.args(["-m", "venv"]).arg(place);
    command::run(&mut make).map_err(|error| format!("{error}; {ADVICE}").into())
}

const ADVICE: &str = "this needs Python 3.9 or later with venv (Debian: apt-get install --no-install-recommends python3-venv)";

/// Installs into an environment what it is given.
pub fn pip(environment: &Path) -> Command {
    let mut pip = Command::new(environment.join("bin/python"));
    pip.args([
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
    ]);
    pip
}

/// The wheel that maturin, told what to build, leaves in a folder.
pub fn wheel(mut maturin: Command, environment: &Path, place: &Path) -> JobResult<PathBuf> {
    maturin
        .current_dir(root().join("python"))
        .arg("--out")
        .arg(place);
    maturin
        .arg("--interpreter")
        .arg(environment.join("bin/python"));
    command::run(&mut maturin)?;
    let built = fs::read_dir(place)?
        .next()
        .ok_or("maturin left no wheel")??;
    Ok(built.path())
}
