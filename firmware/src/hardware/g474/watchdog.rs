//! The independent watchdog: a clock of its own resets the board when it is not fed.
//!
//! Its clock is the LSI, 32 kHz (29.5 to 34 kHz over temperature, the data sheet's figure from memory): a nominal
//! [`PERIOD_MS`] is 1.88 to 2.17 s. It must be longer than the wait for the crystal, half a second.
#![allow(unsafe_code)]

use super::pac;

/// Nominal period, ms: counts of 32 kHz / 32.
const PERIOD_MS: u16 = 2_000;
/// Divides by 32.
const BY_32: u8 = 3;

/// Keys (RM0440, "IWDG key register").
const START: u16 = 0xcccc;
const UNLOCK: u16 = 0x5555;
const RELOAD: u16 = 0xaaaa;

/// The watchdog, running.
pub struct Watchdog(());

impl Watchdog {
    /// Starts it; nothing but a reset stops it, and it goes on while a debugger halts the processor.
    pub fn start(iwdg: &pac::IWDG) -> Self {
        // SAFETY: the keys of the manual; a divider and a reload value within their bits.
        unsafe {
            iwdg.kr().write(|w| w.key().bits(START));
            iwdg.kr().write(|w| w.key().bits(UNLOCK));
            iwdg.pr().write(|w| w.pr().bits(BY_32));
            iwdg.rlr().write(|w| w.rl().bits(PERIOD_MS - 1));
        }
        // Until both have gone over to the other clock. If that never ends, the watchdog with its first period does.
        while iwdg.sr().read().bits() != 0 {}
        feed();
        Self(())
    }

    /// Starts its period anew.
    pub fn feed(&mut self) {
        feed();
    }
}

/// Starts its period anew, from anywhere.
pub fn feed() {
    // SAFETY: a single store of a key to a write-only register.
    unsafe { (*pac::IWDG::ptr()).kr().write(|w| w.key().bits(RELOAD)) };
}
