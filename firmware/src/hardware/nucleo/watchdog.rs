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

use stm32f4xx_hal::pac;

/// Nominal time without feeding after which the board is reset, ms.
pub const PERIOD_MS: u16 = 2_000;
/// PR: the LSI's 32 kHz divided by 16 counts half milliseconds.
const BY_16: u8 = 2;
/// Keys (RM0390, "Key register (IWDG_KR)").
const START: u16 = 0xcccc;
const UNLOCK: u16 = 0x5555;
const RELOAD: u16 = 0xaaaa;
/// Looks at the two values on their way to the LSI's side: five of its cycles, so 5,000 cycles of the power-up clock at most.
const LOOKS: u32 = 20_000;

/// Starts it; nothing but a reset stops it. It goes on while a debugger halts the processor: a board
/// that was left halted resets.
///
/// The start switches the LSI on. Until the period has arrived on the LSI's side, it is that after a reset: 0.35 to 0.96 s.
/// (Were the period written first, with the LSI off it would not arrive before the start.)
pub fn start(iwdg: &pac::IWDG, debug: &pac::DBGMCU) {
    debug.apb1_fz().modify(|_, w| w.dbg_iwdg_stop().clear_bit());
    let key = |key| {
        // SAFETY: a key that RM0390 names.
        iwdg.kr().write(|w| unsafe { w.key().bits(key) });
    };
    key(START);
    key(UNLOCK);
    // SAFETY: a divider that there is, and a count of 12 bits.
    unsafe {
        iwdg.pr().write(|w| w.pr().bits(BY_16));
        iwdg.rlr().write(|w| w.rl().bits(2 * PERIOD_MS - 1));
    }
    let arrived = |_: &u32| iwdg.sr().read().bits() == 0;
    let _ = (0..LOOKS).find(arrived);
    key(RELOAD);
}

/// Starts its period anew, from anywhere, so that the last lines of the log can be fetched before a reset.
pub fn feed() {
    // SAFETY: a single store to a write-only register.
    unsafe { (*pac::IWDG::ptr()).kr().write(|w| w.key().bits(RELOAD)) };
}
