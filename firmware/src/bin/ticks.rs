//! Counts the instructions of every tick of the model over one drive period.
//!
//! Under `-icount shift=0` QEMU lets one nanosecond go by per instruction. The
//! stopwatch only reads whole clock counts, so each tick is repeated many times
//! from the same state, and what repeating costs without the tick is measured
//! first. One line per tick is printed; `cargo xtask bench-ticks` works it out.
#![no_main]
#![no_std]

use core::hint::black_box;

use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use firmware::{
    hardware::board::{self, SysTickStopwatch},
    model::DrivenModel,
};

/// Runs of each tick; one clock count is then 40/64 of an instruction.
const REPEATS: u32 = 64;
/// Drive periods left for the start to die away.
const SETTLING_PERIODS: u32 = 64;

#[entry]
fn main() -> ! {
    let (Some(peripherals), Ok(mut model)) = (cortex_m::Peripherals::take(), DrivenModel::new())
    else {
        board::exit(false);
    };
    let stopwatch = SysTickStopwatch::start(peripherals.SYST);

    let mut periods = 0;
    while periods < SETTLING_PERIODS {
        periods += u32::from(model.tick());
    }

    hprintln!("nanoseconds {}", board::NANOSECONDS);
    hprintln!("repeats {}", REPEATS);
    hprintln!("empty {}", counts(&stopwatch, &model, |_| ()));
    loop {
        let spent = counts(&stopwatch, &model, |copy| {
            black_box(copy.tick());
        });
        let before = model.in_contact();
        let ends_period = model.tick();
        let kind = match (ends_period, before || model.in_contact()) {
            (true, _) => "strobe",
            (false, true) => "contact",
            (false, false) => "free",
        };
        hprintln!("{} {}", kind, spent);
        if ends_period {
            break;
        }
    }
    hprintln!("end");
    board::exit(true)
}

/// Clock counts of [`REPEATS`] runs of `work`, each on a fresh copy of `model`.
#[inline(never)]
fn counts(
    stopwatch: &SysTickStopwatch,
    model: &DrivenModel,
    work: impl Fn(&mut DrivenModel),
) -> u32 {
    let start = stopwatch.now();
    for _ in 0..REPEATS {
        let mut copy = *black_box(model);
        work(black_box(&mut copy));
        black_box(&copy);
    }
    stopwatch.since(start)
}
