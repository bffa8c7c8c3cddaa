//! `host-sim pil`: the desktop's half of the processor in the loop. `cargo xtask pil` starts it, and the emulated
//! processor at the other end of the pipes.

use std::fs::{File, OpenOptions};
use std::path::{Path, PathBuf};

use super::terminal::print;
use emulator::in_the_loop::{InTheLoop, end};
use emulator::run::run as run_scenario;
use emulator::scenario::{Scenario, load};
use files::UserError;
use files::range::within;

/// Cycles per tick of a processor at 180 MHz with ticks at 20 kHz.
const CYCLES_PER_TICK: f64 = 180e6 / 20e3;

/// The desktop's half of `cargo xtask pil`
#[derive(Debug, clap::Args)]
#[command(hide = true)]
pub struct Args {
    /// Pipe to the processor
    #[arg(long, value_name = "PIPE")]
    requests: PathBuf,
    /// Pipe from the processor
    #[arg(long, value_name = "PIPE")]
    replies: PathBuf,
    /// Built-in scenario or FILE.toml
    #[arg(long, value_name = "NAME")]
    scenario: String,
    /// Rig time of each run, s [default: the scenario's]
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
    /// Runs, each with the next seed
    #[arg(long, value_name = "N", default_value_t = 1)]
    runs: u32,
}

/// Runs the scenario. The exit code is 1 if the two controllers differed.
///
/// # Errors
/// If the scenario cannot be run, or the other processor does not answer.
pub fn run(args: &Args) -> Result<i32, UserError> {
    let mut scenario = load(&args.scenario)?;
    if let Some(seconds) = args.seconds {
        scenario.duration_s = within("--seconds", seconds, 0.001, 172_800.0)?;
    }
    // In the order in which the other side opens them.
    let mut requests = open(&args.requests, OpenOptions::new().write(true))?;
    let mut replies = open(&args.replies, OpenOptions::new().read(true))?;
    let mut all = Vec::new();
    let mut code = 0;
    for _ in 0..args.runs {
        let settings = scenario.settings;
        let mut both = InTheLoop::begin(requests, replies, &settings)?;
        run_scenario(&scenario, &mut both, &mut ())?;
        if let Some(why) = both.broken() {
            return Err(UserError::new(why));
        }
        code = code.max(report(&scenario, &both));
        all.extend(both.instructions_per_tick());
        (requests, replies) = both.release();
        scenario.seed = scenario.seed.wrapping_add(1);
    }
    end(&mut requests)?;
    all.sort_unstable();
    if let (Some(median), Some(worst)) = (all.get(all.len() / 2), all.last()) {
        let share = |count: u32| 100.0 * f64::from(count) / CYCLES_PER_TICK;
        print(&format!(
            "instructions per control tick (each block's mean): median {median}, worst {worst}\n\
             if each took one cycle, which is not measured here, they were {:.0} % and {:.0} % of a 180 MHz core at 20 kHz\n",
            share(*median),
            share(*worst)
        ));
    }
    Ok(code)
}

fn open(path: &Path, options: &OpenOptions) -> Result<File, UserError> {
    options.open(path).map_err(|e| {
        UserError::new(format!(
            "cannot open the pipe {}: {e}; `cargo xtask pil` makes it",
            path.display()
        ))
    })
}

/// Prints how a run compares, and returns the exit code.
fn report(scenario: &Scenario, both: &InTheLoop<File, File>) -> i32 {
    let Scenario {
        name,
        seed,
        duration_s,
        ..
    } = scenario;
    match both.difference() {
        None => {
            print(&format!(
                "{name}, {duration_s} s, seed {seed}: bit-equal over {} ticks\n",
                both.ticks()
            ));
            0
        }
        Some(difference) => {
            print(&format!(
                "{name}, {duration_s} s, seed {seed}: first difference in the block that ends with tick {}\n{}\n",
                difference.tick, difference.text
            ));
            1
        }
    }
}
