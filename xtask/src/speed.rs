//! What answers cost in processor time, as multiples of what one run of the switch model costs on the same machine in the same minutes:
//! a change that makes an answer dearer shows, on a slow machine as on a quick one.

use std::{
    fs::{self, OpenOptions},
    io::Write,
    process::Command,
};

use crate::{
    JobResult,
    command::{self, root},
    desktop,
    timing::Stopwatch,
};

/// The run that the others are measured by: 200 drive periods of the switch model.
const UNIT: &str =
    "simulate --ratio 2 --cycles 200 --transient 100 --engine switch --cart prescribed";

/// Requests, and how many of these runs each may cost: a quarter more than measured on an AMD EPYC with AVX2 when the line was
/// written.
const REQUESTS: [(&str, f64); 9] = [
    ("pick", 4.2),
    ("pick --nominal", 1.1),
    ("pick --rig beam-170", 5.0),
    ("pick --gap 0:2.4:1.2", 13.0),
    ("pick --objective rop --threshold-n 50 --samples 16", 34.0),
    ("map", 84.0),
    ("sweep --gap 1 --ratio 0.8:4.5:0.05 --direction up", 2.7),
    ("trials --count 8", 33.0),
    ("emulate field --no-log", 9.4),
];

/// Each is asked so often, in turns; the cheapest counts.
const ROUNDS: usize = 3;

/// Where the figures of each run are added.
const FILE: &str = "target/speed.csv";

/// Measures every request, adds a line for each to [`FILE`], and fails if one costs more than it may.
pub fn run() -> JobResult {
    let program = desktop::released()?;
    let folder = root().join("target/speed");
    fs::create_dir_all(&folder)?;
    let all: Vec<&str> = [UNIT].into_iter().chain(REQUESTS.map(|(r, _)| r)).collect();
    let mut cheapest = vec![f64::INFINITY; all.len()];
    for _ in 0..ROUNDS {
        for (request, least) in all.iter().zip(&mut cheapest) {
            let mut asked = Command::new(&program);
            asked.args(request.split(' ')).arg("--quiet");
            let clocks = Stopwatch::start();
            command::output(asked.current_dir(&folder).env("RAYON_NUM_THREADS", "1"))?;
            *least = least.min(clocks.spent().processor_s);
        }
    }
    let commit = command::output(Command::new("git").args(["rev-parse", "--short", "HEAD"]))?;
    let mut file = OpenOptions::new()
        .append(true)
        .create(true)
        .open(root().join(FILE))?;
    let unit = cheapest[0];
    println!(
        "{:<82} {:>12} {:>8} {:>8}",
        "", "processor, s", "runs", "at most"
    );
    println!("{UNIT:<82} {unit:>12.2}");
    let mut dearer = 0;
    for ((request, most), spent) in REQUESTS.iter().zip(&cheapest[1..]) {
        let runs = spent / unit;
        let mark = if runs > *most { "  too many" } else { "" };
        println!("{request:<82} {spent:>12.2} {runs:>8.2} {most:>8.2}{mark}");
        writeln!(file, "{},{request},{spent:.3},{runs:.3}", commit.trim())?;
        dearer += usize::from(runs > *most);
    }
    if dearer > 0 {
        return Err(format!("{dearer} answers cost more than they may").into());
    }
    Ok(())
}
