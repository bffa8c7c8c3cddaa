//! What is handed out: an archive with the program and all that belongs to it, the wheel of the Python package, the page,
//! and their checksums, in `target/dist`.

mod archive;
mod build;
mod licences;

use std::{fs, path::Path, process::Command};

use archive::Files;
use build::Linking;

use crate::{
    JobResult,
    command::{self, root},
    desktop::{self, Build},
    python, web,
};

/// Builds everything and tries it.
pub fn whole() -> JobResult {
    let target = build::target()?;
    // Quick, and the likeliest to fail: it comes first.
    let licences = licences::gather(&target)?;
    let linking = Linking::choose(&target)?;
    let page = web::build_if_possible()?;
    let program = linking.program(&target, page.is_some())?;
    let seconds = archive::time()?;

    let place = root().join("target/dist");
    let part = root().join("target/dist.part");
    command::remove_folder(&place)?;
    command::remove_folder(&part)?;
    fs::create_dir_all(&part)?;
    let wheel = linking.wheel(&target, &part, seconds)?;
    let mut handed_out = vec![wheel.clone()];
    if let Some(page) = &page {
        let path = part.join("vibroimpact.html");
        archive::write(&path, &fs::read(page)?)?;
        handed_out.push(path);
    }
    let needs = linking.needs();
    let files = files(&program, &licences, page.as_deref(), &needs)?;
    let path = part.join(format!("{}.tar.gz", name(&target)));
    archive::write(&path, &files.archive(&name(&target), seconds)?)?;
    handed_out.push(path);
    handed_out.sort();
    archive::write(
        &part.join("SHA256SUMS"),
        archive::sums(&handed_out)?.as_bytes(),
    )?;

    println!("\nthe program {needs}");
    println!("{}", wheel_tried(&wheel)?);
    fs::rename(&part, &place)?;
    for file in fs::read_dir(&place)? {
        let file = file?;
        let megabytes = file.metadata()?.len() as f64 / 1e6;
        println!("{:>7.2} MB  {}", megabytes, file.path().display());
    }
    Ok(())
}

/// The name of the archive and of the folder in it.
fn name(target: &str) -> String {
    format!("vibroimpact-{}-{target}", env!("CARGO_PKG_VERSION"))
}

/// What stands in the archive.
fn files(program: &Path, licences: &str, page: Option<&Path>, needs: &str) -> JobResult<Files> {
    let mut files = Files::default();
    files.add_program(
        format!("bin/host-sim{}", std::env::consts::EXE_SUFFIX),
        fs::read(program)?,
    );
    for (shell, path) in COMPLETIONS {
        let script = command::output(Command::new(program).args(["completions", shell]))?;
        files.add(*path, script);
    }
    let pages = root().join("target/man.part");
    command::remove_folder(&pages)?;
    command::output(Command::new(program).arg("man").arg(&pages))?;
    files.add_folder("share/man/man1", &pages)?;
    fs::remove_dir_all(&pages)?;
    for name in ["README.md", "LICENSE", "CHANGELOG.md"] {
        files.add(name, fs::read(root().join(name))?);
    }
    files.add_folder("docs", &root().join("docs"))?;
    files.add("LICENSES-OF-DEPENDENCIES.txt", licences);
    files.add("INSTALL.txt", install(needs));
    if let Some(page) = page {
        files.add("vibroimpact.html", fs::read(page)?);
    }
    Ok(files)
}

/// The shells, and where each looks for what it completes.
const COMPLETIONS: &[(&str, &str)] = &[
    ("bash", "share/bash-completion/completions/host-sim"),
    ("zsh", "share/zsh/site-functions/_host-sim"),
    ("fish", "share/fish/vendor_completions.d/host-sim.fish"),
];

fn install(needs: &str) -> String {
    format!(
        "bin/host-sim runs from wherever it stands; it {needs}.\n\n\
         To have it in the path, with its manual and the completions of the shell, for all users of the machine:\n\n    \
         sudo cp -r bin share /usr/local/\n\n\
         For yourself alone, with ~/.local/bin in the path:\n\n    \
         cp -r bin share ~/.local/\n\n\
         Begin with README.md.\n"
    )
}

/// The wheel in an environment with nothing else in it.
fn wheel_tried(wheel: &Path) -> JobResult<String> {
    let place = root().join("target/dist-environment");
    command::remove_folder(&place)?;
    python::make_environment(&place)?;
    command::run(python::pip(&place).arg(wheel))?;
    let script = "import vibroimpact as vi; print(vi.pick(vi.Rig('wires')).operating_frequency_hz)";
    let mut python = Command::new(place.join("bin/python"));
    let answer = command::output(python.args(["-c", script]).current_dir("/"))?;
    fs::remove_dir_all(&place)?;
    Ok(format!(
        "the wheel, in an environment of its own: pick gives {} Hz",
        answer.trim()
    ))
}

/// The files that an archive must have.
const EXPECTED: &[&str] = &[
    "CHANGELOG.md",
    "INSTALL.txt",
    "LICENSE",
    "LICENSES-OF-DEPENDENCIES.txt",
    "README.md",
    "bin/host-sim",
    "docs/tutorial.md",
    "share/bash-completion/completions/host-sim",
    "share/fish/vendor_completions.d/host-sim.fish",
    "share/man/man1/host-sim-pick.1",
    "share/man/man1/host-sim.1",
    "share/zsh/site-functions/_host-sim",
];

/// Packs the program of the tests twice, and holds the archive to what it must be.
pub fn check(build: &Build) -> JobResult {
    let target = build::target()?;
    let licences = licences::gather(&target)?;
    let program = desktop::program("host-sim", build)?;
    let needs = "is the program of the tests";
    let files = files(&program, &licences, None, needs)?;
    if let Some(missing) = EXPECTED
        .iter()
        .find(|&&path| !files.paths().any(|there| there == path))
    {
        return Err(format!("the archive has no {missing}").into());
    }
    let seconds = archive::time()?;
    let once = files.archive(&name(&target), seconds)?;
    let again = self::files(&program, &licences, None, needs)?.archive(&name(&target), seconds)?;
    if once != again {
        return Err("packed twice, the same program gives two archives".into());
    }
    println!(
        "{} files, {:.1} MB, the same bytes twice",
        files.paths().count(),
        once.len() as f64 / 1e6,
    );
    Ok(())
}
