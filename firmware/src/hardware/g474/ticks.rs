//! TIM6 and TIM7, each interrupting once per millisecond: for the link, and for the guard over the blocks.
#![allow(unsafe_code)]

use cortex_m::peripheral::NVIC;

use super::{clock::SYSCLK_HZ, pac};
use crate::hardware::tasks::blocks::Guard;

/// Counts per millisecond.
const COUNTS: u16 = 1_000;
/// What the clock is divided by before it is counted.
const DIVIDER: u16 = (SYSCLK_HZ / 1_000 / COUNTS as u32) as u16;

/// Sets a timer to interrupt once per millisecond; it rests.
fn set_up(timer: &pac::tim6::RegisterBlock) {
    timer.psc().write(|w| w.psc().set(DIVIDER - 1));
    // SAFETY: a reload of 16 bits. (The field alone would leave ones in the bits above, as they are after a reset.)
    timer
        .arr()
        .write(|w| unsafe { w.bits(u32::from(COUNTS) - 1) });
    // The divider takes effect with an update, which is none of the millisecond's.
    timer.egr().write(|w| w.ug().set_bit());
    acknowledge(timer);
    timer.dier().write(|w| w.uie().set_bit());
}

fn acknowledge(timer: &pac::tim6::RegisterBlock) {
    timer.sr().write(|w| w.uif().clear_bit());
}

/// TIM6.
pub struct LinkTimer(pac::TIM6);

impl LinkTimer {
    pub(super) fn new(timer: pac::TIM6) -> Self {
        set_up(&timer);
        timer.cr1().modify(|_, w| w.cen().set_bit());
        Self(timer)
    }

    /// Clears the interrupt; to be called first in it.
    #[inline]
    pub fn acknowledge(&mut self) {
        acknowledge(&self.0);
    }
}

/// TIM7.
pub struct BlockMonitor {
    timer: pac::TIM7,
    guard: Guard,
}

impl BlockMonitor {
    /// At rest until [`Self::start`].
    pub(super) fn new(timer: pac::TIM7) -> Self {
        set_up(&timer);
        Self {
            timer,
            guard: Guard::default(),
        }
    }

    /// Starts checking, to be called after the sampling has started. True: nothing can go wrong.
    pub fn start(&mut self) -> bool {
        self.timer.cr1().modify(|_, w| w.cen().set_bit());
        true
    }

    /// Serves the interrupt.
    #[inline]
    pub fn check(&mut self) {
        acknowledge(&self.timer);
        if self.guard.finds_a_stall() {
            NVIC::pend(pac::Interrupt::DMA1_CH1);
        }
    }
}
