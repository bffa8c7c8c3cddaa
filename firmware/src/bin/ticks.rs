//! Counts the instructions of every control tick of one drive period.
//!
//! Under `-icount shift=0` QEMU lets one nanosecond go by per instruction. The
//! stopwatch only reads whole clock counts, so each tick is repeated many times
//! from the same state, and what repeating costs without the tick is measured
//! first. One line per tick is printed; `cargo xtask bench-ticks` works it out.
#![no_main]
#![no_std]

use core::hint::black_box;

use cortex_m::peripheral::{SYST, syst::SystClkSource};
use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use firmware::{control::Control, hardware::qemu};

/// Runs of each tick; one clock count is then 40/64 of an instruction.
const REPEATS: u32 = 64;
/// Drive periods left for the start to die away.
const SETTLING_PERIODS: u32 = 64;
/// SysTick counts down from here: 24 bits.
const SYSTICK_MASK: u32 = 0x00ff_ffff;

#[entry]
fn main() -> ! {
    let (Some(peripherals), Ok(mut control)) = (cortex_m::Peripherals::take(), Control::new())
    else {
        qemu::exit(false);
    };
    let mut stopwatch = peripherals.SYST;
    stopwatch.set_clock_source(SystClkSource::Core);
    stopwatch.set_reload(SYSTICK_MASK);
    stopwatch.clear_current();
    stopwatch.enable_counter();

    let mut periods = 0;
    while periods < SETTLING_PERIODS {
        periods += u32::from(control.tick().is_some());
    }

    hprintln!("nanoseconds {}", 1_000_000_000 / qemu::CLOCK_HZ);
    hprintln!("repeats {}", REPEATS);
    hprintln!("empty {}", counts(&control, |_| ()));
    loop {
        let spent = counts(&control, |copy| {
            black_box(copy.tick());
        });
        let before = control.in_contact();
        let ends_period = control.tick().is_some();
        let kind = match (ends_period, before || control.in_contact()) {
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
    qemu::exit(true)
}

/// Clock counts of [`REPEATS`] runs of `work`, each on a fresh copy of `control`.
#[inline(never)]
fn counts(control: &Control, work: impl Fn(&mut Control)) -> u32 {
    let start = SYST::get_current();
    for _ in 0..REPEATS {
        let mut copy = *black_box(control);
        work(black_box(&mut copy));
        black_box(&copy);
    }
    start.wrapping_sub(SYST::get_current()) & SYSTICK_MASK
}
