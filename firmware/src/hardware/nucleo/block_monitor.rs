//! TIM7, which has the blocks looked after once per millisecond ([`BlockGuard`]).

use cortex_m::peripheral::NVIC;
use stm32f4xx_hal::{
    pac,
    prelude::*,
    rcc::Rcc,
    timer::{CounterHz, Event, Flag},
};

use crate::hardware::tasks::blocks::BlockGuard;

/// TIM7, interrupting once per millisecond.
pub struct BlockMonitor {
    timer: CounterHz<pac::TIM7>,
    guard: BlockGuard,
}

impl BlockMonitor {
    /// At rest until [`Self::start`].
    pub fn new(timer: pac::TIM7, rcc: &mut Rcc) -> Self {
        Self {
            timer: timer.counter_hz(rcc),
            guard: BlockGuard::default(),
        }
    }

    /// Starts checking, to be called after the sampling has started and last of all: before the first block there is
    /// none to miss. False if the timer cannot be set.
    pub fn start(&mut self) -> bool {
        let started = self.timer.start(1_000.Hz()).is_ok();
        self.timer.listen(Event::Update);
        started
    }

    /// Serves the interrupt: asks for the control task if the guard finds no blocks served.
    #[inline]
    pub fn check(&mut self) {
        self.timer.clear_flags(Flag::Update);
        if self.guard.finds_a_stall() {
            NVIC::pend(pac::Interrupt::DMA2_STREAM0);
        }
    }
}
