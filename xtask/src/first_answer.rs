//! What a newcomer waits for: from the sources to the first answer, `host-sim pick`.

use std::{fs, process::Command};

use crate::{
    JobResult,
    command::{self, cargo},
    timing::Stopwatch,
};

/// Builds the program from nothing, asks it where to run, and prints what both took.
pub fn run() -> JobResult {
    // Downloads depend on the network, not on the project.
    command::run(cargo().arg("fetch"))?;
    let folder = command::root().join("target/first-answer");
    command::remove_folder(&folder)?;
    let mut build = cargo();
    build.args(["build", "--release", "--timings", "--package", "host-sim"]);
    build.arg("--target-dir").arg(&folder);
    // Flags and programs of this shell would make another build of it.
    for name in ["RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "CARGO_BUILD_TARGET"] {
        build.env_remove(name);
    }
    let clocks = Stopwatch::start();
    command::run(&mut build)?;
    let built = clocks.spent();

    let answers = folder.join("answer");
    fs::create_dir(&answers)?;
    let program = format!("release/host-sim{}", std::env::consts::EXE_SUFFIX);
    let mut pick = Command::new(folder.join(program));
    let clocks = Stopwatch::start();
    command::run(pick.arg("pick").current_dir(&answers))?;
    let picked = clocks.spent();

    println!("\n{:<28} {:>9} {:>12}", "", "wall, s", "processor, s");
    for (name, spent) in [("build", built), ("pick", picked)] {
        let (wall_s, processor_s) = (spent.wall_s, spent.processor_s);
        println!("{name:<28} {wall_s:>9.1} {processor_s:>12.1}");
    }
    let crates = folder.join("cargo-timings/cargo-timing.html");
    println!("\neach crate's time: {}", crates.display());
    Ok(())
}
