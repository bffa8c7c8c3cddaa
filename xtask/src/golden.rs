//! The answers of a fixed list of requests, as check sums: a change that is to change no answer is held to them.

use std::{
    collections::{BTreeMap, BTreeSet},
    fmt::Write as _,
    fs,
    path::Path,
    process::Command,
};

use sha2::{Digest, Sha256};

use crate::{
    JobResult,
    command::{self, root},
    desktop,
};

/// The check sums, one line each.
const FILE: &str = "xtask/golden.txt";

const HEAD: &str = "\
# Check sums of the answers of `host-sim`, by `cargo xtask golden --write`. The answers depend neither on the number of
# threads nor on the width of the processor's vectors (docs/lanes.md). Their last digits depend on the C library's sines:
# here those of glibc 2.36 on x86-64 with fused multiply-add.
";

/// A folder for each request, and the request. It may read what an earlier one wrote.
const REQUESTS: &str = "\
pick: pick --samples 4
pick-all: pick --all --nominal --cart prescribed
pick-beside: pick --beside wires,amplitude_mm=1.2 --nominal --cart prescribed
pick-gaps: pick --gap 0:0.4:0.4 --starts 20 --nominal --cart prescribed
pick-over: pick --over mass_kg=0.2,0.3 --nominal --cart prescribed
pick-rop: pick --objective rop --threshold-n 50 --samples 4 --cart prescribed
simulate: simulate --ratio 2
simulate-switch: simulate --ratio 2 --engine switch --cart prescribed
sweep: sweep --ratio 1:4:0.25 --gap 1 --direction up
sweep-over: sweep --ratio 2 --over mass_kg=0.1:1:log4
map: map --gap 0:3:0.5 --ratio 0.8:4:0.1
map-prescribed: map --gap 0:3:0.5 --ratio 0.8:4:0.1 --cart prescribed
orbits: orbits --gap 1 --ratio 1.5:2.5 --starts 4 --behind 20
orbits-curves: orbits --curves --gap 0:1:0.5 --ratio 1:3
orbits-curve: orbits --curve gap_mm=0:1 --ratio 1.5:2.5 --starts 4 --searches 2
drill: drill --threshold-n 25 --ratio 2
drill-published: drill --published --static-force 0.05:0.3:0.05
modes: modes --rig beam-170 --ratio 2 --modes 1,2 --cycles 100
basins: basins --ratio 2 --gap-ratio 2 --grid 20 --samples 50
bifurcation: bifurcation --gap 1 --ratio 1.4:4:0.2 --direction all
poincare: poincare --gap 2.4 --ratio 2.7 --points 100 --lyapunov
poincare-smoothed: poincare --gap 2.4 --ratio 2.7 --points 50 --against smoothed --epsilon-m 1e-6 --cart prescribed
emulate: emulate stale-samples
replay: replay ../emulate/out/stale-samples.parquet --format json
trials: trials --count 2 --seconds 20
chapter: chapter --coarse
figures: figures --coarse --only 3.24,3.35
contact: contact --speed 0.1
contact-figure: contact --figure-3-3
drop: drop --noise-n 0.2
identify: identify ../drop/out/drop-wires-noise-n-0.2.csv --misfit force
identify-coverage: identify --coverage --tests 1 --case noise-1-percent
compare: compare ../simulate/out/simulate-wires-ratio-2-history.csv --ratio 2
";

/// Each request: the folder of its answer, and the command line.
fn requests() -> impl Iterator<Item = (&'static str, &'static str)> {
    REQUESTS.lines().filter_map(|line| line.split_once(": "))
}

