//! Checks once per millisecond, above every other task, that blocks are being served. If the control task hangs
//! or is starved, or the samples stop, the drive's enable is taken away 2 to 3 ms after the last block.

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use cortex_m::peripheral::NVIC;
use stm32f4xx_hal::{
    pac,
    prelude::*,
    rcc::Rcc,
    timer::{CounterHz, Event, Flag},
};

use super::drive;

/// Blocks served since the start (wraps).
static SERVED: AtomicU32 = AtomicU32::new(0);
/// Set while the flash is erased or written: no block can be served then, and the drive is off.
static PAUSED: AtomicBool = AtomicBool::new(false);
/// Set when the enable was taken away; the control task takes it and reports stale samples.
static ACTED: AtomicBool = AtomicBool::new(false);

/// Counts a block as served; to be called at the end of the control task.
#[inline]
pub fn block_served() {
    SERVED.fetch_add(1, Ordering::Relaxed);
}

/// Blocks served since the start (wraps).
#[inline]
pub fn blocks_served() -> u32 {
    SERVED.load(Ordering::Relaxed)
}

/// Whether blocks were missing since the last call.
#[inline]
pub fn take_stale() -> bool {
    ACTED.swap(false, Ordering::Relaxed)
}

/// Runs `work`, during which the processor may stand still; the drive is off.
pub fn paused<T>(work: impl FnOnce() -> T) -> T {
    PAUSED.store(true, Ordering::Relaxed);
    let result = work();
    PAUSED.store(false, Ordering::Relaxed);
    result
}

/// Whether missing blocks are expected now.
#[inline]
pub fn is_paused() -> bool {
    PAUSED.load(Ordering::Relaxed)
}

/// TIM7, interrupting once per millisecond.
pub struct BlockMonitor {
    timer: CounterHz<pac::TIM7>,
    seen: u32,
    missed: u8,
}

impl BlockMonitor {
    /// At rest until [`Self::start`].
    pub fn new(timer: pac::TIM7, rcc: &mut Rcc) -> Self {
        Self {
            timer: timer.counter_hz(rcc),
            seen: 0,
            missed: 0,
        }
    }

    /// Starts checking, to be called after the sampling has started and last of all: before the first block there is
    /// none to miss. False if the timer cannot be set.
    pub fn start(&mut self) -> bool {
        let started = self.timer.start(1_000.Hz()).is_ok();
        self.timer.listen(Event::Update);
        started
    }

    /// Serves the interrupt. Two blocks are due between two interrupts; none, twice in a row, is a stall.
    #[inline]
    pub fn check(&mut self) {
        self.timer.clear_flags(Flag::Update);
        let served = blocks_served();
        let stalled = served == self.seen && !is_paused();
        self.seen = served;
        self.missed = if stalled {
            self.missed.saturating_add(1)
        } else {
            0
        };
        if self.missed >= 2 {
            drive::take_away();
            ACTED.store(true, Ordering::Relaxed);
            // If it was the samples that stopped, the controller learns it: a block without samples, which does not count as
            // served. The watchdog resets a board that stays so.
            NVIC::pend(pac::Interrupt::DMA2_STREAM0);
        }
    }
}
