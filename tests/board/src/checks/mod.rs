//! What runs in the machine, and what each run shows.

mod benchmark;
mod boots;
mod changed;
mod closed;
mod faults;
mod flooded;
mod hold;
mod hung;
pub mod mutants;
mod pairs;
mod passed;
mod records;
mod reports;
mod resets;
mod saves;
mod scenarios;
mod sensors;
mod session;
mod slots;
mod wire;

use std::cell::OnceCell;
use std::path::PathBuf;
use std::rc::Rc;
use std::time::Instant;

use crate::image::Image;
use crate::machine::Patch;
use crate::parts::UNITS_PER_S;
use crate::rig::Rig;

/// What all checks need.
pub struct Setup {
    /// Path of the firmware's image, an ELF file.
    pub elf: PathBuf,
    /// Rig time of the closed loop and of the benchmark, s.
    pub seconds: f64,
    /// Without what takes long, and of the power cuts one in so many.
    pub short: Option<u32>,
    /// A mistake in the set-up.
    patch: Patch,
    image: OnceCell<Rc<Image>>,
    driving: OnceCell<Rig>,
    holding: OnceCell<Rig>,
}

impl Setup {
    /// All checks of an image.
    pub fn new(elf: PathBuf) -> Self {
        Self {
            elf,
            seconds: 60.0,
            short: None,
            patch: Patch::NONE,
            image: OnceCell::new(),
            driving: OnceCell::new(),
            holding: OnceCell::new(),
        }
    }

    /// An image that was read, with a mistake in its set-up, for this much rig time.
    fn patched(image: Rc<Image>, patch: Patch, seconds: f64) -> Self {
        Self {
            seconds,
            patch,
            image: image.into(),
            ..Self::new(PathBuf::new())
        }
    }

    /// The image, read once.
    fn image(&self) -> Result<Rc<Image>, String> {
        if self.image.get().is_none() {
            self.image.set(Rc::new(Image::read(&self.elf)?)).ok();
        }
        self.image.get().cloned().ok_or_else(|| "no image".into())
    }
}

/// What a check found: a line of figures, and the rig time that it took, units.
pub type Found = Result<(String, u64), Box<dyn std::error::Error>>;

