//! The clock, and what happens without it.
//!
//! The debugger's part of the board feeds its crystal's 8 MHz into OSC_IN (HSE, bypassed). It is there as long as that
//! part has power. So it is waited for only so long; without it the board runs from its own RC oscillator (HSI, 1 % at
//! room temperature) and drives nothing: 1 % of frequency is more than the lock's whole range of error. So it does if what
//! comes in is a clock of another frequency: every rate would be wrong, and nothing else here would tell.
//!
//! A clock that dies while the program runs is found by the clock security system (RM0390, "Clock security system (CSS)"):
//! it switches to HSI and raises the NMI, within a few periods. The NMI comes above everything, makes the outputs safe and
//! resets the board, which then starts without the crystal's clock.
#![allow(unsafe_code)]

use shared::control::Unfit;
use stm32f4xx_hal::{
    pac,
    prelude::*,
    rcc::{Config, Enable, Rcc},
};

use crate::hardware::tasks::report;

/// The processor's clock. 180 MHz is the most the part allows; the timers' 90 MHz divide by the tick rate
/// without remainder (4500).
pub const SYSCLK_MHZ: u32 = 180;
/// The debugger on the board feeds its 8 MHz into the OSC_IN pin.
const HSE_MHZ: u32 = 8;
/// Looks at the crystal's clock before it is given up, one per millisecond at most: 0.38 to 0.5 s. The debugger's part needs
/// some 0.1 s to start (believed, not measured); the watchdog's shortest period is 1.36 s.
const LOOKS: u32 = 500;
/// Between two looks: [`cortex_m::asm::delay`] takes 3 to 4 cycles for each that it is told on this processor, so 0.75 to
/// 1 ms of the power-up clock, 16 MHz. (With 16,000 the watchdog reset the board before it gave up.)
const MILLISECOND: u32 = 4_000;

/// The crystal's clock is measured by the power-up clock, which is right to 4 % from −10 to 85 °C (DS10693, "Internal clock
/// source characteristics"): HSE_RTC is that clock divided, and TIM11 captures its count of 16 MHz at each 8th edge of it.
const DIVIDER: u8 = 31;
const COUNTED: u16 = 16 * 8 * DIVIDER as u16 / HSE_MHZ as u16;
/// 6 % of it.
const TOLERANCE: u16 = COUNTED * 6 / 100;
/// TIM11_OR: HSE_RTC at the timer's input (RM0390, "TIM11 option register 1").
const HSE_RTC: u8 = 2;

/// Starts the clock; whether it is the crystal's.
pub fn start(mut rcc: Rcc, timer: &pac::TIM11) -> (Rcc, bool) {
    pac::TIM11::enable(&mut rcc);
    let crystal = wait_for_crystal(&rcc, timer);
    pac::TIM11::disable(&mut rcc);
    let source = if crystal {
        Config::hse(HSE_MHZ.MHz()).bypass_hse_oscillator()
    } else {
        Config::hsi()
    };
    // While the over-drive switches, no peripheral may have a clock (RM0390, 5.1.4). Pins keep mode and level without one.
    let ports = rcc.ahb1enr().read().bits();
    // SAFETY: no clock at all; nothing but the ports has one yet.
    rcc.ahb1enr().write(|w| unsafe { w.bits(0) });
    let rcc = rcc.freeze(source.sysclk(SYSCLK_MHZ.MHz()));
    // SAFETY: what was there before.
    rcc.ahb1enr().write(|w| unsafe { w.bits(ports) });
    if crystal {
        rcc.cr().modify(|_, w| w.csson().set_bit());
    }
    (rcc, crystal)
}

/// Whether the crystal's clock has come in time; if not, its input is off again.
fn wait_for_crystal(rcc: &Rcc, timer: &pac::TIM11) -> bool {
    rcc.cfgr().modify(|_, w| w.rtcpre().set(DIVIDER));
    rcc.cr().modify(|_, w| w.hsebyp().bypassed());
    rcc.cr().modify(|_, w| w.hseon().set_bit());
    // SAFETY: an input that there is.
    timer.or().write(|w| unsafe { w.rmp().bits(HSE_RTC) });
    timer
        .ccmr1_input()
        .write(|w| w.cc1s().ti1().ic1psc().eight_events());
    timer.ccer().write(|w| w.cc1e().set_bit());
    timer.cr1().write(|w| w.cen().set_bit());
    for _ in 0..LOOKS {
        if rcc.cr().read().hserdy().bit_is_set() && is_right(timer) {
            return true;
        }
        cortex_m::asm::delay(MILLISECOND);
    }
    rcc.cr().modify(|_, w| w.hseon().clear_bit());
    false
}

/// Whether the crystal's clock has its frequency, by the counts of two captures. A capture comes after COUNTED cycles, and a look
/// takes more than one.
fn is_right(timer: &pac::TIM11) -> bool {
    let captured = || {
        (0..COUNTED).find(|_| timer.sr().read().cc1if().bit())?;
        Some(timer.ccr1().read().ccr().bits())
    };
    // The first may be an old one.
    let [_, from, to] = [captured(), captured(), captured()];
    let counted = from.zip(to).map(|(from, to)| to.wrapping_sub(from));
    counted.is_some_and(|counted| counted.abs_diff(COUNTED) <= TOLERANCE)
}

/// The clock has died. Nothing else raises an NMI on this part.
#[unsafe(no_mangle)]
extern "C" fn NonMaskableInt() -> ! {
    super::make_outputs_safe();
    // SAFETY: a store that clears one flag; unless it is cleared, the NMI comes back.
    unsafe { (*pac::RCC::ptr()).cir().write(|w| w.cssc().set_bit()) };
    report::unfit(Unfit::CLOCK)
}
