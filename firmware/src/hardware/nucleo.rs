//! NUCLEO-F446RE: clocks, pins and the control timer; its safe state and its log.
//!
//! | pin | what | safe level |
//! |---|---|---|
//! | PA5 | user LED (LD2), shows life | any |
//! | PA8 (Arduino D7) | drive enable, active high | low |
//!
//! Between reset and [`Board::new`] all pins float: the drive stage needs a
//! pull-down of its own on its enable input.
#![allow(unsafe_code)]

use core::{
    panic::PanicInfo,
    sync::atomic::{AtomicBool, Ordering},
};

use defmt_rtt as _;
use stm32f4xx_hal::{
    gpio::{Output, PA5, PA8, PinState},
    pac,
    prelude::*,
    rcc::Config,
    timer::{CounterHz, Event, Flag},
};

use super::fault::Fault;
use crate::control::TICK_RATE_HZ;

/// The processor's clock. 180 MHz is the most the part allows; the control
/// timer's 90 MHz divide by the tick rate without remainder (4500).
const SYSCLK_MHZ: u32 = 180;
/// The debugger on the board feeds its 8 MHz into the OSC_IN pin.
const HSE_MHZ: u32 = 8;

/// Whether a panic or fault is being reported.
static REPORTING: AtomicBool = AtomicBool::new(false);

/// The board, set up and safe: the drive is off, the control timer not started.
pub struct Board {
    /// Shows life.
    pub led: PA5<Output>,
    /// Drive enable; driven low here, and nothing in this skeleton raises it.
    pub drive_enable: PA8<Output>,
    /// Ticks the control task.
    pub timer: ControlTimer,
}

impl Board {
    /// Takes the hardware into use. The drive enable is the first thing to be
    /// driven, before the clocks change.
    pub fn new(device: pac::Peripherals) -> Self {
        let mut rcc = device.RCC.constrain();
        let gpioa = device.GPIOA.split(&mut rcc);
        let drive_enable = gpioa.pa8.into_push_pull_output_in_state(PinState::Low);
        let led = gpioa.pa5.into_push_pull_output();

        let clocks = Config::hse(HSE_MHZ.MHz())
            .bypass_hse_oscillator()
            .sysclk(SYSCLK_MHZ.MHz());
        let mut rcc = rcc.freeze(clocks);
        let timer = ControlTimer(device.TIM2.counter_hz(&mut rcc));
        Self {
            led,
            drive_enable,
            timer,
        }
    }
}

/// TIM2, interrupting once per control tick.
pub struct ControlTimer(CounterHz<pac::TIM2>);

impl ControlTimer {
    /// Starts ticking. Returns whether the timer could be set to the tick rate.
    pub fn start(&mut self) -> bool {
        let started = self.0.start(TICK_RATE_HZ.Hz()).is_ok();
        self.0.listen(Event::Update);
        started
    }

    /// Takes note that a tick is being served; to be called first in it.
    pub fn acknowledge(&mut self) {
        self.0.clear_flags(Flag::Update);
    }

    /// Whether the next tick was due before this one ended; to be called last.
    pub fn overrun(&self) -> bool {
        self.0.flags().contains(Flag::Update)
    }
}

/// Switches the drive off, from anywhere, whatever state the program is in.
///
/// Writes to the port's set/reset register, which needs no read before it.
/// Before [`Board::new`] the port has no clock and the write does nothing: then
/// the pin still floats, and the drive stage's own pull-down holds it off.
pub fn make_outputs_safe() {
    // SAFETY: a single store to a write-only register that touches one pin.
    let gpioa = unsafe { &*pac::GPIOA::ptr() };
    gpioa.bsrr().write(|w| w.br8().set_bit());
}

/// Logs a panic and halts.
pub fn report_panic(info: &PanicInfo) -> ! {
    // A panic within a log call would find the logger taken, and panic again.
    if !REPORTING.swap(true, Ordering::Relaxed) {
        defmt::error!("panic: {}", defmt::Display2Format(info));
    }
    halt()
}

/// Logs a fault and halts.
pub fn report_fault(fault: &Fault) -> ! {
    if !REPORTING.swap(true, Ordering::Relaxed) {
        match fault.address {
            Some(pc) => defmt::error!("fault at {=u32:#010x}, CFSR {=u32:#x}", pc, fault.status),
            None => defmt::error!(
                "fault with the stack overflowed, CFSR {=u32:#x}",
                fault.status
            ),
        }
    }
    halt()
}

/// A breakpoint for the debugger, if one is attached; then stands still. Only a
/// reset leaves here.
fn halt() -> ! {
    cortex_m::interrupt::disable();
    if cortex_m::peripheral::DCB::is_debugger_attached() {
        cortex_m::asm::bkpt();
    }
    loop {
        cortex_m::asm::nop();
    }
}