/// A check by its name, and what it shows.
type Check = (&'static str, fn(&Setup) -> Found);

/// All checks, in their order.
const ALL: [Check; 56] = [
    ("cold boot", boots::cold),
    ("boot without the crystal's clock", boots::without_crystal),
    ("boot with a late crystal's clock", boots::late_crystal),
    ("boot with another clock", boots::another_clock),
    ("boot with a clock that stops", boots::clock_stops),
    ("boot with the button held", boots::button_held),
    ("the button starts", boots::button_starts),
    ("boot with the brown-out reset off", boots::brown_out_off),
    ("the brown-out reset is set", boots::brown_out_set),
    ("boot with damaged settings", slots::damaged),
    ("boot after a brown-out", boots::after_brown_out),
    ("closed loop", closed::field),
    ("recording over a disturbed wire", wire::disturbed),
    ("a computer at the slower rate", wire::slower),
    ("the emergency chain opens", faults::chain),
    ("the link falls silent", faults::silent_link),
    ("a sensor at a rail", sensors::rails),
    ("a sensor's wire open", sensors::open_wires),
    ("the samples stop", faults::samples_stop),
    ("the samples' stream stops", faults::stream_stops),
    ("a debugger's traps", faults::traps),
    ("the clock dies", faults::clock_dies),
    ("the clock pauses", faults::clock_pauses),
    ("the supply sags", faults::supply_sags),
    ("reports that agree", reports::agree),
    ("a report that contradicts", reports::contradict),
    ("the measuring reference is off", reports::reference),
    ("a chain that was not tried", reports::chain_tried),
    ("a stack overflow", faults::stack_overflow),
    ("a load from nowhere", faults::bad_address),
    ("a panic", records::panic),
    ("the crash's record", records::crash_record),
    ("a record over a reset", records::record_over_reset),
    ("the processor is halted", faults::halted),
    ("the program hangs", hung::hung),
    ("the program hangs in its start", hung::hung_in_the_start),
    ("the control task is starved", hung::control_starved),
    ("the link's task is starved", hung::link_starved),
    ("the supervisor is starved", hung::supervisor_starved),
    ("a flooded link", flooded::flooded),
    ("resets with the drive on", resets::while_driving),
    (
        "a supply that sagged before a start",
        resets::sagged_before_a_start,
    ),
    ("what changes by itself", changed::by_themselves),
    ("two at once: chain and save", pairs::chain_in_a_save),
    ("two at once: stall and clock", pairs::clock_dies_in_a_stall),
    (
        "two at once: clock and supply",
        pairs::supply_falls_after_the_clock,
    ),
    ("two at once: wire and chain", pairs::wire_and_chain),
    ("power cuts in a save", saves::power_cuts),
    ("a save after an old error", saves::old_error),
    ("a save on the slowest flash", saves::slowest),
    ("one mistake in the set-up", mutants::sample),
    ("waiting passed over", passed::same),
    ("the clock dies in Hold", hold::clock_dies),
    ("a dead force sensor in Hold", hold::dead_force),
    ("the set-point after a trip in Hold", hold::way_back),
    ("benchmark", benchmark::benchmark),
];

/// What takes long, and is not in the short form.
const LONG: [Check; 1] = [("scenarios with faults", scenarios::with_faults)];

/// Runs all whose name has `wanted` in it; says how many failed.
pub fn run(setup: &Setup, wanted: &str) -> usize {
    let long = LONG.iter().filter(|_| setup.short.is_none());
    let chosen = ALL
        .iter()
        .chain(long)
        .filter(|(name, _)| name.contains(wanted));
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

#[cfg(test)]
mod tests {
    use super::*;

    fn page(name: &str) -> String {
        let docs = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/");
        std::fs::read_to_string(format!("{docs}{name}")).unwrap()
    }

    /// The part of board-machine.md that describes the checks.
    fn what_runs() -> String {
        let page = page("board-machine.md");
        let (_, ran) = page.split_once("## What runs").unwrap();
        let (ran, _) = ran.split_once("## The processor").unwrap();
        ran.to_owned()
    }

    /// What stands in back quotes.
    fn quoted(text: &str) -> impl Iterator<Item = &str> {
        text.split('`').skip(1).step_by(2)
    }

    /// Whether there is a check of this name; several of `two at once: ...` share the first part of theirs.
    fn is_check(name: &str) -> bool {
        let own = |own: &str| own == name || own.split(':').next() == Some(name);
        ALL.iter().chain(&LONG).any(|(check, _)| own(check))
    }

    #[test]
    fn every_check_that_a_page_names_is_run() {
        let mut named = 0;
        for name in ["flashing.md", "wiring.md", "controller.md"] {
            let page = page(name);
            let page = page.split_whitespace().collect::<Vec<_>>().join(" ");
            for mark in page.split("xecuted in the model").skip(1) {
                let end = mark.find([')', ';', '.']).unwrap_or(mark.len());
                for check in quoted(&mark[..end]) {
                    assert!(is_check(check), "{name} names a check {check:?}");
                    named += 1;
                }
            }
        }
        // The heads of the lists and the first cells of the tables.
        for line in what_runs().lines() {
            let head = line
                .strip_prefix("- `")
                .and_then(|l| l.split([':', ',', '.', '(']).next());
            let cell = line.strip_prefix("| `").and_then(|l| l.split('|').next());
            for check in head
                .or(cell)
                .into_iter()
                .flat_map(|text| text.split('`').step_by(2))
            {
                let check = check.trim();
                if !check.is_empty() {
                    assert!(is_check(check), "board-machine.md names a check {check:?}");
                    named += 1;
                }
            }
        }
        assert!(named > 30, "{named}");
    }

    #[test]
    fn every_check_is_described() {
        let ran = what_runs();
        for (name, _) in ALL.iter().chain(&LONG) {
            // Several of two at once share a row.
            let row = name.split(':').next().unwrap();
            assert!(ran.contains(&format!("`{row}`")), "no row for {name:?}");
        }
    }
}
