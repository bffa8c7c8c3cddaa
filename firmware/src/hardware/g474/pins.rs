//! Pins.
//!
//! After a reset all of them are analogue, without pull resistors: the drive stage needs a pull-down of its own on its
//! enable input.
#![allow(unsafe_code)]

use super::pac;
use crate::interlock::Inputs;

/// How long a pin is left to follow a pull resistor, in cycles of 16 MHz, each of which takes 3 to 4: 1 ms.
const SETTLING: u32 = 5_000;
/// The sensors' pins of ports A and B.
const SENSORS: [u16; 2] = [0b11, 0b1];

fn port_a() -> &'static pac::gpioa::RegisterBlock {
    // SAFETY: loads of levels, and stores to the register that sets and clears single pins.
    unsafe { &*pac::GPIOA::ptr() }
}

fn port_b() -> &'static pac::gpiob::RegisterBlock {
    // SAFETY: loads of levels only.
    unsafe { &*pac::GPIOB::ptr() }
}

/// Clocks the ports and drives the enable low, first of all.
pub fn start(rcc: &pac::RCC, gpioa: &pac::GPIOA) {
    rcc.ahb2enr().modify(|_, w| {
        w.gpioaen()
            .set_bit()
            .gpioben()
            .set_bit()
            .gpiocen()
            .set_bit()
    });
    // Two cycles must pass before the first access: a read takes them.
    let _ = rcc.ahb2enr().read();
    disable();
    gpioa.moder().modify(|_, w| w.moder8().output());
}

/// Pulls the enable low, from anywhere, whatever state the program is in.
#[inline]
pub fn disable() {
    port_a().bsrr().write(|w| w.br8().set_bit());
}

/// The enable's pin, of which there is none: this type has no value. So no task can raise the line, and the image holds no
/// store that does. It gets one when somebody has tried this board (README.md).
pub enum EnablePin {}

impl EnablePin {
    /// Cannot be called.
    pub fn set_high(&mut self) {
        match *self {}
    }

    /// Cannot be called.
    pub fn set_low(&mut self) {
        match *self {}
    }
}

/// Makes inputs of the sensors' pins, chain, reports and strap, and looks whether a voltage holds any of the sensors'
/// (pulled up and pulled down it reads the same) and whether the strap is closed. The sensors' pins are analogue afterwards.
pub fn probe(gpioa: &pac::GPIOA, gpiob: &pac::GPIOB) -> (bool, bool) {
    gpioa.moder().modify(|_, w| {
        w.moder0().input().moder1().input();
        w.moder9().input().moder10().input()
    });
    gpiob
        .moder()
        .modify(|_, w| w.moder0().input().moder5().input().moder10().input());
    gpioa
        .pupdr()
        .modify(|_, w| w.pupdr9().pull_up().pupdr10().pull_up());
    gpiob
        .pupdr()
        .modify(|_, w| w.pupdr5().pull_up().pupdr10().pull_up());

    let levels = || {
        cortex_m::asm::delay(SETTLING);
        let [a, b] = SENSORS;
        [
            level(port_a().idr().read().bits(), a),
            level(port_b().idr().read().bits(), b),
        ]
    };
    gpioa
        .pupdr()
        .modify(|_, w| w.pupdr0().pull_up().pupdr1().pull_up());
    gpiob.pupdr().modify(|_, w| w.pupdr0().pull_up());
    let up = levels();
    gpioa
        .pupdr()
        .modify(|_, w| w.pupdr0().pull_down().pupdr1().pull_down());
    gpiob.pupdr().modify(|_, w| w.pupdr0().pull_down());
    let down = levels();
    gpioa
        .pupdr()
        .modify(|_, w| w.pupdr0().floating().pupdr1().floating());
    gpiob.pupdr().modify(|_, w| w.pupdr0().floating());
    gpioa
        .moder()
        .modify(|_, w| w.moder0().analog().moder1().analog());
    gpiob.moder().modify(|_, w| w.moder0().analog());

    // A free pin has followed: high, then low.
    let held = (0..2).any(|port| up[port] & !down[port] != SENSORS[port]);
    (held, gpioa.idr().read().idr10().bit_is_clear())
}

fn level(port: u32, mask: u16) -> u16 {
    port as u16 & mask
}

/// Joins LED, wire, motor drive's set-point and button to what they belong to. PA4 stays analogue, for the DAC.
pub fn connect(gpioa: &pac::GPIOA, gpioc: &pac::GPIOC) {
    gpioa.afrl().modify(|_, w| w.afrl2().af7().afrl3().af7());
    gpioa.moder().modify(|_, w| {
        w.moder2().alternate().moder3().alternate();
        w.moder5().output()
    });
    // An open wire is a wire at rest.
    gpioa.pupdr().modify(|_, w| w.pupdr3().pull_up());
    gpioc.afrl().modify(|_, w| w.afrl7().af2());
    gpioc
        .moder()
        .modify(|_, w| w.moder7().alternate().moder13().input());
}

/// The emergency-stop chain on PB5: closed to ground, pulled up when it opens.
pub struct Chain(());

impl Chain {
    /// Interrupts when the chain opens.
    pub fn new(syscfg: &pac::SYSCFG, exti: &pac::EXTI) -> Self {
        /// Port B.
        const PORT: u8 = 1;
        // SAFETY: a port that the part has.
        syscfg
            .exticr2()
            .modify(|_, w| unsafe { w.exti5().bits(PORT) });
        exti.rtsr1().modify(|_, w| w.rt5().set_bit());
        exti.imr1().modify(|_, w| w.im5().set_bit());
        Self(())
    }

    /// Whether it is open now.
    #[inline]
    pub fn is_open(&self) -> bool {
        port_b().idr().read().idr5().bit_is_set()
    }
}

/// Clears the chain's interrupt; to be called in it.
#[inline]
pub fn acknowledge_chain() {
    // SAFETY: writing a one clears this line's pending bit and touches no other.
    unsafe { (*pac::EXTI::ptr()).pr1().write(|w| w.bits(1 << 5)) };
}

/// What the power stage and the enable's relay report, closed to ground, pulled up where nothing is wired.
pub struct Reports(());

impl Reports {
    pub(super) fn new() -> Self {
        Self(())
    }

    /// Their levels.
    #[inline]
    pub fn read(&self) -> Inputs {
        Inputs {
            dropped: port_a().idr().read().idr9().bit_is_clear(),
            ready: port_b().idr().read().idr10().bit_is_clear(),
        }
    }
}

/// The user LED on PA5.
pub struct LedPin(());

impl LedPin {
    pub(super) fn new() -> Self {
        Self(())
    }

    /// On or off.
    #[inline]
    pub fn set(&mut self, on: bool) {
        port_a().bsrr().write(|w| {
            if on {
                w.bs5().set_bit()
            } else {
                w.br5().set_bit()
            }
        });
    }
}

/// The user button on PC13. Sources differ on which level is the pressed one; so it is the one that it has not at the start,
/// and the button does not ask for bench mode here.
pub struct ButtonPin {
    at_rest: bool,
}

impl ButtonPin {
    pub(super) fn new() -> Self {
        Self {
            at_rest: level_13(),
        }
    }

    /// Whether it is pressed now.
    #[inline]
    pub fn is_pressed(&self) -> bool {
        level_13() != self.at_rest
    }
}

fn level_13() -> bool {
    // SAFETY: a load without side effect.
    unsafe { (*pac::GPIOC::ptr()).idr().read().idr13().bit_is_set() }
}
