//! The independent watchdog: a clock of its own resets the board when it is not fed.
//!
//! Its clock is the 32 kHz LSI, which the data sheet gives as 17 to 47 kHz (DS10693, "Low-speed internal
//! RC oscillator"): a nominal [`PERIOD_MS`] is 1.36 to 3.76 s. The shortest must be longer than the longest permitted
//! stall of the processor: one sector of settings being erased, 0.8 s at most (DS10693, "Flash memory
//! programming"), and half a kilobyte being written after it, 0.05 s at most.
//!
//! It starts before the clock does, right after the enable is driven low: whatever the start waits for, it ends.
//!
//! A hung program does not leave the drive on for that long: [`crate::hardware::tasks::blocks`] takes the enable away within 3 ms,
//! and the enable is a train of pulses that ends with the control task ([`crate::hardware::tasks::drive`]).

#![allow(unsafe_code)]

use stm32f4xx_hal::{pac, prelude::*, watchdog::IndependentWatchdog};

/// Nominal period, ms.
pub const PERIOD_MS: u32 = 2_000;

/// The watchdog, running.
pub struct Watchdog(IndependentWatchdog);

impl Watchdog {
    /// Starts it; nothing but a reset stops it. It goes on while a debugger halts the processor: a board
    /// that was left halted resets.
    pub fn start(iwdg: pac::IWDG, debug: &pac::DBGMCU) -> Self {
        let mut watchdog = IndependentWatchdog::new(iwdg);
        watchdog.stop_on_debug(debug, false);
        watchdog.start(PERIOD_MS.millis());
        Self(watchdog)
    }

    /// Starts its period anew.
    pub fn feed(&mut self) {
        self.0.feed();
    }
}

/// Starts its period anew, from anywhere, so that the last lines of the log can be fetched before a reset.
pub fn feed() {
    /// The key that reloads the counter (RM0390, "Key register (IWDG_KR)").
    const RELOAD: u16 = 0xaaaa;
    // SAFETY: a single store to a write-only register.
    unsafe { (*pac::IWDG::ptr()).kr().write(|w| w.key().bits(RELOAD)) };
}
