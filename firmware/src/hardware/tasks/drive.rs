//! The drive's enable line, and what takes it away.
//!
//! The enable is a train of pulses: the control task turns the line over once per block, 1 kHz with the drive on, and the
//! line is low with the drive off. Outside, a charge pump holds a relay as long as pulses come (docs/wiring.md). So
//! whatever stops the control task drops the drive, with the line stuck at either level: a halted processor, a dead clock,
//! a task that hangs, a pin that is shorted. What finds trouble sooner pulls the line low.
//!
//! The chain itself switches the drive off in hardware (docs/wiring.md). In addition, its opening interrupts every
//! task and pulls the enable low at once. The line stays low until the controller has seen the open chain in its
//! samples and has itself switched the drive off.

use core::sync::atomic::{AtomicBool, Ordering};

use super::retained;
use crate::hardware::board::{EnablePin, disable};

/// The drive is enabled.
static DRIVING: AtomicBool = AtomicBool::new(false);
/// Set where the enable was taken away without the controller, until the controller has switched off, too.
static TAKEN_AWAY: AtomicBool = AtomicBool::new(false);

/// Whether the emergency-stop chain has reported that it was open, since the drive was last on and since that was acknowledged.
static CHAIN_WAS_OPEN: AtomicBool = AtomicBool::new(false);

/// Takes what the chain reports in a block.
#[inline]
pub fn note_chain(open: bool) {
    if open || is_driving() {
        CHAIN_WAS_OPEN.store(open, Ordering::Relaxed);
    }
}

/// Whether the emergency-stop chain has reported that it was open, since the drive was last on and since that was acknowledged.
#[inline]
pub fn chain_was_open() -> bool {
    CHAIN_WAS_OPEN.load(Ordering::Relaxed)
}

/// What the chain reported has been acknowledged.
pub fn forget_chain() {
    CHAIN_WAS_OPEN.store(false, Ordering::Relaxed);
}

/// Pulls the enable low and keeps it there until the controller has switched the drive off.
#[inline]
pub fn take_away() {
    disable();
    TAKEN_AWAY.store(true, Ordering::Release);
    // In case the control task was just between reading the flag and raising the line.
    disable();
}

/// Whether the drive is enabled.
#[inline]
pub fn is_driving() -> bool {
    DRIVING.load(Ordering::Relaxed)
}

/// The enable line. Only its owner can raise it: bench mode never gets it.
pub struct Enable {
    pin: EnablePin,
    on: bool,
    /// The line's level in the block that was.
    high: bool,
}

impl Enable {
    /// The enable line, pulled low.
    pub fn new(mut pin: EnablePin) -> Self {
        pin.set_low();
        Self {
            pin,
            on: false,
            high: false,
        }
    }

    /// Applies the controller's output, once per block. `reported`: whether the controller has been given the open chain.
    #[inline]
    pub fn apply(&mut self, on: bool, reported: bool) {
        self.high = on && !self.high;
        if self.high {
            // No interrupt may come between reading the flag and raising the line.
            cortex_m::interrupt::free(|_| {
                if !TAKEN_AWAY.load(Ordering::Acquire) {
                    self.pin.set_high();
                }
            });
        } else {
            self.pin.set_low();
            if reported && !on {
                TAKEN_AWAY.store(false, Ordering::Release);
            }
        }
        if on != self.on {
            self.on = on;
            DRIVING.store(on, Ordering::Relaxed);
            retained::note_drive(on);
        }
    }
}

/// Whether the enable was taken away since the controller last dealt with it.
#[inline]
pub fn is_taken_away() -> bool {
    TAKEN_AWAY.load(Ordering::Acquire)
}