/// Runs every request and compares the check sums of its answers with those of [`FILE`], or writes them there.
pub fn run(write: bool) -> JobResult {
    let program = desktop::released()?;
    let all = root().join("target/golden");
    command::remove_folder(&all)?;
    let mut sums = BTreeMap::new();
    for (name, request) in requests() {
        let folder = all.join(name);
        fs::create_dir_all(&folder)?;
        let mut asked = Command::new(&program);
        asked.args(request.split(' ')).arg("--quiet");
        command::announce(&asked);
        let answer = command::output(asked.current_dir(&folder))?;
        // A log is replayed without a folder for files.
        if request.contains("--format json") {
            fs::write(folder.join("answer.json"), answer)?;
        }
        add(&mut sums, &folder, name)?;
    }
    if write {
        return Ok(fs::write(root().join(FILE), text(&sums))?);
    }
    let expected = parse(&fs::read_to_string(root().join(FILE))?);
    let names: BTreeSet<_> = sums.keys().chain(expected.keys()).collect();
    let mut differ = 0;
    for name in names {
        if sums.get(name) != expected.get(name) {
            let of = |(folder, _): &(&str, &str)| name.split('/').next() == Some(folder);
            let request = requests()
                .find(of)
                .map_or("no request", |(_, request)| request);
            println!("differs: {name} ({request})");
            differ += 1;
        }
    }
    if differ > 0 {
        let advice = "if that is meant: cargo xtask golden --write";
        return Err(format!("{differ} files differ; {advice}").into());
    }
    println!("all {} files are as before", sums.len());
    Ok(())
}

/// Adds the sums of the CSV and JSON files below `folder`.
fn add(sums: &mut BTreeMap<String, String>, folder: &Path, name: &str) -> JobResult {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let file = path.file_name().unwrap_or_default().to_string_lossy();
        let named = format!("{name}/{file}");
        if path.is_dir() {
            add(sums, &path, &named)?;
        } else if file.ends_with(".csv") || file.ends_with(".json") {
            sums.insert(named, sum(&fs::read_to_string(&path)?));
        }
    }
    Ok(())
}

/// What differs from build to build: the program's version, and by what `figures` knows its own unfinished work.
const OF_THE_BUILD: [&str; 2] = ["\"version\":", "\"key\": \"host-sim "];

/// The first half of SHA-256, without the lines that begin with one of [`OF_THE_BUILD`].
fn sum(text: &str) -> String {
    let mut hash = Sha256::new();
    for line in text.split_inclusive('\n') {
        if !OF_THE_BUILD
            .iter()
            .any(|begin| line.trim_start().starts_with(begin))
        {
            hash.update(line);
        }
    }
    let mut digits = String::new();
    for byte in &hash.finalize()[..16] {
        let _ = write!(digits, "{byte:02x}");
    }
    digits
}

fn text(sums: &BTreeMap<String, String>) -> String {
    let lines = sums.iter().map(|(name, sum)| format!("{sum} {name}\n"));
    HEAD.to_owned() + &lines.collect::<String>()
}

fn parse(text: &str) -> BTreeMap<String, String> {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let pairs = lines.filter_map(|line| line.split_once(' '));
    pairs.map(|(sum, name)| (name.into(), sum.into())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Those that answer with a table or a figure of an analysis are in the list.
    #[test]
    fn every_command_with_an_answer_is_in_the_list() {
        let none = [
            "scenarios",
            "link",
            "lab",
            "rig",
            "rigs",
            "completions",
            "man",
            "help",
        ];
        let help = root().join("tests/command_line/snapshots/help.txt");
        let help = fs::read_to_string(help).unwrap();
        let commands = help.lines().skip_while(|line| *line != "Commands:").skip(1);
        let commands = commands.map_while(|line| line.split_whitespace().next());
        let commands: Vec<_> = commands.collect();
        assert!(commands.len() > 20, "{commands:?}");
        for command in commands {
            let listed = requests().any(|(_, request)| request.split(' ').next() == Some(command));
            assert!(listed != none.contains(&command), "{command}");
        }
    }

    #[test]
    fn what_is_of_the_build_is_left_out_and_the_file_reads_back() {
        let answer = |version, force| {
            sum(&format!(
                "{{\n  \"version\": \"{version}\",\n  \"key\": \"host-sim {version}\",\n  \"force_n\": {force}\n}}\n"
            ))
        };
        assert_eq!(answer("1", 2), answer("2", 2));
        assert_ne!(answer("1", 2), answer("1", 3));
        let sums = BTreeMap::from([("a/b c.csv".to_owned(), sum("x"))]);
        assert_eq!(parse(&text(&sums)), sums);
    }
}
