//! Counts the instructions of a whole forecast and prints what it found, bit by bit: with a prescribed cart, and with one
//! that recoils.
//!
//! The wires at 0.0 mm, forty rows. Under `-icount shift=0` QEMU lets one nanosecond go by per instruction; a
//! slice is shorter than the stopwatch's 24 bits, so the slices are added up. `cargo xtask bench-ticks` compares
//! the printed digests with what the same code finds on the desktop.
#![no_main]
#![no_std]

use core::cell::RefCell;

use cortex_m::peripheral::{SYST, syst::SystClkSource};
use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use firmware::hardware::board;
use shared::{
    forecast::{ForecastRequest, Forecaster},
    model::cart::{ASSUMED_SHAKER, CartDrive},
    model::params::{RigParams, WIRES},
};

/// SysTick counts down from here: 24 bits.
const SYSTICK_MASK: u32 = 0x00ff_ffff;

static FORECASTER: cortex_m::interrupt::Mutex<RefCell<Option<Forecaster>>> =
    cortex_m::interrupt::Mutex::new(RefCell::new(None));

#[entry]
fn main() -> ! {
    let Some(peripherals) = cortex_m::Peripherals::take() else {
        board::exit(false);
    };
    let mut stopwatch = peripherals.SYST;
    stopwatch.set_clock_source(SystClkSource::Core);
    stopwatch.set_reload(SYSTICK_MASK);
    stopwatch.clear_current();
    stopwatch.enable_counter();

    hprintln!("nanoseconds {}", 1_000_000_000 / board::CLOCK_HZ);
    hprintln!("bytes {}", core::mem::size_of::<Forecaster>());
    cortex_m::interrupt::free(|key| {
        let mut slot = FORECASTER.borrow(key).borrow_mut();
        let forecaster = slot.insert(Forecaster::new());
        forecast("prescribed", forecaster, CartDrive::Prescribed);
        forecast("recoil", forecaster, CartDrive::Loop(ASSUMED_SHAKER));
    });
    hprintln!("end");
    board::exit(true)
}

/// A forecast with this cart; `name` begins each line.
fn forecast(name: &str, forecaster: &mut Forecaster, cart: CartDrive) {
    forecaster.start(&ForecastRequest::bench(&RigParams { cart, ..WIRES }));
    let (mut total, mut worst, mut slices) = (0_u64, 0_u32, 0_u32);
    loop {
        let start = SYST::get_current();
        let more = forecaster.slice();
        let spent = start.wrapping_sub(SYST::get_current()) & SYSTICK_MASK;
        total += u64::from(spent);
        worst = worst.max(spent);
        slices += 1;
        if !more {
            break;
        }
    }
    hprintln!("{}-slices {}", name, slices);
    hprintln!("{}-total {}", name, total);
    hprintln!("{}-worst {}", name, worst);
    let Some(forecast) = forecaster.result() else {
        board::exit(false);
    };
    hprintln!("{}-digest {}", name, forecast.digest());
    if let Some(target) = &forecast.target {
        hprintln!("{}-target {}", name, target.frequency_hz.to_bits());
        hprintln!("{}-force {}", name, target.orbit.force_n.to_bits());
    }
}
