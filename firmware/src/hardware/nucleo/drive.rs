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
#![allow(unsafe_code)]

use core::sync::atomic::{AtomicBool, Ordering};

use shared::io::NormallyClosed;
use stm32f4xx_hal::{
    gpio::{Edge, ExtiPin, Input, Output, PA8, PB5},
    pac,
    syscfg::SysCfg,
};

use super::retained;

/// The drive is enabled.
static DRIVING: AtomicBool = AtomicBool::new(false);
/// Set where the enable was taken away without the controller, until the controller has switched off, too.
static TAKEN_AWAY: AtomicBool = AtomicBool::new(false);

/// Pulls the enable low, from anywhere, whatever state the program is in.
///
/// A single store to the port's set/reset register, which needs no read before it. Before the port has its
/// clock the store does nothing: then the pin still floats, and the drive stage's own pull-down holds it.
#[inline]
pub fn disable() {
    // SAFETY: a single store to a write-only register that touches one pin.
    let gpioa = unsafe { &*pac::GPIOA::ptr() };
    gpioa.bsrr().write(|w| w.br8().set_bit());
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
    pin: PA8<Output>,
    on: bool,
    /// The line's level in the block that was.
    high: bool,
}

impl Enable {
    /// Low.
    pub fn new(mut pin: PA8<Output>) -> Self {
        pin.set_low();
        retained::note_drive(false);
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

/// The emergency-stop chain on PB5: closed to ground, pulled up when it opens.
pub struct Chain(NormallyClosed<PB5<Input>>);

impl Chain {
    /// Interrupts when the chain opens.
    pub fn new(mut pin: PB5<Input>, syscfg: &mut SysCfg, exti: &mut pac::EXTI) -> Self {
        pin.make_interrupt_source(syscfg);
        pin.trigger_on_edge(exti, Edge::Rising);
        pin.enable_interrupt(exti);
        Self(NormallyClosed(pin))
    }

    /// Whether the chain is open now, or the enable was taken away since the controller last dealt with it.
    #[inline]
    pub fn tripped(&mut self) -> bool {
        self.0.is_open() || TAKEN_AWAY.load(Ordering::Acquire)
    }
}

/// Clears the chain's interrupt; to be called in it.
#[inline]
pub fn acknowledge() {
    // SAFETY: writing a one clears this line's pending bit and touches no other.
    unsafe { (*pac::EXTI::ptr()).pr().write(|w| w.bits(1 << 5)) };
}
