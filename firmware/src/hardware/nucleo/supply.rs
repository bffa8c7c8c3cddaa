//! The supply: what resets the part when it drops, and what acts before that.
//!
//! | level | falling, V | does |
//! |---|---|---|
//! | PVD, level 6 | 2.93 | interrupts above every task: outputs safe, record, reset |
//! | brown-out reset, level 3 | 2.83 | resets the part |
//! | 5 wait states at 180 MHz | 2.7 | needed for correct fetches |
//!
//! Typical values (DS10693, "Embedded reset and power control block characteristics", and RM0390, wait states against
//! supply). The part is delivered with its brown-out reset off (1.7 V): it would go on fetching wrong instructions with
//! the drive enabled. So such a board is not fit to drive.
#![allow(unsafe_code)]

use shared::control::Unfit;
use stm32f4xx_hal::pac;

use super::pins;
use crate::brown_out;
use crate::hardware::tasks::{drive, report};

/// PLS of PWR_CR: 3.03 V rising, 2.93 V falling.
const LEVEL: u8 = 6;
/// The detector's line of EXTI.
const LINE: u32 = 1 << 16;
/// What the detector is given to settle, in turns of 3 to 4 cycles: 1 ms at 180 MHz.
const SETTLING: u32 = 50_000;

/// Starts the detector. Its interface needs its clock, which the HAL has switched on for the over-drive.
pub fn watch(pwr: &pac::PWR, flash: &pac::FLASH, exti: &pac::EXTI) -> Unfit {
    pwr.cr().modify(|_, w| w.pls().set(LEVEL).pvde().set_bit());
    cortex_m::asm::delay(SETTLING);
    let low = pwr.csr().read().pvdo().bit();
    // Either edge: the supply is or was low.
    exti.rtsr().modify(|_, w| w.tr16().set_bit());
    exti.ftsr().modify(|_, w| w.tr16().set_bit());
    acknowledge();
    exti.imr().modify(|_, w| w.mr16().set_bit());

    let level = brown_out::is_level_3(flash.optcr().read().bits());
    Unfit::SUPPLY
        .when(low)
        .and(Unfit::BROWN_OUT_LEVEL.when(!level))
}

/// Whether the supply is low now. A supply that was low before the drive came on raises no interrupt.
#[inline]
pub fn is_low() -> bool {
    // SAFETY: a read without side effect.
    unsafe { (*pac::PWR::ptr()).csr().read().pvdo().bit() }
}

/// The detector's interrupt. A drive that runs goes off, and the board starts anew; a board that drives nothing takes
/// note of nothing.
pub fn dropped() {
    let driving = drive::is_driving();
    pins::disable();
    acknowledge();
    if driving {
        report::unfit(Unfit::SUPPLY);
    }
}

fn acknowledge() {
    // SAFETY: writing a one clears this line's pending bit and touches no other.
    unsafe { (*pac::EXTI::ptr()).pr().write(|w| w.bits(LINE)) };
}
