//! NUCLEO-F446RE: everything of the board that the app needs, set up and safe.
//!
//! | pin | Arduino | what | safe level |
//! |---|---|---|---|
//! | PA0 | A0 | force, 0.1 to 3.2 V | – |
//! | PA1 | A1 | hammer displacement | – |
//! | PB0 | A3 | cart displacement | – |
//! | PA4 | A2 | shaker's set-point (DAC) | 1.65 V, the middle |
//! | PC7 | D9 | motor drive's frequency, duty cycle | low |
//! | PA8 | D7 | drive enable: pulses of 1 kHz | low |
//! | PB5 | D4 | emergency-stop chain, closed to ground | high: open |
//! | PA9 | D8 | the enable's relay has dropped, closed to ground | – |
//! | PB10 | D6 | the power stage is ready, closed to ground | – |
//! | PA10 | D2 | bench strap, to ground for bench mode | – |
//! | PC13 | – | user button B1, pressed low | – |
//! | PA5 | – | user LED LD2 | any |
//! | PA2, PA3 | – | link: USART2 through the debugger's serial port | – |
//!
//! Between reset and [`set_up`] all pins float: the drive stage needs a pull-down of its own on its enable
//! input. The wiring is described in docs/wiring.md. This module has been run in the model of the board (`cargo xtask board`), never on a board: no
//! such board is attached to the machines that build this project.
//!
//! | priority | interrupt | what |
//! |---|---|---|
//! | above all | NMI | the clock has died ([`clock`]): outputs safe, record, reset |
//! | highest | EXTI9_5 | emergency stop: enable low, a few stores |
//! | highest | PVD | the supply drops ([`supply`]): outputs safe, record, reset |
//! | highest | TIM7, 1 kHz | [`block_monitor`]: enable low if blocks are missing |
//! | next | DMA2_STREAM0, 2 kHz | the control task |
//! | below | TIM6_DAC, 1 kHz | the link |

mod block_monitor;
mod clock;
mod flash;
mod pins;
mod registers;
mod reset;
mod sampling;
mod serial;
mod set_points;
mod supply;
mod watchdog;
mod wiring;

use shared::control::Unfit;
use stm32f4xx_hal::{
    gpio::PinState,
    prelude::*,
    timer::{CounterHz, Event, Flag},
};

use crate::hardware::tasks::Board;
pub use crate::hardware::tasks::report::{report_fault, report_panic};
pub use block_monitor::BlockMonitor;
pub use flash::FlashStore;
pub use pins::{ButtonPin, ChainPin, EnablePin, LedPin, Reports, acknowledge_chain, disable};
pub use registers::{Registers, read as registers};
pub use reset::flags as reset_flags;
pub use sampling::AdcSampler;
pub use serial::Serial;
pub use set_points::SetPoints;
pub use stm32f4xx_hal::pac::{self, Peripherals};
pub use supply::{dropped as supply_dropped, is_low as supply_is_low};
pub use watchdog::feed as feed_watchdog;

/// The board's name, as the link gives it.
pub const NAME: &str = "NUCLEO-F446RE";

/// Rate of the link task, Hz.
const LINK_RATE_HZ: u32 = 1_000;

/// Takes the hardware into use. The drive enable is the first thing to be driven, and the watchdog runs before the
/// clocks change. `None` if a timer cannot be set to its rate, which the clocks above rule out.
pub fn set_up(device: Peripherals) -> Option<Board> {
    let mut rcc = device.RCC.constrain();
    let gpioa = device.GPIOA.split(&mut rcc);
    let enable = gpioa.pa8.into_push_pull_output_in_state(PinState::Low);
    watchdog::start(&device.IWDG, &device.DBGMCU);
    let gpiob = device.GPIOB.split(&mut rcc);
    let gpioc = device.GPIOC.split(&mut rcc);
    let chain = gpiob.pb5.into_pull_up_input();
    let strap = gpioa.pa10.into_pull_up_input();
    let button = gpioc.pc13.into_input();
    // On the power-up clock still, and before the pins become analogue.
    let inputs = (
        gpioa.pa0.into_input(),
        gpioa.pa1.into_input(),
        gpiob.pb0.into_input(),
    );
    let (sensors, sensors_wired) = wiring::probe(inputs);
    let wired = sensors_wired || chain.is_low();
    let bench_asked = strap.is_low() || button.is_low();

    let (mut rcc, crystal) = clock::start(rcc, &device.TIM11);
    feed_watchdog();
    let mut exti = device.EXTI;
    let mut syscfg = device.SYSCFG.constrain(&mut rcc);
    // A debugger that halts the processor also halts the set-points.
    device
        .DBGMCU
        .apb1_fz()
        .modify(|_, w| w.dbg_tim2_stop().set_bit());

    let set_points = SetPoints::new(
        device.DAC,
        &device.DMA1,
        device.TIM3,
        (gpioa.pa4.into_analog(), gpioc.pc7),
        &mut rcc,
    );
    let mut sampler = AdcSampler::new(device.TIM2, device.ADC1, device.DMA2, &sensors, &mut rcc);
    let unfit = supply::watch(&device.PWR, &device.FLASH, &exti)
        .and(Unfit::CLOCK.when(!crystal))
        .and(Unfit::REFERENCE.when(!sampler.reference_is_good()));
    let reports = Reports {
        dropped: gpioa.pa9.into_pull_up_input(),
        ready: gpiob.pb10.into_pull_up_input(),
    };
    let wire = (gpioa.pa2.into_alternate(), gpioa.pa3.into_alternate());
    Some(Board {
        sampler,
        set_points,
        enable: Some(EnablePin(enable)),
        chain: ChainPin::new(chain, &mut syscfg, &mut exti),
        block_monitor: BlockMonitor::new(device.TIM7, &mut rcc),
        serial: Serial::new(device.USART2, device.DMA1, wire, &mut rcc),
        link_timer: LinkTimer::new(device.TIM6.counter_hz(&mut rcc))?,
        store: FlashStore::new(device.FLASH),
        led: LedPin(gpioa.pa5.into_push_pull_output()),
        button: ButtonPin(button),
        bench_asked,
        wired,
        reports,
        unfit,
    })
}

/// TIM6, interrupting once per millisecond.
pub struct LinkTimer(CounterHz<pac::TIM6>);

impl LinkTimer {
    fn new(mut timer: CounterHz<pac::TIM6>) -> Option<Self> {
        timer.start(LINK_RATE_HZ.Hz()).ok()?;
        timer.listen(Event::Update);
        Some(Self(timer))
    }

    /// Clears the interrupt; to be called first in it.
    #[inline]
    pub fn acknowledge(&mut self) {
        self.0.clear_flags(Flag::Update);
    }
}

/// Switches the drive off, from anywhere, whatever state the program is in: enable first, then set-points.
pub fn make_outputs_safe() {
    disable();
    set_points::make_safe();
}
