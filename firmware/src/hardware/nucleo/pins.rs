//! The pins of the drive's enable and of the emergency-stop chain, and those that are only looked at or lit.
#![allow(unsafe_code)]

use shared::io::NormallyClosed;
use stm32f4xx_hal::{
    gpio::{Edge, ExtiPin, Input, Output, PA5, PA8, PA9, PB5, PB10, PC13, PinState},
    pac,
    syscfg::SysCfg,
};

use crate::interlock::Inputs;

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

/// The pin of the drive's enable line, PA8.
pub struct EnablePin(pub(super) PA8<Output>);

impl EnablePin {
    /// Raises the enable line.
    #[inline]
    pub fn set_high(&mut self) {
        self.0.set_high();
    }

    /// Pulls the enable line low.
    #[inline]
    pub fn set_low(&mut self) {
        self.0.set_low();
    }
}

/// The emergency-stop chain on PB5: closed to ground, pulled up when it opens.
pub struct ChainPin(NormallyClosed<PB5<Input>>);

impl ChainPin {
    /// Interrupts when the chain opens.
    pub fn new(mut pin: PB5<Input>, syscfg: &mut SysCfg, exti: &mut pac::EXTI) -> Self {
        pin.make_interrupt_source(syscfg);
        pin.trigger_on_edge(exti, Edge::Rising);
        pin.enable_interrupt(exti);
        Self(NormallyClosed(pin))
    }

    /// Whether it is open now.
    #[inline]
    pub fn is_open(&mut self) -> bool {
        self.0.is_open()
    }
}

/// Clears the chain's interrupt; to be called in it.
#[inline]
pub fn acknowledge_chain() {
    // SAFETY: writing a one clears this line's pending bit and touches no other.
    unsafe { (*pac::EXTI::ptr()).pr().write(|w| w.bits(1 << 5)) };
}

/// What the power stage and the enable's relay report, closed to ground, pulled up where nothing is wired.
pub struct Reports {
    pub(super) dropped: PA9<Input>,
    pub(super) ready: PB10<Input>,
}

impl Reports {
    /// The reports now: each is true while its line is closed to ground.
    #[inline]
    pub fn read(&self) -> Inputs {
        Inputs {
            dropped: self.dropped.is_low(),
            ready: self.ready.is_low(),
        }
    }
}

/// The user LED on PA5.
pub struct LedPin(pub(super) PA5<Output>);

impl LedPin {
    /// Switches the LED on or off.
    #[inline]
    pub fn set(&mut self, on: bool) {
        self.0
            .set_state(if on { PinState::High } else { PinState::Low });
    }
}

/// The user button on PC13.
pub struct ButtonPin(pub(super) PC13<Input>);

impl ButtonPin {
    /// Whether it is pressed now.
    #[inline]
    pub fn is_pressed(&self) -> bool {
        self.0.is_low()
    }
}
