//! What a newcomer waits for: from the sources to the first answer, `host-sim pick`.

use std::{fs, path::PathBuf, process::Command};

use crate::{
    JobResult,
    command::{self, cargo},
    timing::{self, Crate, Spent, Stopwatch},
};

/// How many crates are listed.
const LISTED: usize = 10;

/// What is asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FirstAnswerPlan {
    /// Also write the figures to this file.
    pub json: Option<PathBuf>,
}

impl FirstAnswerPlan {
    /// Reads the options behind `cargo xtask first-answer`.
    pub fn parse(words: &[&str]) -> Result<Self, String> {
        match words {
            [] => Ok(Self::default()),
            ["--json", file] => Ok(Self {
                json: Some(file.into()),
            }),
            ["--json"] => Err("--json wants a file".into()),
            [other, ..] => Err(format!("no option `{other}`; see `cargo xtask help`")),
        }
    }
}

/// Builds the program from nothing, asks it where to run, and prints what both took.
pub fn run(plan: &FirstAnswerPlan) -> JobResult {
    // Downloads depend on the network, not on the project.
    command::run(cargo().arg("fetch"))?;
    let folder = command::root().join("target/first-answer");
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    fs::create_dir_all(&folder)?;
    let times = folder.join("rustc-times");
    let mut build = cargo();
    build.args(["build", "--release", "--package", "host-sim"]);
    build.arg("--target-dir").arg(&folder);
    // Flags and programs of this shell would make another build of it.
    for name in ["RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "CARGO_BUILD_TARGET"] {
        build.env_remove(name);
    }
    timing::record(&mut build, &times)?;
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

    let crates = timing::crates(&fs::read_to_string(&times)?)?;
    print(built, picked, &crates);
    if let Some(file) = &plan.json {
        fs::write(file, json(built, picked, &crates))
            .map_err(|e| format!("cannot write {}: {e}", file.display()))?;
    }
    Ok(())
}

fn print(built: Spent, picked: Spent, crates: &[Crate]) {
    println!("\n{:<28} {:>9} {:>12}", "", "wall, s", "processor, s");
    let line = |name: &str, spent: Spent| {
        println!(
            "{name:<28} {:>9.1} {:>12.1}",
            spent.wall_s, spent.processor_s
        );
    };
    line("build", built);
    line("pick", picked);
    println!("\nthe dearest of {} crates:", crates.len());
    for each in crates.iter().take(LISTED) {
        line(&each.name, each.spent);
    }
}

fn json(built: Spent, picked: Spent, crates: &[Crate]) -> String {
    let times = |spent: Spent| {
        format!(
            "\"wall_s\": {:.3}, \"processor_s\": {:.3}",
            spent.wall_s, spent.processor_s
        )
    };
    let listed: Vec<_> = crates
        .iter()
        .take(LISTED)
        .map(|each| {
            format!(
                "    {{ \"name\": \"{}\", {}, \"compilations\": {} }}",
                each.name,
                times(each.spent),
                each.times
            )
        })
        .collect();
    format!(
        "{{\n  \"build\": {{ {} }},\n  \"pick\": {{ {} }},\n  \"crates\": {},\n  \"dearest\": [\n{}\n  ]\n}}\n",
        times(built),
        times(picked),
        crates.len(),
        listed.join(",\n")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_read() {
        assert_eq!(FirstAnswerPlan::parse(&[]), Ok(FirstAnswerPlan::default()));
        let plan = FirstAnswerPlan::parse(&["--json", "a.json"]).unwrap();
        assert_eq!(plan.json, Some("a.json".into()));
        assert!(FirstAnswerPlan::parse(&["--json"]).is_err());
        assert!(
            FirstAnswerPlan::parse(&["--fast"])
                .unwrap_err()
                .contains("--fast")
        );
    }

    #[test]
    fn the_file_holds_the_figures() {
        let crates = timing::crates("clap 1.5 2.5\n").unwrap();
        let spent = crates[0].spent;
        let expected = "{\n  \"build\": { \"wall_s\": 1.500, \"processor_s\": 2.500 },\n  \
             \"pick\": { \"wall_s\": 1.500, \"processor_s\": 2.500 },\n  \"crates\": 1,\n  \"dearest\": [\n    \
             { \"name\": \"clap\", \"wall_s\": 1.500, \"processor_s\": 2.500, \"compilations\": 1 }\n  ]\n}\n";
        assert_eq!(json(spent, spent, &crates), expected);
    }
}
