//! NUCLEO-G474RE: everything of the board that the tasks need, set up and safe. It drives nothing: see README.md.
//!
//! The pins are those of the NUCLEO-F446RE, so that the wiring of docs/wiring.md fits.
//!
//! | pin | Arduino | what | safe level |
//! |---|---|---|---|
//! | PA0 | A0 | force, 0.1 to 3.2 V (ADC1 input 1) | – |
//! | PA1 | A1 | hammer displacement (ADC1 input 2) | – |
//! | PB0 | A3 | cart displacement (ADC1 input 15) | – |
//! | PA4 | A2 | shaker's set-point (DAC1 output 1) | 1.65 V, the middle |
//! | PC7 | D9 | motor drive's frequency, duty cycle (TIM3 channel 2) | low |
//! | PA8 | D7 | drive enable: held low | low |
//! | PB5 | D4 | emergency-stop chain, closed to ground | high: open |
//! | PA9 | D8 | the enable's relay has dropped, closed to ground | – |
//! | PB10 | D6 | the power stage is ready, closed to ground | – |
//! | PA10 | D2 | bench strap, to ground for bench mode | – |
//! | PC13 | – | user button B1; either level may be the pressed one | – |
//! | PA5 | – | user LED LD2 | any |
//! | PA2, PA3 | – | link: USART2 through the debugger's serial port | – |
//!
//! | priority | interrupt | what |
//! |---|---|---|
//! | above all | NMI | the clock has died, or flash holds a damaged word ([`clock`]) |
//! | highest | EXTI9_5 | emergency stop: enable low, a few stores |
//! | highest | PVD_PVM | the supply drops ([`supply`]): outputs safe, record, reset |
//! | highest | TIM7, 1 kHz | [`ticks`]: enable low if blocks are missing |
//! | next | DMA1_CH1, 2 kHz | the control task |
//! | below | TIM6_DACUNDER, 1 kHz | the link |

mod clock;
mod dma;
mod flash;
mod pins;
mod sampling;
mod serial;
mod set_points;
mod supply;
mod ticks;
mod watchdog;

use shared::control::Unfit;

pub use crate::hardware::tasks::report::{report_fault, report_panic};
use crate::{hardware::tasks::Board, reset::Flags};
pub use flash::Store;
pub use pins::{ButtonPin, Chain, EnablePin, LedPin, Reports, acknowledge_chain, disable};
pub use sampling::Sampler;
pub use serial::Serial;
pub use set_points::SetPoints;
pub use stm32g4::stm32g474::{self as pac, Peripherals};
pub use supply::dropped as supply_dropped;
pub use ticks::{BlockMonitor, LinkTimer};
pub use watchdog::{Watchdog, feed as feed_watchdog};

/// The board's name, as the link gives it.
pub const NAME: &str = "NUCLEO-G474RE";

/// Takes the hardware into use. The drive's enable is the first thing to be driven, low, and stays so: nobody is given it
/// ([`EnablePin`]). The watchdog runs before the clocks change. There is always a board.
pub fn set_up(device: Peripherals) -> Option<Board> {
    let rcc = &device.RCC;
    pins::start(rcc, &device.GPIOA);
    let mut watchdog = Watchdog::start(&device.IWDG);
    // On the power-up clock still, and before the pins become analogue.
    let (sensors_wired, strapped) = pins::probe(&device.GPIOA, &device.GPIOB);
    clock::peripherals(rcc);
    let chain = Chain::new(&device.SYSCFG, &device.EXTI);
    let wired = sensors_wired || !chain.is_open();

    let crystal = clock::start(rcc, &device.PWR, &device.FLASH);
    watchdog.feed();
    pins::connect(&device.GPIOA, &device.GPIOC);
    // A debugger that halts the processor also halts the set-points.
    device
        .DBGMCU
        .apb1l_fz()
        .modify(|_, w| w.dbg_timer2_stop().set_bit());

    let set_points = SetPoints::new(device.DAC1, device.TIM3);
    let mut sampler = Sampler::new(device.TIM2, device.ADC1, &device.ADC12_COMMON);
    let unfit = supply::watch(&device.PWR, &device.EXTI)
        .and(Unfit::UNTRIED)
        .and(Unfit::CLOCK.when(!crystal))
        .and(Unfit::REFERENCE.when(!sampler.reference_is_good()));
    Some(Board {
        sampler,
        set_points,
        enable: None,
        chain,
        block_monitor: BlockMonitor::new(device.TIM7),
        serial: Serial::new(device.USART2),
        link_timer: LinkTimer::new(device.TIM6),
        store: Store::new(device.FLASH),
        led: LedPin::new(),
        button: ButtonPin::new(),
        bench_asked: strapped,
        wired,
        reports: Reports::new(),
        watchdog,
        unfit,
    })
}

/// Reads and clears why the part was reset; to be called once, at the start. It has one flag for power coming on and for
/// brown-out, so only the memory that outlives a reset can tell them apart.
pub fn reset_flags(rcc: &pac::RCC) -> Flags {
    let csr = rcc.csr().read();
    let flags = Flags {
        watchdog: csr.iwdgrstf().bit() || csr.wwdgrstf().bit(),
        software: csr.sftrstf().bit(),
        power_on: csr.borrstf().bit(),
        brown_out: false,
        pin: csr.pinrstf().bit(),
    };
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    flags
}

/// Switches the drive off, from anywhere, whatever state the program is in: enable first, then set-points.
pub fn make_outputs_safe() {
    disable();
    set_points::make_safe();
}
