//! The clock, what happens without it, and the clocks of the peripherals.
//!
//! | | | from |
//! |---|---|---|
//! | crystal on the board (HSE) | 24 MHz | the board's manual |
//! | PLL | 24 MHz / 6 · 85 / 2 = 170 MHz | |
//! | without the crystal | 16 MHz (HSI) / 4 · 85 / 2 = 170 MHz | 1 %, so nothing is driven |
//! | core voltage | range 1, boost | above 150 MHz |
//! | wait states | 4 | 170 MHz in boost mode; no matter which supply |
//!
//! The AHB is halved while the clock rises above 150 MHz, and for 1 µs after it (RM0440, "Dynamic voltage scaling
//! management"). The crystal is this board's own: unlike the NUCLEO-F446RE's clock it does not depend on the debugger.
//!
//! Two things raise an NMI: the clock security system when the crystal dies, and flash that reads a word with more wrong
//! bits than its code can mend. The first makes the outputs safe and resets the board. The second is taken note of in the
//! settings' pages, where a power cut can leave such a word: their own check finds it. Anywhere else it is a panic.
#![allow(unsafe_code)]

use shared::control::Unfit;

use super::{flash, make_outputs_safe, pac};
use crate::hardware::tasks::report;

/// The processor's clock, and that of all timers and of the USART: no bus is divided.
pub const SYSCLK_HZ: u32 = 170_000_000;
/// Looks at the crystal's clock before it is given up, about one per millisecond.
const LOOKS: u32 = 500;
/// Between two looks: the processor takes 3 to 4 cycles for each that it is told, so about that at 16 MHz.
const MILLISECOND: u32 = 4_000;
/// Cycles for 1 µs at least, at 85 MHz.
const MICROSECOND: u32 = 85;

/// Starts the clock; whether it is the crystal's. Waits without end in places: the watchdog runs.
pub fn start(rcc: &pac::RCC, pwr: &pac::PWR, flash: &pac::FLASH) -> bool {
    let crystal = wait_for_crystal(rcc);
    rcc.cfgr().modify(|_, w| w.hpre().div2());
    pwr.cr5().modify(|_, w| w.r1mode().clear_bit());
    flash
        .acr()
        .modify(|_, w| w.latency().wait4().prften().set_bit());
    while !flash.acr().read().latency().is_wait4() {}
    rcc.pllcfgr().write(|w| {
        if crystal {
            w.pllsrc().hse().pllm().div6();
        } else {
            w.pllsrc().hsi16().pllm().div4();
        }
        w.plln().div85().pllr().div2().pllren().set_bit()
    });
    rcc.cr().modify(|_, w| w.pllon().set_bit());
    while rcc.cr().read().pllrdy().bit_is_clear() {}
    rcc.cfgr().modify(|_, w| w.sw().pll());
    while !rcc.cfgr().read().sws().is_pll() {}
    cortex_m::asm::delay(MICROSECOND);
    rcc.cfgr().modify(|_, w| w.hpre().div1());
    if crystal {
        rcc.cr().modify(|_, w| w.csson().set_bit());
    }
    crystal
}

/// Whether the crystal's clock has come in time; if not, it is off again.
fn wait_for_crystal(rcc: &pac::RCC) -> bool {
    rcc.cr().modify(|_, w| w.hseon().set_bit());
    for _ in 0..LOOKS {
        if rcc.cr().read().hserdy().bit_is_set() {
            return true;
        }
        cortex_m::asm::delay(MILLISECOND);
    }
    rcc.cr().modify(|_, w| w.hseon().clear_bit());
    false
}

/// Clocks everything that is used, ports excepted ([`super::pins::start`]).
pub fn peripherals(rcc: &pac::RCC) {
    rcc.ahb1enr()
        .modify(|_, w| w.dma1en().set_bit().dmamux1en().set_bit());
    rcc.ahb2enr()
        .modify(|_, w| w.adc12en().set_bit().dac1en().set_bit());
    rcc.apb1enr1().modify(|_, w| {
        w.tim2en().set_bit().tim3en().set_bit();
        w.tim6en().set_bit().tim7en().set_bit();
        w.usart2en().set_bit().pwren().set_bit()
    });
    rcc.apb2enr().modify(|_, w| w.syscfgen().set_bit());
    // Two cycles must pass before the first access: a read takes them.
    let _ = rcc.apb2enr().read();
}

/// Above everything.
#[unsafe(no_mangle)]
extern "C" fn NonMaskableInt() {
    // SAFETY: a read, and a store that clears one flag.
    let rcc = unsafe { &*pac::RCC::ptr() };
    if rcc.cifr().read().cssf().bit() {
        make_outputs_safe();
        // Unless it is cleared, the NMI comes back.
        rcc.cicr().write(|w| w.cssc().set_bit());
        report::unfit(Unfit::CLOCK);
    }
    if !flash::acknowledge_damage() {
        panic!("an NMI of unknown cause");
    }
}
