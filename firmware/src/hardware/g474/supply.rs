//! The supply: what acts when it drops.
//!
//! The voltage detector (PVD, level 6: about 2.9 V) interrupts above every task: outputs safe, record, reset. Unlike the
//! STM32F446's, this part's wait states do not depend on the supply, and its brown-out reset is on as delivered (1.7 V):
//! below the detector's level it goes on fetching right instructions. So the brown-out level is not asked for.
#![allow(unsafe_code)]

use shared::control::Unfit;

use super::{make_outputs_safe, pac, pins};
use crate::hardware::tasks::{drive, report};

/// PLS of PWR_CR2: about 2.9 V.
const LEVEL: u8 = 6;
/// The detector's line of EXTI.
const LINE: u32 = 1 << 16;
/// What the detector is given to settle, in cycles of 170 MHz, each of which takes 3 to 4: 0.9 ms.
const SETTLING: u32 = 50_000;

/// Starts the detector.
pub fn watch(pwr: &pac::PWR, exti: &pac::EXTI) -> Unfit {
    // SAFETY: a level of three bits.
    pwr.cr2()
        .modify(|_, w| unsafe { w.pvdls().bits(LEVEL).pvde().set_bit() });
    cortex_m::asm::delay(SETTLING);
    let low = pwr.sr2().read().pvdo().bit();
    // Either edge: the supply is or was low.
    exti.rtsr1().modify(|_, w| w.rt16().set_bit());
    exti.ftsr1().modify(|_, w| w.ft16().set_bit());
    acknowledge();
    exti.imr1().modify(|_, w| w.im16().set_bit());
    Unfit::SUPPLY.when(low)
}

/// The detector's interrupt. A drive that runs goes off, and the board starts anew.
pub fn dropped() {
    let driving = drive::is_driving();
    pins::disable();
    acknowledge();
    if driving {
        make_outputs_safe();
        report::unfit(Unfit::SUPPLY);
    }
}

fn acknowledge() {
    // SAFETY: writing a one clears this line's pending bit and touches no other.
    unsafe { (*pac::EXTI::ptr()).pr1().write(|w| w.bits(LINE)) };
}
