//! Other solvers on the hammer's map, beside ours: cells, our runs, a Rust crate's, and the comparison.
//!
//! `run.sh` drives it.

mod crate_peer;
mod judge;

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::time::Duration;

use cpu_time::ProcessTime;
use numerics::engine::Engine;
use numerics::lanes::{self, Cell, CellOutcome, CellPlan, LaneStrobe};
use serde::{Deserialize, Serialize};
use shared::model::params::{RigParams, WIRES};

/// Drive cycles of a simulation.
pub const CYCLES: u32 = 300;
/// Of them recorded.
pub const RECORDED: u32 = 100;

/// 136 cells of the wires map: 8 gaps by 17 frequencies, spread over the chapter's ranges.
fn cells() -> Vec<Cell> {
    let gap = |i: u32| 0.5e-3 * f64::from(i);
    let hz = |j: u32| (141.0 + 36.0 * f64::from(j)) / 100.0;
    let cell = |i, j| Cell {
        params: RigParams {
            gap_m: gap(i),
            ..WIRES
        },
        frequency_hz: hz(j),
        start: [-(gap(i) / 0.075).asin(), 0.0],
        phase: 0.0,
    };
    (0..8)
        .flat_map(|i| (0..17).map(move |j| cell(i, j)))
        .collect()
}

/// How long a solver took.
#[derive(Debug, Serialize, Deserialize)]
pub struct Timing {
    /// The solver.
    pub name: String,
    /// Drive cycles run.
    pub cycles: u64,
    /// Processor time, s.
    pub cpu_s: f64,
}

/// The strobes of each cell, one more than recorded: the first opens the record.
pub type Strobes = Vec<(usize, Vec<LaneStrobe>)>;

/// Writes OUT/NAME.csv and OUT/NAME.json.
fn write(out: &Path, name: &str, strobes: &Strobes, timing: &Timing) -> Result<(), Box<dyn Error>> {
    let mut text = String::from("cell,q,v,onsets,force_n\n");
    for (cell, strobes) in strobes {
        for s in strobes {
            writeln!(text, "{cell},{:?},{:?},{},{:?}", s.q, s.v, s.onsets, s.force_n)?;
        }
    }
    fs::write(out.join(format!("{name}.csv")), text)?;
    let timing = serde_json::to_string(timing)?;
    fs::write(out.join(format!("{name}.json")), timing)?;
    Ok(())
}

/// Runs `work` again and again for a second, and gives its processor time.
fn timed<T>(mut work: impl FnMut() -> T) -> (T, f64) {
    let start = ProcessTime::now();
    let mut runs = 0.0;
    loop {
        let result = work();
        runs += 1.0;
        let took = start.elapsed();
        if took > Duration::from_secs(1) {
            return (result, took.as_secs_f64() / runs);
        }
    }
}

fn ours(out: &Path) -> Result<(), Box<dyn Error>> {
    let plan = CellPlan {
        cycles: CYCLES,
        recorded: RECORDED,
        early: false,
        strobes: RECORDED + 1,
    };
    let cells = cells();
    let one_core = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    type Run<'a> = &'a (dyn Fn() -> Vec<CellOutcome> + Sync);
    let fast = || lanes::run(&cells, &plan).expect("the map's cells run");
    let reference = || -> Vec<CellOutcome> {
        let all = lanes::each_by_engine(Engine::Event, &cells, &plan).into_iter();
        all.map(|one| one.expect("the map's cells run")).collect()
    };
    let engines: [(&str, &str, Run); 2] = [
        ("ours", "numerics::lanes::run", &fast),
        ("reference", "this project's reference (order 8, 1e-12)", &reference),
    ];
    for (name, title, run) in engines {
        let (outcomes, cpu_s) = one_core.install(|| timed(run));
        let strobes = outcomes
            .into_iter()
            .map(|o| o.strobes)
            .enumerate()
            .collect();
        let timing = Timing {
            name: title.into(),
            cycles: cells.len() as u64 * u64::from(CYCLES),
            cpu_s,
        };
        write(out, name, &strobes, &timing)?;
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<_> = std::env::args().skip(1).collect();
    match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["cells"] => {
            println!("gap_mm,frequency_hz");
            for cell in cells() {
                println!("{:.2},{:.2}", cell.params.gap_m * 1e3, cell.frequency_hz);
            }
            Ok(())
        }
        ["ours", out] => ours(out.as_ref()),
        ["crate", out] => crate_peer::run(&cells(), out.as_ref()),
        ["judge", out] => judge::run(&cells(), out.as_ref()),
        _ => Err("say cells, ours OUT, crate OUT or judge OUT".into()),
    }
}
