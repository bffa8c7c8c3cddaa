//! What runs in the machine, and what each run shows.

mod boots;
mod closed;
mod faults;
mod saves;
mod session;

use std::path::PathBuf;
use std::time::Instant;

use crate::parts::UNITS_PER_S;

/// What all checks need.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The image.
    pub elf: PathBuf,
    /// Rig time of the closed loop, s.
    pub seconds: f64,
    /// Of the power cuts, one in so many.
    pub every: u32,
}

/// What a check found: a line of figures, and the rig time that it took, units.
pub type Found = Result<(String, u64), Box<dyn std::error::Error>>;

/// A check by its name, and what it shows.
type Check = (&'static str, fn(&Setup) -> Found);

/// All checks, in their order.
const ALL: [Check; 16] = [
    ("cold boot", boots::cold),
    ("boot without the crystal's clock", boots::without_crystal),
    ("boot with a late crystal's clock", boots::late_crystal),
    ("boot with the button held", boots::button_held),
    ("boot with the brown-out reset off", boots::brown_out_off),
    ("closed loop", closed::field),
    ("the emergency chain opens", faults::chain),
    ("the samples stop", faults::samples_stop),
    ("the samples' stream stops", faults::stream_stops),
    ("a debugger's traps", faults::traps),
    ("the clock dies", faults::clock_dies),
    ("the supply sags", faults::supply_sags),
    ("a stack overflow", faults::stack_overflow),
    ("a load from nowhere", faults::bad_address),
    ("the processor is halted", faults::halted),
    ("power cuts in a save", saves::power_cuts),
];

/// Runs all whose name has `wanted` in it; says how many failed.
pub fn run(setup: &Setup, wanted: &str) -> usize {
    let chosen = ALL.iter().filter(|(name, _)| name.contains(wanted));
    let mut failed = 0;
    for (name, check) in chosen {
        let began = Instant::now();
        let found = check(setup);
        let took_s = began.elapsed().as_secs_f64();
        match found {
            Ok((text, units)) => {
                let rig_s = units as f64 / UNITS_PER_S as f64;
                println!("ok      {name}: {text} ({rig_s:.2} s of rig time in {took_s:.1} s)");
            }
            Err(error) => {
                failed += 1;
                println!("FAILED  {name}: {error}");
            }
        }
    }
    failed
}

/// Fails with this text unless it holds.
fn must(holds: bool, text: impl FnOnce() -> String) -> Result<(), Box<dyn std::error::Error>> {
    if holds { Ok(()) } else { Err(text().into()) }
}
